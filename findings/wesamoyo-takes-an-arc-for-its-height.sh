#!/bin/sh
# wesamoyo-geotools finds a radius of 64 m for an arc of a circle of 100 m.
#
# wesamoyo-geotools 1.2.0, COGO.curve_radius ("from chord and arc length"). Guess: a chord of 100 m and an arc of
# 104.72 m, 60 degrees of a circle, have the radius 100 m. Seen: 64.3 m; a half circle has 173 m. The formula is that of
# chord and height of an arc, with the length as the height: 10 of chord and 1 of height give 13, rightly, where the
# arc is refused, as it is shorter than the chord. Exits 1 if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q wesamoyo-geotools==1.2.0
cd "$folder"
./venv/bin/python - <<'PY'
import math
from importlib.metadata import version

from wesamoyo_geotools.cogo import COGO

sixth, half = COGO.curve_radius(100.0, 100 * math.pi / 3), COGO.curve_radius(200.0, 100 * math.pi)
print(f"wesamoyo-geotools {version('wesamoyo-geotools')}: radius 100 m is {sixth:.1f} and {half:.1f} m")
raise SystemExit(0 if (round(sixth, 1), round(half, 1)) == (64.3, 173.0) else 1)
PY
