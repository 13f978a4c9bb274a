#!/bin/sh
# lla_enu's distance of two places is north, east, up, and its shift takes east, north, up: back and forth turns by 90.
#
# lla_enu 0.1.0, distance_enu, which documents [east, north, up], and lla_add_enu. Guess: a place 700 m to the east is
# [700, 0, 0], and added to the first place it gives the second. Seen: [0, 700, 0]; the sum lies 700 m to the north, 990
# m from the place. Exits 1 if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q lla_enu==0.1.0 numpy==2.3.5
cd "$folder"
./venv/bin/python - <<'PY'
from importlib.metadata import version

from lla_enu.utils import distance_enu, distance_lla, lla_add_enu

home = (8.0, 47.0, 100.0)
east = lla_add_enu(*home, 700, 0, 0)
parts = distance_enu(*home, *east)
back = lla_add_enu(*home, *parts)
error = distance_lla(*back, *east)
print(f"lla_enu {version('lla_enu')}: 700 m to the east is {parts.round(1).tolist()}; added {error:.0f} m off")
raise SystemExit(0 if parts.round(1).tolist() == [0, 700, 0] and 985 < error < 995 else 1)
PY
