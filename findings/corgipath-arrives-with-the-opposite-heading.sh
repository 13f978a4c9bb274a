#!/bin/sh
# corgipath's route to a goal with heading west arrives with heading east.
#
# corgipath 0.1.0a1, HybridAstar with its default end condition, forward only, no obstacle near. Guess: the last
# waypoint has the heading of the goal, within a step of 15 degrees. Seen: 0 for 180 and 90 for 270 degrees, as headings
# count modulo 180. A fixed wing that should land into the wind lands with it. Nothing is said. Exits 1 if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q corgipath==0.1.0a1 collision==1.2.2 numpy==1.26.4 scipy==1.16.3 shapely==2.2.0
cd "$folder"
./venv/bin/python - <<'PY'
import contextlib
import io
import math
from importlib.metadata import version

import collision
from corgipath.collision import KDTree
from corgipath.planning import HybridAstar
from corgipath.search_space import DefaultHybridGrid


def arrival(x, y, heading):
    """The heading in degrees of the last waypoint of a route from the origin, heading east."""
    grid = DefaultHybridGrid(dxy=1.0, dtheta=math.radians(15))
    grid.use_default_successor_template(math.radians(30), allow_backward=False)
    space = KDTree((-60, 60, -60, 60), 0.5)
    space.add_obstacles([collision.Circle(collision.Vector(50, 50), 1)])
    space.agent_collision = collision.Circle(collision.Vector(0, 0), 0.5)
    space.build()
    planner = HybridAstar()
    planner.search_space, planner.collision_system = grid, space
    with contextlib.redirect_stdout(io.StringIO()):
        route = planner.solve((0.0, 0.0, 0.0), (x, y, math.radians(heading)))
    return round(math.degrees(route[-1][2])) % 360


seen = {heading: arrival(*place, heading) for heading, place in ((0, (20, 0)), (180, (20, 0)), (270, (0, 20)))}
print(f"corgipath {version('corgipath')}: heading of the goal and of the arrival: {seen}")
raise SystemExit(0 if seen == {0: 0, 180: 0, 270: 90} else 1)
PY
