#!/bin/sh
# grzymala's degrees, minutes and seconds of Sydney come back 190 km further north, those of Quito in the north.
#
# grzymala 1.0.0, deg2dms and its inverse dms2deg. Guess: -33.8585 degrees come back. Seen: deg2dms has -33, 51, 30.6,
# and dms2deg adds the minutes to -33: -32.1415, 190 km away. -0.18 is 0, 10, 48, without a sign, and comes back as
# 0.18, 40 km away. An hour angle of 6 h, 90 degrees, is 1350 degrees for hms2rad. Positive degrees are right. Exits 1
# if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q grzymala==1.0.0 numpy==2.4.6
cd "$folder"
./venv/bin/python - <<'PY'
import math
from importlib.metadata import version

import grzymala

seen = [round(grzymala.dms2deg(grzymala.deg2dms(degrees)), 6) for degrees in (-33.8585, -0.18, 47.25)]
hours = round(math.degrees(grzymala.hms2rad([6, 0, 0])), 6)
print(f"grzymala {version('grzymala')}: -33.8585, -0.18 and 47.25 come back as {seen}; 6 h are {hours} degrees")
raise SystemExit(0 if seen == [-32.1415, 0.18, 47.25] and hours == 1350 else 1)
PY
