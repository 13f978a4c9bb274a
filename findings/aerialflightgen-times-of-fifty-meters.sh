#!/bin/sh
# aerialflightgen plans a survey at 5 m/s whose times ask for 210 m/s, over land outside of its area.
#
# aerialflightgen 0.1.2, FlightPlanGenerator(speed=5), whose waypoints have x, y, z and t. Guess: the times are those of
# its legs at that speed, and the waypoints are in the polygon. Seen: each leg takes 10 s, whether it is 2.1 km or 21 m
# long, and half of an L-shaped area's waypoints are outside of it, as the rows fill its bounding box. Exits 1 if that
# changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q aerialflightgen==0.1.2 shapely==2.2.0 pyproj==3.7.2
cd "$folder"
./venv/bin/python - <<'PY'
import json
from importlib.metadata import version

from aerialflightgen import FlightPlanGenerator
from pyproj import Geod
from shapely.geometry import Point, Polygon


def plan(size):
    corner = [(0, 0), (size, 0), (size, size / 4), (size / 4, size / 4), (size / 4, size), (0, size), (0, 0)]
    area = {"type": "Polygon", "coordinates": [corner]}
    with open("area.geojson", "w") as out:
        json.dump({"type": "FeatureCollection", "features": [{"type": "Feature", "geometry": area}]}, out)
    flown = FlightPlanGenerator("area.geojson", altitude=60, speed=5, rows=8).generate_waypoints()
    first, second = flown[:2]
    length = Geod(ellps="WGS84").inv(first["x"], first["y"], second["x"], second["y"])[2]
    outside = sum(not Polygon(corner).buffer(1e-9).covers(Point(each["x"], each["y"])) for each in flown)
    return round(length / (second["t"] - first["t"])), outside, len(flown)


seen = [plan(0.0189), plan(0.000189)]
print(f"aerialflightgen {version('aerialflightgen')}: m/s of a leg, waypoints outside, and all: {seen}")
raise SystemExit(0 if seen == [(210, 6, 16), (2, 6, 16)] else 1)
PY
