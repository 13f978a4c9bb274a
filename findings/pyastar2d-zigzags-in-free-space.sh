#!/bin/sh
# pyastar2d's shortest path over a free plain of 180 m is 242 m long, and another goes through a wall.
#
# pyastar2d 1.1.4, astar_path with allow_diagonal=True. Guess: on a grid of equal weights the way from one side to the
# other is straight, as a diagonal step is 1.41 cells long; a wall of infinite weight from edge to edge has no way
# through. Seen: each step costs the weight of its cell only, so a zigzag of 34 % more length is as short; and a wall
# one cell thick that runs diagonally is crossed between two of its cells. Without diagonals there is none. Exits 1 if
# that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q pyastar2d==1.1.4 numpy==2.4.6
cd "$folder"
./venv/bin/python - <<'PY'
import math
from importlib.metadata import version

import numpy as np
import pyastar2d


def length(path):
    return round(sum(math.dist(*leg) for leg in zip(path, path[1:])))


plain = np.ones((200, 200), dtype=np.float32)
straight = pyastar2d.astar_path(plain, (100, 10), (100, 190), allow_diagonal=True)
wall = plain.copy()
np.fill_diagonal(wall[::-1], np.inf)
ways = [pyastar2d.astar_path(wall, (0, 0), (199, 199), allow_diagonal=diagonal) for diagonal in (True, False)]
crossed = ways[0] is not None and ways[1] is None
print(f"pyastar2d {version('pyastar2d')}: {length(straight)} cells for 180; the diagonal wall is crossed: {crossed}")
raise SystemExit(0 if length(straight) == 242 and crossed else 1)
PY
