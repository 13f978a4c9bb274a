#!/bin/sh
# py-imu's tilt compensated heading is 8 degrees off at 20 degrees of bank and pitch, 20 at 30.
#
# py-imu 0.1.0, rpymag2h and qmag2h, on exact readings of an accelerometer and a magnetometer, in a field of 20 uT to
# the north and 45 uT down. Guess: the heading is 60 degrees in each attitude, as the yaw of its accelmag2rpy is. Seen:
# with 20 degrees of pitch and 20 of left bank 68 degrees, with 30 and 30 80 degrees, from both; with pitch or bank
# alone, 60. Exits 1 if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q py-imu==0.1.0 numpy==2.4.6
cd "$folder"
./venv/bin/python - 2>/dev/null <<'PY'
import math
from importlib.metadata import version

import numpy as np
from py_imu.fusion.quaternion import Vector3D
from py_imu.fusion.utilities import accelmag2q, accelmag2rpy, qmag2h, rpymag2h


def turn(axis, degrees):
    """Rotation about one axis."""
    first, second = (axis + 1) % 3, (axis + 2) % 3
    matrix = np.eye(3)
    cosine, sine = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    matrix[[first, first, second, second], [first, second, first, second]] = cosine, -sine, sine, cosine
    return matrix


def headings(roll, pitch, yaw=60):
    """Of accelmag2rpy, rpymag2h and qmag2h, in degrees."""
    body = (turn(2, yaw) @ turn(1, pitch) @ turn(0, roll)).T
    gravity, field = Vector3D(*body @ (0, 0, 9.81)), Vector3D(*body @ (20, 0, 45))
    angles, attitude = accelmag2rpy(gravity, field), accelmag2q(gravity, field)
    found = angles.z, rpymag2h(angles, field), qmag2h(attitude, field)
    return [round(math.degrees(angle)) for angle in found]


seen = [headings(*angles) for angles in ((-20, 20), (-30, 30), (-20, 0), (0, 20))]
print(f"py-imu {version('py-imu')}, accelmag2rpy, rpymag2h, qmag2h: bank and pitch of 20 {seen[0]}, of 30 {seen[1]},")
print(f"bank or pitch alone {seen[2:]}")
raise SystemExit(0 if seen[:2] == [[60, 68, 68], [60, 80, 80]] and seen[2:] == [[60] * 3] * 2 else 1)
PY
