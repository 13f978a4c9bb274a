#!/bin/sh
# pyquaternion's yaw_pitch_roll gives the roll of an aircraft as its pitch.
#
# pyquaternion 0.9.9, scipy 1.17.1 to compose. Its documentation names the angles intrinsic, z-y'-x''. Guess: yaw 90,
# pitch 10 and roll 20 degrees come back. Seen: yaw 90, pitch 20, roll -10; with roll and pitch alone each is right.
# Exits 1 if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q pyquaternion==0.9.9 scipy==1.17.1 numpy==2.4.6
cd "$folder"
./venv/bin/python - <<'PY'
from importlib.metadata import version

import numpy as np
from pyquaternion import Quaternion
from scipy.spatial.transform import Rotation


def read(yaw, pitch, roll):
    x, y, z, w = Rotation.from_euler("ZYX", (yaw, pitch, roll), degrees=True).as_quat()
    return [round(float(angle)) for angle in np.degrees(Quaternion(w, x, y, z).yaw_pitch_roll)]


attitude, single = read(90, 10, 20), (read(0, 10, 0), read(0, 0, 20))
print(f"pyquaternion {version('pyquaternion')}: yaw 90, pitch 10, roll 20 is read as {attitude}; one angle: {single}")
raise SystemExit(0 if attitude == [90, 20, -10] and single == ([0, 10, 0], [0, 0, 20]) else 1)
PY
