#!/bin/sh
# rs_drift's drift of a balloon in kilometers is that of its last layer, in degrees that of the whole ascent.
#
# rs_drift 1.2.2, trajectory with output "km" and "degree". Guess: both give the displacement from the station, as
# documented; a wind of 10 m/s from the west for 1000 s gives 10 km. Seen: 0.131 degrees, which are 10.0 km at 47 N, but
# 2.5 km in four layers. Exits 1 if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q rs_drift==1.2.2 numpy==2.3.5 pandas==2.3.3 pyproj==3.7.2 numba==0.62.1 'setuptools<80'
cd "$folder"
./venv/bin/python -W ignore - <<'PY'
from importlib.metadata import version

import numpy as np
from pyproj import Geod
from rs_drift.drift import trajectory

heights = np.array([0.0, 1250, 2500, 3750, 5000])
pressures = np.array([101325.0, 87000, 74700, 63800, 54000])
winds = [np.full(5, speed) for speed in (10.0, 0.0)]
air = (pressures, np.full(5, 280.0))


def eastward(output):
    _, east, seconds = trajectory(47.0, 8.0, *winds, *air, output=output, z_original=heights)
    return float(east[-1]), float(seconds[-1])


degrees, seconds = eastward("degree")
way = Geod(ellps="WGS84").line_length([8, 8 + degrees], [47, 47]) / 1000
layer = eastward("km")[0]
print(f"rs_drift {version('rs_drift')}: after {seconds:.0f} s {degrees:.3f} degrees, {way:.1f} km; as km {layer:.1f}")
raise SystemExit(0 if round(way, 1) == 10.0 and round(layer, 1) == 2.5 and seconds == 1000 else 1)
PY
