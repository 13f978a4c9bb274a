"""Write the seeded random maps of the paper's Tables 5 to 7 to missions/paper/."""

from typing import Any

import numpy as np

from ipoa_mission.autopilot.autopilot import default_autopilot
from ipoa_mission.files import write_atomically
from ipoa_mission.paper.problems import INNER, MAPS
from tools import REPOSITORY, command_line

FOLDER = REPOSITORY / "missions" / "paper"
HEAD = """\
# Random map {number} with {obstacles} obstacles, made by tools/generate/paper_maps.py: the size, landform
# and number of obstacles of the paper, which does not publish its own.
"""


def paper_map(name: str) -> dict[str, Any]:
    """Return the scenario of a map: 100 x 100 x 350 m, six peaks, obstacles drawn from its seed."""
    obstacles, number = map(int, name.removeprefix("map-").split("-"))
    rng = np.random.default_rng([2024, obstacles, number])
    surface = {"a": 0.1, "b": 0.3, "c": -0.9, "d": 0.5, "e": 0.5, "f": 0.5, "g": 0.3, "base": -5.0}
    return {
        "name": name,
        "safety_distance": 0.5,
        "safety": {"confidence": "nominal"},
        "home": {"latitude_deg": 38.87, "longitude_deg": 121.53, "altitude_amsl": 60.0},
        "start": {"east": 5.0, "north": 5.0, "height_above_ground": 15.0},
        "goal": {"east": 95.0, "north": 95.0, "height_above_ground": 15.0},
        "bounds": {"east": [0.0, 100.0], "north": [0.0, 100.0], "up": [-5.0, 350.0]},
        "vehicle": {"autopilot": str(default_autopilot()), "radius": 1.0, "cruise_speed": 5.0},
        "cost": {"form": "nodes"},
        "planning": {"planner": "paper", "control_points": INNER},
        "terrain": {"kind": "analytic", **surface, "peaks": [_peak(rng) for _ in range(6)]},
        "obstacles": [_obstacle(rng, k) for k in range(obstacles)],
    }


def _peak(rng: np.random.Generator) -> dict[str, float]:
    east, north = aside(rng, 25.0)
    height, a, b = rng.uniform(30, 110), *rng.uniform(8, 15, 2)
    return _to_a_tenth(height=height, east=east, north=north, a=a, b=b)


def _obstacle(rng: np.random.Generator, k: int) -> dict[str, Any]:
    """Return alternately a mast and a balloon; half of them are near the straight line."""
    east, north = aside(rng, 15.0) if k % 4 > 1 else in_the_way(rng)
    if k % 2:
        shape = _to_a_tenth(east=east, north=north, radius=rng.uniform(3, 6), height=rng.uniform(40, 120))
        return {"kind": "cylinder", "name": f"mast {k + 1}", **shape}
    shape = _to_a_tenth(east=east, north=north, up=rng.uniform(15, 50), radius=rng.uniform(4, 9))
    return {"kind": "sphere", "name": f"balloon {k + 1}", **shape}


def _to_a_tenth(**lengths: float) -> dict[str, float]:
    return {name: round(float(length), 1) for name, length in lengths.items()}


def aside(rng: np.random.Generator, least: float) -> tuple[float, float]:
    while True:
        east, north = rng.uniform(8, 92, 2)
        if min(np.hypot(east - 5, north - 5), np.hypot(east - 95, north - 95)) >= least:
            return float(east), float(north)


def in_the_way(rng: np.random.Generator) -> tuple[float, float]:
    """Return a place within ten meters of the straight line, where half of the obstacles are."""
    along, aside = rng.uniform(25, 75), rng.uniform(-7, 7)
    return float(along + aside), float(along - aside)


if __name__ == "__main__":
    import tomli_w

    command_line(__doc__).parse_args()
    for name in MAPS:
        _, obstacles, number = name.split("-")
        text = HEAD.format(number=number, obstacles=obstacles) + tomli_w.dumps(paper_map(name))
        write_atomically(FOLDER / f"{name}.toml", text)
        print(FOLDER / f"{name}.toml")
