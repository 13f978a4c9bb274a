#!/bin/sh
# gpsd's MeterOffset gives the way back: south-west for a place to the north-east.
#
# gps 3.19 of PyPI (gpsd's client), misc.MeterOffset, documented as the offset of the second from the first. Guess: east
# 76 m and north 111 m. Seen: -76 and -111; across 180 degrees the sign changes, +223 m for a place to the east. Exits 1
# if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q gps==3.19
cd "$folder"
./venv/bin/python - <<'PY'
import gps
from gps import misc

seen = [round(value) for value in misc.MeterOffset((47.0, 8.0), (47.001, 8.001))]
across = [round(value) for value in misc.MeterOffset((0.0, 179.999), (0.0, -179.999))]
print(f"gps {gps.__version__}, {misc.MeterOffset.__doc__!r}: {seen}, across 180 degrees {across}")
raise SystemExit(0 if seen == [-76, -111] and across == [223, 0] else 1)
PY
