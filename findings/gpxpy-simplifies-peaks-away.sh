#!/bin/sh
# gpxpy's simplify takes the highest part out of a straight flight.
#
# gpxpy 1.6.2, GPX.simplify(1), for at most 1 m. Guess: the distance counts the height, as length_3d does. Seen: of a
# track at 30, 30, 150, 30 and 30 m only the ends are left, and get_elevation_extremes gives 30 m for both. Exits 1 if
# that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q gpxpy==1.6.2
cd "$folder"
./venv/bin/python - <<'PY'
from importlib.metadata import version

from gpxpy import gpx

flight = gpx.GPX()
flight.tracks.append(gpx.GPXTrack())
flight.tracks[0].segments.append(gpx.GPXTrackSegment())
for n, height in enumerate((30, 30, 150, 30, 30)):
    flight.tracks[0].segments[0].points.append(gpx.GPXTrackPoint(47, 8 + n / 100, elevation=height))
before = flight.get_elevation_extremes()
flight.simplify(1)
points, after = flight.get_points_no(), flight.get_elevation_extremes()
print(f"gpxpy {version('gpxpy')}: heights {tuple(before)} m, after simplify(1) {tuple(after)}, {points} points")
raise SystemExit(0 if tuple(after) == (30, 30) and points == 2 else 1)
PY
