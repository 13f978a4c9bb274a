#!/bin/sh
# Slices of a track that gpxslicer makes at multiples of 100 m drift: its 25th cut is at 3000 m.
#
# gpxslicer 0.1.0 with gpxpy 1.6.2, slice_gpx_at_interval(gpx, 100) of a level, straight track of 3000 m with a point
# each 30 m. Its docstring counts "cumulatively, not after the cut point". Guess: cuts at the first points past each
# multiple, 120, 210, 330 and 420 m, 29 in all. Seen: 120, 240, 360 and 480 m, and 25: each counts from the last cut,
# and the sum that is kept is not used. Exits 1 if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q gpxslicer==0.1.0 gpxpy==1.6.2
cd "$folder"
./venv/bin/python - <<'PY'
from importlib.metadata import version

from gpxpy import gpx as exchange
from gpxslicer.slicer import slice_gpx_at_interval

DEGREE = exchange.mod_geo.ONE_DEGREE
track, segment, route = exchange.GPX(), exchange.GPXTrackSegment(), exchange.GPXTrack()
segment.points = [exchange.GPXTrackPoint(47 + meters / DEGREE, 8, elevation=400) for meters in range(0, 3030, 30)]
route.segments.append(segment)
track.tracks.append(route)
cuts = [round((cut.latitude - 47) * DEGREE) for cut in slice_gpx_at_interval(track, 100).waypoints]
expected = [next(meters for meters in range(0, 3030, 30) if meters > far) for far in range(100, 3000, 100)]
print(f"gpxslicer {version('gpxslicer')}: {len(cuts)} cuts, at {cuts[:4]} m; expected {len(expected)}, {expected[:4]}")
raise SystemExit(0 if len(cuts) == 25 and cuts == list(range(120, 3001, 120)) and len(expected) == 29 else 1)
PY
