from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import pytest

from ipoa_mission.scenario import Scenario

Place = tuple[float, float, float]
Spot = Sequence[float] | dict[str, float]
Make = Callable[..., Scenario]
Town = Callable[[int], Scenario]
HOME = {"latitude_deg": 39.1, "longitude_deg": 121.82}


def place(point: Spot) -> dict[str, float]:
    if isinstance(point, dict):
        return point
    east, north, up = (float(x) for x in point)
    return {"east": east, "north": north, "up": up}


@pytest.fixture
def scenario() -> Make:
    """A scenario in a box of 200 x 200 x 100 m over flat ground."""

    def make(
        start: Spot = (0, 0, 20),
        goal: Spot = (100, 0, 20),
        obstacles: Sequence[dict[str, Any]] = (),
        via: Sequence[Sequence[float]] = (),
        **tables: Any,
    ) -> Scenario:
        bounds = {"east": (-50, 150), "north": (-100, 100), "up": (0, 100)}
        world = {"home": HOME, "start": place(start), "goal": place(goal), "bounds": bounds}
        stops = [place(point) for point in via]
        return Scenario.model_validate(world | {"obstacles": list(obstacles), "via": stops} | tables)

    return make


@pytest.fixture
def town(scenario: Make) -> Town:
    """A random town on hills: spheres, masts, houses with courtyards, low start, ceiling, limited climb."""

    def make(seed: int) -> Scenario:
        rng = np.random.default_rng(seed)
        obstacles: list[dict[str, Any]] = []
        for i in range(15):
            east, north = rng.uniform(-40, 140), rng.uniform(-90, 90)
            where = {"name": f"{i}", "east": east, "north": north}
            if i % 3 == 0:
                obstacles.append({"kind": "sphere", "radius": rng.uniform(2, 10), "up": rng.uniform(0, 60), **where})
            elif i % 3 == 1:
                size = {"radius": rng.uniform(2, 8), "height": rng.uniform(5, 60), "base": 0.0}
                obstacles.append({"kind": "cylinder", **size, **where})
            else:
                corners = rng.uniform(6, 14, 6)[:, None] * [
                    (np.cos(a), np.sin(a)) for a in np.linspace(0, 2 * np.pi, 6, endpoint=False)
                ]
                middle = np.array([east, north])
                ring, yard = middle + corners, middle + 0.3 * corners
                rings = {"footprint": ring.tolist(), "holes": [yard.tolist()] if i % 2 else []}
                obstacles.append({"kind": "prism", "name": f"{i}", "base": 0.0, "height": rng.uniform(5, 60), **rings})
        heights = rng.uniform(0, 8, (22, 22)).tolist()
        return scenario(
            start={"east": 0, "north": 0, "height_above_ground": 4},
            goal={"east": 100, "north": 0, "height_above_ground": 30},
            obstacles=obstacles,
            terrain={"kind": "grid", "east": -55, "north": -105, "spacing": 10, "heights": heights},  # smooth at start
            vehicle={"radius": 0.7},
            planning={
                "min_height_above_ground": 12,
                "max_height_above_ground": 60,
                "max_climb_angle_deg": 35,
                "max_descent_angle_deg": 25,
            },
        )

    return make
