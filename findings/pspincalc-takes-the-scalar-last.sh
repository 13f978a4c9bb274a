#!/bin/sh
# PSpincalc turns by 208 degrees for 36: its Euler vectors take the last part of a quaternion for the scalar.
#
# PSpincalc 0.2.7, EA2Q, EA2EV and EV2EA. Guess: yaw 30, pitch 20 and roll 10 degrees are a turn by 35.8 degrees round
# one axis, as scipy 1.17.1 has it, and come back from it. Seen: EA2Q has the scalar first, and is right; EA2EV reads
# it last, gives 207.7 degrees round another axis, and EV2EA makes yaw 10, pitch -20 and roll 150 degrees of it.
# Exits 1 if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q PSpincalc==0.2.7 numpy==2.4.6 scipy==1.17.1
cd "$folder"
./venv/bin/python -W ignore - <<'PY'
from importlib.metadata import version

import numpy as np
from PSpincalc import PSpincalc
from scipy.spatial.transform import Rotation

angles = np.radians([30.0, 20.0, 10.0])
turn = Rotation.from_euler("ZYX", angles)
quaternion = PSpincalc.EA2Q(angles.copy())[0]
vector = PSpincalc.EA2EV(angles.copy())
back = np.degrees(PSpincalc.EV2EA(vector.copy()))[0].round(1).tolist()
seen = round(float(np.degrees(vector[0, 3])), 1)
print(f"PSpincalc {version('PSpincalc')}: {np.degrees(turn.magnitude()):.1f} degrees are {seen}; 30, 20, 10 are {back}")
scalar_first = np.allclose(quaternion, turn.as_quat()[[3, 0, 1, 2]])
raise SystemExit(0 if scalar_first and seen == 207.7 and back == [10.0, -20.0, 150.0] else 1)
PY
