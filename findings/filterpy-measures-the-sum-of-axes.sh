#!/bin/sh
# FilterPy's kinematic_kf of two dimensions measures the sum of both positions, for each.
#
# filterpy 2.0.0, common.kinematic_kf(dim=2, order=1, dim_z=2), documented as tracking in dim dimensions. Guess: its
# matrix H takes east from the state for the first measurement, north for the second. Seen: both rows take east +
# north. Fed with the places of a vehicle at 10 m east and 30 m north, it ends at 10 and 10. Exits 1 if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q filterpy==2.0.0 scipy==1.17.1 numpy==2.4.6
cd "$folder"
./venv/bin/python -W ignore - <<'PY'
from importlib.metadata import version

import numpy as np
from filterpy.common import kinematic_kf

tracker = kinematic_kf(dim=2, order=1, dim_z=2, dt=0.1)
for _ in range(500):
    tracker.predict()
    tracker.update(np.array([[10.0], [30.0]]))
east, _, north, _ = tracker.x.ravel().round(1)
print(f"filterpy {version('filterpy')}: H {tracker.H.tolist()}, at {east} and {north}")
raise SystemExit(0 if tracker.H.tolist() == [[1, 0, 1, 0]] * 2 and (east, north) == (10, 10) else 1)
PY
