#!/bin/sh
# CameraTransform puts a place 100 m to the north and 100 m lower 141 m to the north.
#
# cameratransform 1.2.1, spaceFromGPS(place, origin), both with an altitude as its getDistance takes them; pymap3d 3.2.0
# knows the place. Guess: 100 m to the north, the inverse of gpsFromSpace. Seen: 141.4 m, as the length of the slope is
# taken for the distance on the ground; it is right at one altitude only. Exits 1 if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q cameratransform==1.2.1 pymap3d==3.2.0
cd "$folder"
./venv/bin/python -W ignore - <<'PY'
from importlib.metadata import version

import cameratransform
import numpy as np
import pymap3d

drone = (47.0, 8.5, 200.0)


def north_of(meters, lower):
    place = np.array(pymap3d.enu2geodetic(0.0, meters, -lower, *drone))
    east, north, up = cameratransform.spaceFromGPS(place, np.array(drone))
    return round(float(north), 1)


seen = north_of(100, 0), north_of(100, 100), north_of(100, 20)
print(f"cameratransform {version('cameratransform')}: {seen[0]} m for 100 m, {seen[1]} where it is 100 m lower,")
print(f"{seen[2]} where it is 20 m lower")
raise SystemExit(0 if seen == (100.0, 141.4, 102.0) else 1)
PY
