#!/bin/sh
# JSBSim's wind from 270 degrees comes from the east: a flight to the east has a headwind of 20 ft/s, not a tailwind.
#
# jsbsim 1.3.3, atmosphere/psiw-rad and wind-mag-fps, "the direction that the wind is coming from", by the reference of
# FGWinds, which also says that it increases counterclockwise. Guess: 270 degrees is a west wind, as in a weather
# report, or by the reference an east wind. Seen: neither name fits: psiw is where the wind blows to, clockwise. With 0,
# 90 and 270 degrees it blows to the north, east and west; at 100 ft/s to the east the airspeed with 270 degrees is 120
# ft/s. ic/vw-dir-deg is the same. Exits 1 if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q jsbsim==1.3.3 numpy==2.4.6
cd "$folder"
cat >wind.py <<'PY'
import math
from importlib.metadata import version

import jsbsim


def fly(degrees, initial):
    """Wind to the north and east, and airspeed of a ball that moves east at 100 ft/s, in ft/s."""
    ball = jsbsim.FGFDMExec(None)
    ball.set_debug_level(0)
    ball.load_model("ball")
    ball["ic/h-sl-ft"], ball["ic/lat-geod-deg"] = 3000, 47
    if initial:
        ball["ic/vw-mag-fps"], ball["ic/vw-dir-deg"] = 20, degrees
    ball["ic/vn-fps"], ball["ic/ve-fps"] = 0, 100
    ball.run_ic()
    if not initial:
        ball["atmosphere/wind-mag-fps"], ball["atmosphere/psiw-rad"] = 20, math.radians(degrees)
    ball.run()
    names = "atmosphere/wind-north-fps", "atmosphere/wind-east-fps", "velocities/vtrue-fps"
    return [round(ball[name]) + 0 for name in names]


seen = [fly(degrees, initial=False) for degrees in (0, 90, 270)]
first = fly(270, initial=True)
print(f"jsbsim {version('jsbsim')}, wind north and east and airspeed with 0, 90 and 270 degrees: {seen};")
print(f"with 270 degrees as an initial condition {first}")
expected = [[20, 0], [0, 20], [0, -20]]
as_seen = [wind[:2] for wind in seen] == expected and [wind[2] for wind in seen[1:]] == [80, 120]
raise SystemExit(0 if as_seen and first == [0, -20, 120] else 1)
PY
./venv/bin/python wind.py >seen 2>errors || fails=1
tail -2 seen
[ -z "$fails" ]
