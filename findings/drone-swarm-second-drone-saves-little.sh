#!/bin/sh
# drone-swarm divides a survey so that each of two drones flies nearly as far as one would alone.
#
# drone-swarm 0.1.1, missions.polygon_sweep ("number of drones to split the work across"), 500 by 200 m, lines of 20 m.
# Guess: two drones fly half of it each, three a third. Seen: 5640 m for one, 5004 and 5055 m for two, 2300 m for three.
# Each second line goes back, and two drones take each second line: both fly all of theirs in one direction. In a
# U-shaped area 790 m of one drone's path are outside. Exits 1 if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q drone-swarm==0.1.1 shapely==2.2.0
cd "$folder"
./venv/bin/python - <<'PY'
import math
from importlib.metadata import version

from drone_swarm.missions import polygon_sweep
from shapely.geometry import LineString, Polygon

NORTH, EAST = 111_320.0, 111_320.0 * math.cos(math.radians(47))


def sweep(area, drones):
    flown = polygon_sweep([(47 + y / NORTH, 8 + x / EAST) for x, y in area], 30.0, drones, line_spacing_m=20.0)
    return [LineString([((each.lon - 8) * EAST, (each.lat - 47) * NORTH) for each in path]) for path in flown]


field = [(0, 0), (500, 0), (500, 200), (0, 200)]
lengths = [[round(path.length, -1) for path in sweep(field, drones)] for drones in (1, 2, 3)]
shape = [(0, 0), (300, 0), (300, 200), (200, 200), (200, 60), (100, 60), (100, 200), (0, 200)]
outside = round(sweep(shape, 1)[0].difference(Polygon(shape).buffer(0.5)).length, -1)
print(f"drone-swarm {version('drone-swarm')}: {lengths} m of one, two and three drones; {outside} m outside of a U")
as_seen = lengths[0] == [5640] and min(lengths[1]) > 4900 and max(lengths[2]) < 2300 and outside > 700
raise SystemExit(0 if as_seen else 1)
PY
