#!/bin/sh
# transform-base reads roll, pitch and yaw of a quaternion in the wrong order, for all orders but ZYX.
#
# transform-base 0.0.7, standard_euler_to_quaternion and quaternion_to_standard_euler with order="XYZ". Guess: roll 10,
# pitch 20 and yaw 30 degrees come back, as by standard_euler_to_rotation_matrix and its inverse. Seen: 30, 20 and 10
# by the quaternion; 20, 10 and 30 in the order ZXY. All six orders are documented. Exits 1 if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q transform-base==0.0.7 numpy==2.4.6 scipy==1.17.1 pyproj==3.7.2
cd "$folder"
./venv/bin/python - <<'PY'
from importlib.metadata import version

from transform_base import transform as turn

angles = (10.0, 20.0, 30.0)
by_quaternion, by_matrix = {}, {}
for order in turn.SUPPORTED_INTRINSIC_EULER_ORDERS:
    quaternion = turn.standard_euler_to_quaternion(*angles, order)
    matrix = turn.standard_euler_to_rotation_matrix(*angles, order)
    by_quaternion[order] = [round(angle) for angle in turn.quaternion_to_standard_euler(quaternion, order)]
    by_matrix[order] = [round(angle) for angle in turn.rotation_matrix_to_standard_euler(matrix, order)]
print(f"transform-base {version('transform-base')}: 10, 20, 30 are {by_quaternion}, by the matrix {by_matrix}")
right = [order for order, found in by_quaternion.items() if found == [10, 20, 30]]
as_seen = right == ["ZYX"] and by_quaternion["XYZ"] == [30, 20, 10]
raise SystemExit(0 if as_seen and all(found == [10, 20, 30] for found in by_matrix.values()) else 1)
PY
