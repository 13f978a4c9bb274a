"""How long the planner takes where climbs are limited, or obstacles very many, how its seeds agree, and its memory.

    python -m tools.benchmarks.planning_limits

Prints a table in Markdown. Each row is planned in a process of its own; seconds are of CPU, after a
small plan that loads the kernels.
"""

import resource
import subprocess
import sys
import time
from collections.abc import Callable

import numpy as np

from ipoa_mission import Airspace, Bounds, Limits, PathProblem, plan_path
from ipoa_mission.world.obstacles import Cylinder, Obstacle, Prism
from ipoa_mission.world.terrain import Flat, Grid
from tools import command_line


def ridges(climb_deg: float, descent_deg: float) -> PathProblem:
    """A goal close behind the second of two ridges."""
    east, north = np.meshgrid(*[np.linspace(-300.0, 2100.0, 49)] * 2)
    wall = 200 * np.exp(-(((east - 400) / 60) ** 2))
    crest = (260 + 60 * np.sin(east / 150)) * np.exp(-(((0.3 * east + north - 1200) / 80) ** 2))
    ground = Grid(-300.0, -300.0, 50.0, 10 + np.maximum(wall, crest))
    airspace = Airspace(Bounds((-300.0, -300.0, 0.0), (2100.0, 2100.0, 600.0)), ground, ())
    climb, descent = np.radians((climb_deg, descent_deg))
    limits = Limits(obstacle_distance=5.0, height_above_ground=10.0, climb_angle=climb, descent_angle=descent)
    return PathProblem(airspace, limits, np.array([[0.0, 0.0, 40.0], [1200.0, 1300.0, 40.0]]))


def town(count: int, length: float) -> PathProblem:
    """Houses and towers at random along a flight of that length [m], half as wide."""
    rng = np.random.default_rng(3)
    bodies: list[Obstacle] = []
    for k in range(count):
        east, north = rng.uniform(0.03 * length, 0.97 * length), rng.uniform(-length / 4, length / 4)
        width, depth = rng.uniform(8, 25, 2)
        height, heading = rng.uniform(15, 70), rng.uniform(0, 3)
        ahead, aside = np.array([np.cos(heading), np.sin(heading)]), np.array([-np.sin(heading), np.cos(heading)])
        corners = [(east, north) + (u * width * ahead + v * depth * aside) / 2 for u, v in CORNERS]
        ring = tuple((float(e), float(n)) for e, n in corners)
        tower = Cylinder(f"tower {k}", east, north, width / 2, 0.0, height)
        bodies.append(Prism(f"house {k}", ring, (), 0.0, height) if k % 3 else tower)
    bounds = Bounds((0.0, -length / 4 - 50, 0.0), (length, length / 4 + 50, 60.0))
    places = np.array([[5.0, 0.0, 30.0], [length - 5, 0.0, 30.0]])
    limits = Limits(obstacle_distance=2.6, height_above_ground=5.0)
    return PathProblem(Airspace(bounds, Flat(), tuple(bodies)), limits, places, radius=0.6)


CORNERS = ((-1, -1), (1, -1), (1, 1), (-1, 1))
SCENES: dict[str, tuple[Callable[[], PathProblem], int]] = {
    "two ridges, 30 degrees up, 11 down": (lambda: ridges(30.0, 11.0), 3),
    "two ridges, 15 degrees up, 25 down": (lambda: ridges(15.0, 25.0), 3),
    "5,000 buildings on 20 km": (lambda: town(5000, 20_000.0), 1),
    "20,000 buildings on 6 km": (lambda: town(20_000, 6000.0), 1),
    "20,000 buildings on 20 km": (lambda: town(20_000, 20_000.0), 1),
}


def measure(scene: str) -> str:
    """A row of the table, planned in this process."""
    prepare, seeds = SCENES[scene]
    plan_path(town(5, 300.0))
    costs, seconds = list[float](), list[float]()
    for seed in range(seeds):
        started = time.process_time()
        costs.append(plan_path(prepare(), seed=seed).cost.total)
        seconds.append(time.process_time() - started)
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    apart = f"{100 * (max(costs) / min(costs) - 1):.2f} %" if seeds > 1 else ""
    return f"| {scene} | {min(costs):.1f} | {apart} | {max(seconds):.1f} | {peak:.0f} |"


def main() -> None:
    parser = command_line(__doc__)
    parser.add_argument("scene", nargs="?", choices=SCENES, help="this one alone, in this process")
    alone = parser.parse_args().scene
    if alone:
        print(measure(alone))
        return
    print("| scene | cost, best seed | seeds apart | CPU, worst [s] | memory, peak [MB] |", flush=True)
    print("|---|---|---|---|---|", flush=True)
    for scene in SCENES:
        subprocess.run([sys.executable, "-m", "tools.benchmarks.planning_limits", scene], check=True)


if __name__ == "__main__":
    main()
