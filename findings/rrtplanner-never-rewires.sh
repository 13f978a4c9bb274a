#!/bin/sh
# rrtplanner's RRT* never gives a point of its tree a better parent.
#
# rrtplanner 0.1.2, its module rrt, RRTStar, 1000 points in a free square of 100, rewire radius 20. Guess: points get
# later ones for parents, and few keep a detour through their radius. Seen: no point has a later parent, and 333 would
# be at least 1 nearer to the start through a neighbor. A rewired cost is the neighbor's own plus the leg, never less.
# More points do not shorten a route to a point that the tree has. Exits 1 if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q numba==0.62.1 numpy==2.3.5 networkx==3.5 tqdm==4.67.1
"$folder/venv/bin/pip" install -q --no-deps rrtplanner==0.1.2
cd "$folder"
./venv/bin/python -W ignore - <<'PY'
import importlib.util
import math
from importlib.metadata import version
from pathlib import Path

import numpy as np

folder = importlib.util.find_spec("rrtplanner").submodule_search_locations[0]
spec = importlib.util.spec_from_file_location("rrt", Path(folder) / "rrt.py")
rrt = importlib.util.module_from_spec(spec)
spec.loader.exec_module(rrt)

np.random.seed(1)
planner = rrt.RRTStar(np.zeros((100, 100), dtype=int), 1000, 20, pbar=False)
tree, goal = planner.plan(np.array([5, 5]), np.array([95, 95]))
places = {node: tuple(map(int, data["pt"])) for node, data in tree.nodes(data=True) if node != goal}
costs = {child: float(data["cost"]) for _, child, data in tree.edges(data=True)}


def shorter(node):
    """Whether a neighbor within the radius is a way that is shorter by 1."""
    legs = ((costs[other], math.dist(places[other], places[node])) for other in places if other in costs)
    return any(leg < 20 and cost + leg < costs[node] - 1 for cost, leg in legs)


later = sum(parent > child for parent, child in tree.edges if child != goal)
detours = sum(shorter(node) for node in places if node in costs)
print(f"rrtplanner {version('rrtplanner')}, {len(places)} points: with a later parent {later}, with a detour {detours}")
raise SystemExit(0 if later == 0 and detours > 100 else 1)
PY
