#!/bin/sh
# py1090 points to the south for an aircraft in the north, and makes 6.67 m/s of a knot.
#
# py1090 1.1, helpers.bearing_between and knots_to_mps. Guess: from 47 N, 8 E to one degree north, east, south and west
# are 0, 90, 180 and -90 degrees to one, as of geographiclib 2.1; a knot is 0.514 m/s. Seen: 180, 90, 0 and -90: the
# bearing is mirrored, as its documented formula is, so that two of four are right; 3.6 multiplies km/h. Exits 1 if that
# changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q py1090==1.1 geographiclib==2.1
cd "$folder"
./venv/bin/python - <<'PY'
import math
from importlib.metadata import version

from geographiclib.geodesic import Geodesic
from py1090 import helpers

there = (48, 8), (47, 9), (46, 8), (47, 7)
seen = [round(math.degrees(helpers.bearing_between(47, 8, *place))) for place in there]
expected = [round(Geodesic.WGS84.Inverse(47, 8, *place)["azi1"]) for place in there]
knot = round(helpers.knots_to_mps(1), 3)
print(f"py1090 {version('py1090')}: north, east, south and west {seen}, geographiclib {expected}; a knot {knot} m/s")
as_seen = seen == [180, 90, 0, -90] and [abs(bearing) for bearing in expected] == [0, 90, 180, 90]
raise SystemExit(0 if as_seen and knot == 6.667 else 1)
PY
