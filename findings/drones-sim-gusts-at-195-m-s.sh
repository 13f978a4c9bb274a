#!/bin/sh
# drones_sim's gusts of 2 m/s have 195 m/s at a step of 5 ms, and more at a smaller one.
#
# drones_sim 0.2.0, DrydenGust with an intensity of 2 m/s. Guess: the standard deviation of its wind is about 2 m/s at
# each step of time. Seen: 40 m/s at 20 ms, 195 at 5 ms and 435 at 2 ms, as the noise is divided by the root of the step
# and not multiplied by the step. A vehicle in its turbulence meets winds that no weather has. Exits 1 if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q drones_sim==0.2.0 rerun-sdk==0.27.3 numpy==2.3.5 scipy==1.16.3 matplotlib==3.10.7
cd "$folder"
./venv/bin/python - <<'PY'
from importlib.metadata import version

import numpy as np
from drones_sim.dynamics.disturbances import DrydenGust


def deviation(step):
    gust = DrydenGust(intensity=2.0, seed=1)
    winds = []
    for index in range(int(200 / step)):
        gust.advance(index * step, step, np.zeros(13))
        winds.append(gust.wind_velocity()[0])
    return round(float(np.std(winds)))


seen = {step: deviation(step) for step in (0.02, 0.005, 0.002)}
print(f"drones_sim {version('drones_sim')}: deviation in m/s by step in seconds, of 2: {seen}")
raise SystemExit(0 if list(seen.values()) == [40, 195, 435] else 1)
PY
