#!/bin/sh
# toppra's trajectory exceeds its limit of acceleration by 10 %.
#
# toppra 0.6.10, TOPPRA.compute_trajectory of a spline through four waypoints, from rest to rest; 10 m/s and 3 m/s2 in
# each axis. Guess: the limits are kept within 1 %. Seen: 3.30 m/s2 by default, in 801 to 805 grid points; 3.00 with
# parametrizer="ParametrizeConstAccel". Exits 1 if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q toppra==0.6.10 numpy==2.4.6 scipy==1.17.1
cd "$folder"
./venv/bin/python -W ignore - <<'PY'
from importlib.metadata import version

import numpy as np
import toppra

toppra.setup_logging("ERROR")
waypoints = [[0, 0], [50, 0], [50, 50], [100, 60]]
path = toppra.SplineInterpolator(np.linspace(0, 1, 4), np.array(waypoints, dtype=float))
limits = [
    toppra.constraint.JointVelocityConstraint(np.array([[-10.0, 10.0]] * 2)),
    toppra.constraint.JointAccelerationConstraint(np.array([[-3.0, 3.0]] * 2)),
]


def most(**options):
    flight = toppra.algorithm.TOPPRA(limits, path, **options).compute_trajectory(0, 0)
    times = np.linspace(0, flight.duration, 20001)
    return tuple(round(float(np.abs(flight(times, order)).max()), 2) for order in (1, 2))


default, constant = most(), most(parametrizer="ParametrizeConstAccel")
print(f"toppra {version('toppra')}, most m/s and m/s2: {default}; with ParametrizeConstAccel {constant}")
raise SystemExit(0 if default[1] > 3.2 and constant[1] <= 3.01 else 1)
PY
