#!/bin/sh
# udaan's straight trajectory of 100 m in 20 s has a speed of 100 m/s.
#
# udaan 1.3.0, SmoothTraj1, 3 and 5, PolyTraj5 and SmoothSineTraj. Guess: the velocity beside a position is the slope of
# the positions, 5 m/s for the straight one. Seen: 20 times that, as it is the slope by the part of the duration and
# not by time; only the sine's is right. PolyTraj5, with 5 m/s at its ends, begins at 0.25 m/s. A controller follows
# the position and the velocity at once. Exits 1 if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q --no-deps udaan==1.3.0 numpy==2.3.5
cd "$folder"
./venv/bin/python - <<'PY'
from importlib.metadata import distribution, version
from importlib.util import module_from_spec, spec_from_file_location

import numpy as np

spec = spec_from_file_location("trajectory", distribution("udaan").locate_file("udaan/utils/trajectory/trajectory.py"))
trajectory = module_from_spec(spec)
spec.loader.exec_module(trajectory)
START, END = np.zeros(3), np.array([100.0, 0.0, 0.0])


def ratio(name):
    """The velocity given at 5 of 20 s over the slope of the positions there."""
    path = getattr(trajectory, name)(START, END, 20.0)
    slope = (path.get(5.001)[0] - path.get(4.999)[0]) / 0.002
    return round(float(path.get(5.0)[1][0] / slope[0]), 2)


seen = {name: ratio(name) for name in ("SmoothTraj1", "SmoothTraj3", "SmoothTraj5", "PolyTraj5", "SmoothSineTraj")}
speed = np.array([5.0, 0.0, 0.0])
path = trajectory.PolyTraj5(START, END, 20.0, v0=speed, vf=speed)
begins = round(float((path.get(0.002)[0] - path.get(0.001)[0])[0] / 0.001), 2)
print(f"udaan {version('udaan')}: velocity over slope {seen}; a start at 5 m/s is one at {begins} m/s")
raise SystemExit(0 if list(seen.values()) == [20, 20, 20, 20, 1] and begins == 0.25 else 1)
PY
