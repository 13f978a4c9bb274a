#!/bin/sh
# pyopenair moves the corner of an airspace by up to 30 m, and fills the hole of a zone.
#
# pyopenair 1.2.1, wkt2openair. Guess: seconds are rounded or have decimals, 47.6 seconds are 48 or 47.6. Seen: they are
# cut to 47, toward the equator and Greenwich, 19 m here; the hole is left out without a word. To the west the degrees
# are negative as well, -1:30:00 W, which readers of OpenAir refuse. Exits 1 if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q pyopenair==1.2.1 shapely==2.2.0 numpy==2.4.1
cd "$folder"
./venv/bin/python - <<'PY'
from importlib.metadata import version

from pyopenair.factory import wkt2openair

SECOND = 1 / 3600
north = 47 + 47.6 * SECOND
outer = f"8 {north}, 9 {north}, 9 48, 8 48, 8 {north}"
east = wkt2openair(f"POLYGON(({outer}), (8.4 47.4, 8.6 47.4, 8.5 47.6, 8.4 47.4))", an="Z", ac="R").splitlines()
west = wkt2openair("POLYGON((-1.5 47, -1.4 47, -1.4 48, -1.5 47))", an="Z", ac="R").splitlines()
corners, first_west = [line for line in east if line.startswith("DP")], next(w for w in west if w.startswith("DP"))
print(f"pyopenair {version('pyopenair')}: 47.6 seconds are {corners[0]}; {len(corners)} corners; west {first_west}")
as_seen = "47:00:47 N" in corners[0] and len(corners) == 4 and first_west.endswith("-1:30:00 W")
raise SystemExit(0 if as_seen else 1)
PY
