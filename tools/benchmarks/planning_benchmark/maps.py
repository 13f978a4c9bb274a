"""Make the seeded maps of the benchmark; a name is always the same map.

    spheres-8-1 ... spheres-8-5, spheres-6-1, spheres-10-1      100 x 100 x 350 m, six peaks, balloons near the ground
    cylinders-8-1 ... cylinders-10-1                             the same with masts that stand on the ground
    block-60-1                                                   sixty buildings on a street grid, flown below 50 m
    city-500-1                                                   2 x 2 km, five hundred buildings, flown below 60 m
    field-N-1                                                    N masts, one on every 900 square metres
    side-100-S                                                   a hundred masts on S x S m

Half of the obstacles of a paper-like map are within ten meters of the straight line, so that it is not easy. Names
with other numbers are maps of the same kind with other seeds.
"""

from typing import Any

import numpy as np

from ipoa_mission.scenario import Scenario
from tools.generate.paper_maps import aside, in_the_way

Table = dict[str, Any]

NUMBERS = ("8-1", "8-2", "8-3", "8-4", "8-5", "6-1", "10-1")
PAPER_LIKE = tuple(f"{kind}-{number}" for kind in ("spheres", "cylinders") for number in NUMBERS)
MAPS = (*PAPER_LIKE, "block-60-1", "city-500-1")
FIELDS = (10, 30, 100, 300, 1000, 3000, 5000)
SIDES = (200, 500, 1000, 2000, 5000)
HOME = {"latitude_deg": 38.87, "longitude_deg": 121.53, "altitude_amsl": 60.0}


def benchmark_map(name: str) -> Scenario:
    """Return the map of a name: kind, number of obstacles, and number of the map."""
    kind, count, number = name.split("-")
    rng = np.random.default_rng([sum(map(ord, kind)), int(count), int(number)])
    match kind:
        case "spheres" | "cylinders":
            table = paper_like(kind, int(count), rng)
        case "block":
            table = block(int(count), rng)
        case "city":
            table = city(int(count), rng)
        case "field":
            table = field(int(count), 30.0 * np.sqrt(int(count)), rng)
        case "side":
            table = field(int(count), float(number), rng)
        case _:
            raise SystemExit(f"{name}: expected a map of planning_benchmark/maps.py")
    return Scenario.model_validate({"name": name, "home": HOME, **table})


def weighing(scenario: Scenario, omega: tuple[float, float, float]) -> Scenario:
    """Return the scenario with other weights of length, turning and threat."""
    return scenario.model_copy(update={"cost": scenario.cost.model_copy(update={"omega": omega})})


def paper_like(kind: str, count: int, rng: np.random.Generator) -> Table:
    """Make a map with the paper's size, landform and number of obstacles."""
    peaks = []
    for _ in range(6):
        east, north = aside(rng, 25.0)
        a, b = rng.uniform(8, 15, 2)
        peaks.append({"height": rng.uniform(30, 110), "east": east, "north": north, "a": a, "b": b})
    obstacles = []
    for k in range(count):
        east, north = aside(rng, 15.0) if k % 2 else in_the_way(rng)
        shape = (
            {"up": rng.uniform(15, 50), "radius": rng.uniform(4, 9)}
            if kind == "spheres"
            else {"radius": rng.uniform(3, 6), "height": rng.uniform(40, 120)}
        )
        obstacles.append({"kind": kind.removesuffix("s"), "east": east, "north": north, **shape})
    surface = {"a": 0.1, "b": 0.3, "c": -0.9, "d": 0.5, "e": 0.5, "f": 0.5, "g": 0.3, "base": -5.0}
    return {
        "start": {"east": 5.0, "north": 5.0, "height_above_ground": 15.0},
        "goal": {"east": 95.0, "north": 95.0, "height_above_ground": 15.0},
        "bounds": {"east": (0.0, 100.0), "north": (0.0, 100.0), "up": (-5.0, 350.0)},
        "vehicle": {"radius": 1.0},
        "terrain": {"kind": "analytic", **surface, "peaks": peaks},
        "obstacles": obstacles,
    }


def block(count: int, rng: np.random.Generator) -> Table:
    """Make a street grid of turned houses; some roofs are below the ceiling."""
    columns = int(np.ceil(np.sqrt(count * 1.2)))
    rows = int(np.ceil(count / columns))
    obstacles = []
    for k in range(count):
        width, depth = rng.uniform(18, 30, 2)
        obstacles.append(
            {
                "kind": "box",
                "east": 40.0 * (k % columns) + rng.uniform(-3, 3),
                "north": 40.0 * (k // columns) + rng.uniform(-3, 3),
                "width": width,
                "depth": depth,
                "height": rng.uniform(20, 90),
                "heading_deg": rng.uniform(-15, 15),
            }
        )
    return _town(obstacles, 40.0 * (columns - 1), 40.0 * (rows - 1), 30.0, 50.0)


def city(count: int, rng: np.random.Generator) -> Table:
    """Scatter buildings over two kilometers, larger and farther apart than in a block."""
    obstacles: list[Table] = []
    while len(obstacles) < count:
        east, north = rng.uniform(0, 2000, 2)
        width, depth = rng.uniform(20, 70, 2)
        reach = 0.6 * np.hypot(width, depth)
        if all(
            np.hypot(east - o["east"], north - o["north"]) > reach + 0.6 * np.hypot(o["width"], o["depth"])
            for o in obstacles
        ):
            obstacles.append(
                {
                    "kind": "box",
                    "east": east,
                    "north": north,
                    "width": width,
                    "depth": depth,
                    "height": rng.uniform(15, 120),
                    "heading_deg": rng.uniform(-45, 45),
                }
            )
    return _town(obstacles, 2000.0, 2000.0, 60.0, 60.0)


def field(count: int, side: float, rng: np.random.Generator) -> Table:
    """Scatter masts on a square of `side` [m]."""
    places = rng.uniform(0, side, (count, 2))
    obstacles = [
        {"kind": "cylinder", "east": east, "north": north, "radius": rng.uniform(2, 6), "height": rng.uniform(30, 90)}
        for east, north in places
    ]
    return _town(obstacles, side, side, 30.0, 50.0)


def _town(obstacles: list[Table], east: float, north: float, margin: float, ceiling: float) -> Table:
    """Fly from corner to corner below a ceiling, on flat ground."""
    return {
        "safety_distance": 2.0,
        "start": {"east": -margin / 1.5, "north": -margin / 1.5, "up": 15.0},
        "goal": {"east": east + margin / 1.5, "north": north + margin / 1.5, "up": 20.0},
        "bounds": {"east": (-margin, east + margin), "north": (-margin, north + margin), "up": (0.0, ceiling)},
        "vehicle": {"radius": 0.6},
        "obstacles": obstacles,
    }
