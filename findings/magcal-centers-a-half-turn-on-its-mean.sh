#!/bin/sh
# A compass that magcal calibrates with a half turn is up to 39 degrees off.
#
# magcal 1.0.1, MagnetometerCalibrator.calibrate("ellipsoid"). Guess: 1000 readings without noise, all on one half of a
# sphere of 50 uT, have the center of the sphere, as a linear fit gives it to 0.001 uT. Seen: the center is their mean,
# 25 uT to the side, and headings are up to 39 degrees off. With the whole sphere it is right. Exits 1 if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q magcal==1.0.1 numpy==2.4.6 scipy==1.17.1
cd "$folder"
cat >turn.py <<'PY'
import math
from importlib.metadata import version

import numpy as np
from magcal.core import MagnetometerCalibrator

number = np.arange(2000) + 0.5
tilt, turn = np.arccos(1 - number / 1000), math.pi * (1 + 5**0.5) * number
sphere = 50 * np.column_stack([np.cos(turn) * np.sin(tilt), np.sin(turn) * np.sin(tilt), np.cos(tilt)])
offset = np.array([20.0, -10.0, 30.0])


def off(field):
    compass = MagnetometerCalibrator()
    compass.raw_data = [*(field + offset)]
    found = compass.calibrate("ellipsoid")["center"] - offset
    level = sphere[abs(sphere[:, 2]) < 1]
    seen = np.array([compass.apply_calibration(reading) for reading in level + offset])
    headings = [np.arctan2(rows[:, 1], rows[:, 0]) for rows in (seen, level)]
    return found.round() + 0.0, round(float(np.degrees(abs(np.angle(np.exp(1j * (headings[0] - headings[1])))).max())))


half = sphere[sphere[:, 1] > 0]
fit = np.linalg.lstsq(np.column_stack([2 * (half + offset), np.ones(len(half))]), ((half + offset) ** 2).sum(1))[0]
whole, turned = off(sphere), off(half)
print(f"magcal {version('magcal')}, center and headings off: whole {whole}, half {turned}")
print(f"a linear fit is {fit[:3] - offset} off")
as_seen = not whole[0].any() and whole[1] == 0 and turned[0].tolist() == [0, 25, 0] and turned[1] == 39
raise SystemExit(0 if as_seen and np.allclose(fit[:3], offset, atol=0.001) else 1)
PY
./venv/bin/python -W ignore turn.py
