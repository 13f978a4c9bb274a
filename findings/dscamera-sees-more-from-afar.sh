#!/bin/sh
# dscamera's camera with a field of view of 120 degrees sees a mast 80 degrees off its axis from 3 m on.
#
# dscamera 0.0.4, DSCamera.world2cam, its mask of what is in the field of view. Guess: a point's angle decides, and 60
# degrees is the most. Seen: its distance forward in meters is compared with the cosine of 60 degrees. A point at 50
# degrees is outside at 0.5 m; one at 80 degrees is inside at 3 m and farther. With 220 degrees, one at 100 is inside at
# 1 m and outside at 3 m. The pixels are right. Exits 1 if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q --no-deps dscamera==0.0.4 numpy==2.2.6 opencv-python-headless==4.12.0.88
cd "$folder"
./venv/bin/python - <<'PY'
from importlib.metadata import version

import numpy as np
from dscamera import DSCamera

LENS = {"fx": 350.0, "fy": 350.0, "cx": 640.0, "cy": 480.0, "xi": -0.2, "alpha": 0.55}
DISTANCES = 0.5, 1, 3, 10


def is_inside(field, degrees):
    angle = np.radians(degrees)
    points = np.array([[distance * np.sin(angle), 0, distance * np.cos(angle)] for distance in DISTANCES])
    pixels, mask = DSCamera(img_size=(960, 1280), intrinsic=LENS, fov=field).world2cam(points)
    assert np.ptp(pixels, axis=0).max() < 1e-9
    return mask.tolist()


seen = {case: is_inside(*case) for case in ((120, 50), (120, 80), (220, 100))}
print(f"dscamera {version('dscamera')}, inside at {DISTANCES} m by field and angle in degrees: {seen}")
expected = [[False, True, True, True], [False, False, True, True], [True, True, False, False]]
raise SystemExit(0 if list(seen.values()) == expected else 1)
PY
