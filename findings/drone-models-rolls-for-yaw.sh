#!/bin/sh
# The quadrotor of drone-models rolls where it should yaw.
#
# drone-models 0.1.0, dynamics of first_principles. Guess: quat_dot of a level vehicle that turns round its vertical
# axis at 1 rad/s, kept at unit length as its reference asks, is a yaw of 10 degrees after 0.175 s. Seen: a yaw of 0
# and a roll of -10. Quaternions are x, y, z, w, as the reference says; the matrix of the rates is for w, x, y, z. The
# three other models have it, too. Exits 1 if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q drone-models==0.1.0 numpy==2.4.6 scipy==1.17.1
cd "$folder"
./venv/bin/python -W ignore - <<'PY'
from importlib.metadata import version

import numpy as np
from drone_models import parametrize, so_rpy
from drone_models.first_principles import dynamics
from scipy.spatial.transform import Rotation


def after(model, command):
    rates = parametrize(model, "cf2x_L250")
    rest, spin = np.zeros(3), np.array([0.0, 0.0, 1.0])
    quaternion = np.array([0.0, 0.0, 0.0, 1.0])
    for _ in range(175):
        quaternion = quaternion + 0.001 * rates(pos=rest, quat=quaternion, vel=rest, ang_vel=spin, cmd=command)[1]
        quaternion = quaternion / np.linalg.norm(quaternion)
    return (Rotation.from_quat(quaternion).as_euler("ZYX", degrees=True).round(1) + 0.0).tolist()


turned = [after(dynamics, np.full(4, 15000.0)), after(so_rpy.dynamics, np.array([0.0, 0.0, 0.0, 0.3]))]
print(f"drone-models {version('drone-models')}: yaw, pitch and roll after 10 degrees of yaw: {turned}")
raise SystemExit(0 if turned == [[0, 0, -10.0]] * 2 else 1)
PY
