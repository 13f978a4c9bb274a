#!/bin/sh
# freefall slows an object that moves at 45 degrees by 71 % of the drag of one that moves level as fast.
#
# freefall 1.0.0b1, simulate_earth_surface, its power cell of 0.15 kg at 20 m/s. Guess: the drag goes by the square of
# the speed and against it, whatever its direction. Seen: each axis has the square of its own speed alone. At 45 degrees
# the drag is 4.15 for 5.87 m/s2. Released at 20 m/s, 100 m above the ground, it lands at 66.7 m, and by the drag of its
# speed at 57.0 m. Exits 1 if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q freefall==1.0.0b1
cd "$folder"
./venv/bin/python - <<'PY'
from importlib.metadata import version
from math import cos, hypot, radians, sin

from freefall.falling_objects import frc_power_cell as cell
from freefall.simulators import simulate_earth_surface

STEP = 0.001


def drag(degrees):
    """The deceleration in the first step, without gravity."""
    speeds = {"vx_initial": 20 * cos(radians(degrees)), "vy_initial": 20 * sin(radians(degrees))}
    flown = simulate_earth_surface(cell, 0, 100, gravity=0, terminator=lambda *_: True, **speeds)
    return round(hypot(flown.ax[-1], flown.ay[-1]), 2)


def range_by_speed():
    x, y, vx, vy = 0.0, 100.0, 20.0, 0.0
    while y >= 0:
        factor = hypot(vx, vy) * cell.drag / cell.mass
        vx -= vx * factor * STEP
        vy -= (vy * factor + 9.81) * STEP
        x += vx * STEP
        y += vy * STEP
    return round(x, 1)


seen = {degrees: drag(degrees) for degrees in (0, 45, -45, 90)}
lands = [round(simulate_earth_surface(cell, 0, 100, vx_initial=20).x[-1], 1), range_by_speed()]
print(f"freefall {version('freefall')}: drag in m/s2 by direction {seen}; lands at {lands[0]} m, by speed {lands[1]} m")
raise SystemExit(0 if list(seen.values()) == [5.87, 4.15, 4.15, 5.87] and lands == [66.7, 57.0] else 1)
PY
