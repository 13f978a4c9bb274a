#!/bin/sh
# pymavlink's Matrix3.rotate turns by 57.5 degrees where 90 are asked for.
#
# pymavlink 2.4.50, rotmat.Matrix3.rotate, "rotate the matrix by a given amount on 3 axes". Guess: a yaw of 90 degrees
# is 90 degrees. Seen: 57.5, and the matrix also stretches, 1.86; 30 degrees are 27.6. It holds for small angles only,
# as a gyro gives in a step: 90 steps of 1 degree are 90.0. Exits 1 if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q pymavlink==2.4.50
cd "$folder"
./venv/bin/python - <<'PY'
import math

from pymavlink.rotmat import Matrix3, Vector3


def turn(degrees, steps=1):
    matrix = Matrix3()
    for _ in range(steps):
        matrix.rotate(Vector3(0, 0, math.radians(degrees)))
    return round(math.degrees(matrix.to_euler()[2]), 1), round((matrix * Vector3(1, 0, 0)).length(), 2)


seen = [turn(90), turn(30), turn(1, 90)]
print(f"yaw and length after 90, 30 and 90 times 1 degree: {seen}")
raise SystemExit(0 if seen[0] == (57.5, 1.86) and seen[1][0] == 27.6 and seen[2][0] == 90.0 else 1)
PY
