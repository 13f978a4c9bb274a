#!/bin/sh
# zenmav scans a circle of 990 m radius by a spiral that is a straight line.
#
# zenmav 0.2.0, Zenmav.spiral_scan. Guess: a spiral whose turns are a detection width apart, here 10 m, sees the circle.
# Seen: it has 100 waypoints, for any radius. With 99 turns each is one turn after the other, and all lie on one line to
# the north; within 10 m of them is 1 % of the circle. With 49.5 turns, of 495 m radius, they go to and fro on a line.
# With 10 turns, its default, it is a spiral. Exits 1 if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q zenmav==0.2.0 pymavlink==2.4.50 shapely==2.1.2 numpy==2.4.6
cd "$folder"
./venv/bin/python - <<'PY'
from contextlib import redirect_stdout
from importlib.metadata import version
from types import SimpleNamespace

from shapely import LineString, Point
from zenmav.core import Zenmav


def scan(radius):
    """Waypoints, their extents to the north and east in meters, and the part of the circle within 10 m of the path."""
    path = []
    vehicle = SimpleNamespace(global_target=lambda waypoint: path.append((waypoint.N, waypoint.E)))
    with redirect_stdout(None):
        Zenmav.spiral_scan(vehicle, detection_width=10, scan_radius=radius, center=[0, 0])
    circle, flown = Point(0, 0).buffer(radius, 64), LineString(path)
    west, south, east, north = flown.bounds
    seen = flown.buffer(10).intersection(circle).area / circle.area
    return len(path), round(east - west), round(north - south), round(100 * seen)


default, wide, half = scan(100), scan(990), scan(495)
print(f"zenmav {version('zenmav')}, waypoints, extents in m, percent seen: 100 m {default}, 990 m {wide}, 495 m {half}")
raise SystemExit(0 if wide == (100, 990, 0, 1) and half[:3] == (100, 985, 0) and default[3] > 95 else 1)
PY
