#!/bin/sh
# flight_sun's GeoJSON draws the night over the whole flight, and the day, too.
#
# flight_sun 0.1.0, generate_geojson, a flight from London to Perth, day, night and day; skyfield 1.53, ephemeris of
# skyfield-data 7.0.0. Guess: each segment's line runs from its start to its end. Seen: all three lines are the whole
# flight, 996 points each; their times are right. On a map the last one covers the others. Exits 1 if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q flight_sun==0.1.0 skyfield==1.53 skyfield-data==7.0.0 airportsdata==20250909
cd "$folder"
cp "$(find venv -name de421.bsp | head -1)" .
./venv/bin/python - <<'PY'
from datetime import datetime, timezone
from importlib.metadata import version

from flight_sun.flight import Flight
from flight_sun.geo import Coordinate
from flight_sun.visualisation import generate_geojson

start, end = datetime(2023, 2, 11, 11, 50, tzinfo=timezone.utc), datetime(2023, 2, 12, 4, 25, tzinfo=timezone.utc)
flight = Flight(Coordinate(51.47, -0.46), Coordinate(-31.94, 115.97), start, end)
segments = flight.light_segments
legs = [(segment.sun_up, round(segment.time_delta.total_seconds() / 60)) for segment in segments]
features = generate_geojson(segments)["features"]
lines = [len(feature["geometry"]["coordinates"]) for feature in features]
print(f"flight_sun {version('flight_sun')}: sun up and minutes {legs} of {len(flight.path)} points; lines of {lines}")
as_seen = len(legs) == 3 and lines == [len(flight.path)] * 3 and all(minutes < 900 for _, minutes in legs)
raise SystemExit(0 if as_seen else 1)
PY
