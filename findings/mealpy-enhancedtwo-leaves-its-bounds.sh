#!/bin/sh
# mealpy's EnhancedTWO asks for values up to 200 beyond its bounds of -100 and 100.
#
# mealpy 3.0.3, TWO.EnhancedTWO, 30 teams, 100 epochs, in five dimensions. Guess: each point that is evaluated is within
# the bounds, as by OriginalTWO. Seen: 12 of 6162 are not, by up to 199: a point is evaluated before its correction, and
# that value kept for the corrected point. A cost meets speeds below 0 or places off the map. Exits 1 if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q mealpy==3.0.3 numpy==1.26.0
cd "$folder"
./venv/bin/python - <<'PY'
from importlib.metadata import version

import numpy as np
from mealpy import TWO, FloatVar


def beyond(optimizer):
    """Points that were evaluated, those out of bounds, and the most beyond them."""
    excess = []

    def squares(point):
        excess.append(float(np.abs(point).max()) - 100)
        return float((point**2).sum())

    bounds = FloatVar(lb=(-100.0,) * 5, ub=(100.0,) * 5)
    problem = {"obj_func": squares, "bounds": bounds, "minmax": "min", "log_to": None}
    optimizer(epoch=100, pop_size=30).solve(problem, seed=1)
    return len(excess), sum(more > 1e-9 for more in excess), round(max(excess))


enhanced, original = beyond(TWO.EnhancedTWO), beyond(TWO.OriginalTWO)
print(f"mealpy {version('mealpy')}, points, out of bounds, most beyond: EnhancedTWO {enhanced}, OriginalTWO {original}")
raise SystemExit(0 if enhanced[1] > 0 and enhanced[2] > 100 and original[1] == 0 else 1)
PY
