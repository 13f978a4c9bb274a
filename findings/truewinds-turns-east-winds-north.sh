#!/bin/sh
# truewinds turns a wind from the east into a wind from the north, for some courses.
#
# truewinds 0.0.4, truewinds.compute_true_winds: course, speed, heading and relative wind give the true wind. Guess: 72
# courses and speeds in an east wind of 10 m/s, without noise, give 90 degrees each. Seen: several give 0 degrees, u 0
# and v -10, as the one of 10 m/s to 30 degrees. A north component that rounds to -1e-15 instead of 1e-15 makes it 450
# degrees; a flag of calms, which one component of 0 sets, makes that 0. A true wind from 90.1 is always right.
# Exits 1 if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q truewinds==0.0.4 numpy==2.4.6
cd "$folder"
./venv/bin/python -W ignore - <<'PY'
import math
from importlib.metadata import version

from truewinds.truewinds import compute_true_winds


def found(source, course, speed):
    wind, way = math.radians(source), math.radians(course)
    east = 10 * math.sin(wind) + speed * math.sin(way)
    north = 10 * math.cos(wind) + speed * math.cos(way)
    relative = (math.degrees(math.atan2(east, north)) - course) % 360
    wind = compute_true_winds(float(course), speed, float(course), relative, math.hypot(east, north))
    return round(wind["true_wind_direction"]) % 360, round(wind["v_true_wind"]) + 0


flown = [(course, speed) for course in range(0, 360, 15) for speed in (5.0, 8.0, 12.0)]
east, next_to = [[found(source, *leg) for leg in flown] for source in (90, 90.1)]
turned = east.count((0, -10))
print(f"truewinds {version('truewinds')}: of {len(flown)} east winds {turned} are from the north, and none from 90.1")
raise SystemExit(0 if turned and turned + east.count((90, 0)) == 72 and next_to == [(90, 0)] * 72 else 1)
PY
