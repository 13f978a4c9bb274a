#!/bin/sh
# elkai plans a tour of waypoints in kilometers 59 % longer than in meters.
#
# elkai 2.0.1 (LKH 3), Coordinates2D and DistanceMatrix. Guess: the unit changes nothing in the order. Seen: distances
# are rounded to whole numbers, nothing said. 20 places within a kilometer are visited on 4.13 km in meters and on
# 6.57 km in kilometers; in degrees of latitude all legs are 0 and the order is arbitrary. Exits 1 if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q elkai==2.0.1
cd "$folder"
./venv/bin/python - <<'PY'
import math
import random
from importlib.metadata import version

import elkai

random.seed(1)
places = [(random.random(), random.random()) for _ in range(20)]


def length(order):
    return round(sum(math.dist(places[a], places[b]) for a, b in zip(order, order[1:])), 2)


def toured(units_a_km):
    scaled = {n: (x * units_a_km, y * units_a_km) for n, (x, y) in enumerate(places)}
    by_place = length(elkai.Coordinates2D(scaled).solve_tsp())
    matrix = [[math.dist(a, b) for b in scaled.values()] for a in scaled.values()]
    return by_place, length(elkai.DistanceMatrix(matrix).solve_tsp())


meters, kilometers, degrees = toured(1000), toured(1), toured(1 / 111)
print(f"elkai {version('elkai')}, tours [km]: meters {meters}, kilometers {kilometers}, degrees {degrees}")
as_seen = meters == (4.13, 4.13) and min(kilometers) > 6 and min(degrees) > 6
raise SystemExit(0 if as_seen else 1)
PY
