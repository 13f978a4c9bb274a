#!/bin/sh
# mealpy's DS_GWO returns the best of its first random points, after any number of epochs.
#
# mealpy 3.0.3, GWO.DS_GWO, 30 wolves, the sum of five squares from -100 to 100. Guess: more epochs give a better
# result, and the function is called for each wolf and epoch. Seen: 30 calls and 7545 with 10 and with 1000 epochs, as
# the class has no step of its search; OriginalGWO calls 3030 times in 100 epochs and gets below 1e-9. Nothing is said,
# and the history has an entry for each epoch. Exits 1 if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q mealpy==3.0.3 numpy==1.26.0
cd "$folder"
./venv/bin/python - <<'PY'
from importlib.metadata import version

from mealpy import GWO, FloatVar


def search(optimizer, epochs):
    """Result, number of calls and length of the history."""
    calls = []

    def squares(point):
        calls.append(point)
        return float((point**2).sum())

    bounds = FloatVar(lb=(-100.0,) * 5, ub=(100.0,) * 5)
    model = optimizer(epoch=epochs, pop_size=30)
    best = model.solve({"obj_func": squares, "bounds": bounds, "minmax": "min", "log_to": None}, seed=1)
    return best.target.fitness, len(calls), len(model.history.list_global_best_fit)


short, long, original = search(GWO.DS_GWO, 10), search(GWO.DS_GWO, 1000), search(GWO.OriginalGWO, 100)
print(f"mealpy {version('mealpy')}: DS_GWO, 10 epochs {short}, 1000 {long}; OriginalGWO, 100 {original}")
as_seen = short[:2] == long[:2] and short[0] > 1000 and short[1] == 30
raise SystemExit(0 if as_seen and long[2] == 1000 and original[0] < 1e-9 and original[1] == 3030 else 1)
PY
