#!/bin/sh
# pymap3d's rhumb line from Fiji to its neighbor goes round the Earth.
#
# pymap3d 3.2.0, lox.loxodrome_inverse. Guess: from 179.9 E to 179.9 W it is 22 km to the east at the equator, as its
# vincenty.vdist has it. Seen: 20,015 km to the west, at Fiji's 17 S 19,146 km instead of 21; from 8 to 8.2 E both
# agree. Exits 1 if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q pymap3d==3.2.0 numpy==2.4.6
cd "$folder"
./venv/bin/python - <<'PY'
from importlib.metadata import version

from pymap3d import lox, vincenty


def both(west, east, latitude):
    ends = (latitude, west, latitude, east)
    lines = (lox.loxodrome_inverse(*ends), vincenty.vdist(*ends))
    return [(round(float(length) / 1000), round(float(course))) for length, course in lines]


seen = {place: both(*place) for place in [(8.0, 8.2, 0.0), (179.9, -179.9, 0.0), (179.9, -179.9, -17.0)]}
print(f"pymap3d {version('pymap3d')}, km and course of rhumb line and great circle: {seen}")
near, equator, fiji = seen.values()
as_seen = near == [(22, 90), (22, 90)] and equator[0] == (20015, 270) and fiji == [(19146, 270), (21, 90)]
raise SystemExit(0 if as_seen else 1)
PY
