#!/bin/sh
# rotorpy's trajectory to the west flies at 10.9 m/s with v_max 3; the same to the east has no solution.
#
# rotorpy 3.0.0, trajectories.minsnap.MinSnap with v_max=3 and v_avg=5, for a leg of 10 m. Guess: both directions have
# one result, a speed of at most 3 m/s, or none. Seen: to the east, as no speed of the middle is below 3, a TypeError;
# to the west 10.9 m/s, as only speeds of more than +3 m/s in an axis are limited. With v_avg=2, along a corner of 90
# degrees, it flies at 4.1 m/s and 5.9 m past the corner. Exits 1 if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q cvxopt==1.3.2 numpy==2.4.6 scipy==1.17.1
"$folder/venv/bin/pip" install -q --no-deps rotorpy==3.0.0
cd "$folder"
./venv/bin/python - <<'PY'
from importlib.metadata import version

import numpy as np
from rotorpy.trajectories.minsnap import MinSnap


def fly(points, speed):
    """Greatest speed and greatest x, or None where there is no solution."""
    try:
        path = MinSnap(np.array(points, dtype=float), v_avg=speed, v_max=3, verbose=False)
    except TypeError:
        return None
    flown = [path.update(time) for time in np.linspace(0, path.t_keyframes[-1], 4001)]
    return tuple(round(float(max(row)), 1) for row in zip(*((np.linalg.norm(p["x_dot"]), p["x"][0]) for p in flown)))


east, west = fly([(0, 0, 0), (10, 0, 0)], 5), fly([(0, 0, 0), (-10, 0, 0)], 5)
corner = fly([(0, 0, 0), (10, 0, 0), (10, 10, 0), (0, 10, 0)], 2)
print(f"rotorpy {version('rotorpy')}, v_max 3: to the east {east}, to the west {west[0]} m/s; corner {corner}")
raise SystemExit(0 if east is None and west[0] == 10.9 and corner == (4.1, 15.9) else 1)
PY
