#!/bin/sh
# pyhpp's path through a walled area of 9 by 9 cells leaves it, and climbs diagonally where diagonals are off.
#
# pyhpp 0.1.5, AStar in three dimensions, allowDiagonal false. Guess: with a wall across the area, from its floor to its
# ceiling, there is no path, as in two dimensions. Seen: "Arrival" by y = 9, a cell outside: only the heights are
# bounded. A path from z = 1 to 5 moves along x and z at once, steps of 1.41 cells. Exits 1 if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q pyhpp==0.1.5
cd "$folder"
./venv/bin/python - <<'PY'
import contextlib
import io
import math
from importlib.metadata import version

from pyhpp.a_star import AStar


def plan(start, stop, wall, height):
    """The message and the path on an area of 9 by 9 cells, with a wall at x = 4 or none."""
    cells = [(4, y, z) for y in range(9) for z in range(max(height, 1))] if wall else []
    scenario = {
        "dimension": {"x": 9, "y": 9, "z": height},
        "waypoint": {"start": dict(zip("xyz", start)), "stop": dict(zip("xyz", stop)), "allowDiagonal": False},
        "data": {"size": len(cells), **{name: [cell[axis] for cell in cells] for axis, name in enumerate("xyz")}},
    }
    if height:
        scenario["boundary"] = {"zFloor": 0, "zCeil": height}
    else:
        del scenario["data"]["z"]
    with contextlib.redirect_stdout(io.StringIO()):
        result = AStar(scenario).calculate_path()
    path = result["path"]
    return result["message"].partition("!")[0], list(zip(path["x"], path["y"], path["z"] or [0] * len(path["x"])))


flat = plan((1, 4), (7, 4), True, 0)[0]
message, walled = plan((1, 4, 3), (7, 4, 3), True, 6)
climb = plan((1, 4, 1), (7, 4, 5), False, 6)[1]
outside = sum(not (0 <= x < 9 and 0 <= y < 9) for x, y, _ in walled)
longest = round(max(map(math.dist, climb, climb[1:])), 2)
print(f"pyhpp {version('pyhpp')}: flat: {flat} With heights: {message}, {outside} cells outside; a step of {longest}")
raise SystemExit(0 if "no results" in flat and "Arrival" in message and outside and longest == 1.41 else 1)
PY
