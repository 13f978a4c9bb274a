#!/bin/sh
# weatherrouting's rhumb line along the parallel of 60 degrees sets out to the north-east.
#
# weatherrouting 0.2.3, utils.lossodromic ("the lossodromic distance in km", with a course) and utils.ortodromic.
# Guess: from 60 N 10 W to 60 N 50 E the rhumb line is 3336 km (of a sphere), to the east, 90 degrees. Seen: 3220 km at
# 63.4 degrees, distance and course of the great circle, as those of ortodromic. Exits 1 if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q weatherrouting==0.2.3
cd "$folder"
./venv/bin/python - <<'PY'
import math
from importlib.metadata import version

from weatherrouting import utils

(rhumb, course), (great, bearing) = (line(60, -10, 60, 50) for line in (utils.lossodromic, utils.ortodromic))
parallel = 6370.997 * math.cos(math.radians(60)) * math.radians(60)
seen = [round(value, 1) for value in (rhumb, math.degrees(course), great, math.degrees(bearing))]
print(f"weatherrouting {version('weatherrouting')}: km and degrees {seen}; the parallel has {parallel:.1f} km")
raise SystemExit(0 if seen == [3219.7, 63.4, 3231.4, 63.4] else 1)
PY
