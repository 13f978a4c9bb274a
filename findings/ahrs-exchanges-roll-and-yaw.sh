#!/bin/sh
# AHRS's DCM takes a roll for a yaw, its Quaternion does not.
#
# AHRS 0.4.0, DCM(rpy=...) and Quaternion(rpy=...), both documented as roll, pitch, yaw. Guess: both give one attitude.
# Seen: DCM(rpy=(30, 0, 0)) is a yaw of 30 degrees, in its own to_quaternion, too; Quaternion(rpy=(30, 0, 0)) is a roll.
# For 10, 20 and 30 degrees they are 33 degrees apart. Exits 1 if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q ahrs==0.4.0 numpy==2.4.6
cd "$folder"
./venv/bin/python - <<'PY'
from importlib.metadata import version

import numpy as np
from ahrs import DCM, Quaternion


def angles(rotation):
    return [round(float(angle)) for angle in np.degrees(Quaternion(rotation).to_angles())]


rolled, climbing = np.radians([30, 0, 0]), np.radians([10, 20, 30])
by_matrix, by_quaternion = angles(DCM(rpy=rolled).to_quaternion()), angles(Quaternion(rpy=rolled))
between = np.asarray(DCM(rpy=climbing)).T @ Quaternion(rpy=climbing).to_DCM()
apart = round(float(np.degrees(np.arccos((np.trace(between) - 1) / 2))))
print(f"AHRS {version('ahrs')}, roll 30: DCM {by_matrix}, Quaternion {by_quaternion}; apart {apart} degrees")
raise SystemExit(0 if (by_matrix, by_quaternion, apart) == ([0, 0, 30], [30, 0, 0], 33) else 1)
PY
