#!/bin/sh
# The true wind that nmeatoolkit makes of one relative wind is 10.5 to 25 knots, by the course of the ship.
#
# nmeatoolkit 0.2 with pynmea2 1.19.0, TrueWindPipe, fed HDT, VTG of 10 knots and MWV of 20 knots at 45 degrees to the
# bow. Guess: 14.7 knots at 74 degrees on each course, as vectors give it, with the unit N. Seen: 11.3 on a course of 10
# degrees, 25 on 180 and 270, 10.5 on 350, and none on 0; the unit is "k", as if in km/h. Exits 1 if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q nmeatoolkit==0.2 pynmea2==1.19.0 python-dateutil==4.0.0
cd "$folder"
./venv/bin/python - <<'PY'
import math
from importlib.metadata import version

import pynmea2
from nmeatoolkit.pipes.truewind import TrueWindPipe


def true(course):
    pipe = TrueWindPipe()
    for sentence in (
        pynmea2.HDT("II", "HDT", (course, "T")),
        pynmea2.VTG("II", "VTG", (course, "T", "", "M", "10.0", "N", "18.5", "K")),
        pynmea2.MWV("II", "MWV", ("45.0", "R", "20.0", "N", "A")),
    ):
        found = pipe.transform(pynmea2.parse(str(sentence)))[1:]
    return [(float(wind.wind_speed), wind.wind_speed_units) for wind in found]


seen = {course: true(course) for course in ("0.0", "10.0", "180.0", "270.0", "350.0")}
ahead, abeam = 20 * math.cos(math.radians(45)) - 10, 20 * math.sin(math.radians(45))
expected = round(math.hypot(ahead, abeam), 1)
print(f"nmeatoolkit {version('nmeatoolkit')}: true wind by course {seen}, expected {expected} on each")
as_seen = [[], [(11.32, "k")], [(25.03, "k")], [(25.03, "k")], [(10.53, "k")]]
raise SystemExit(0 if [*seen.values()] == as_seen and expected == 14.7 else 1)
PY
