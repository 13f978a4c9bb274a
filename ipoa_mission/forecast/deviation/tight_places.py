"""Find places nearer to an obstacle than the deviation bound."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ipoa_mission.geometry import Points, Vector
from ipoa_mission.scenario import Scenario
from ipoa_mission.scenario.path_limits import place_names

EXIT_FACTOR = 2.0  # meters flown for each meter away
TURN_DISTANCE = 5.0  # [m]


@dataclass(frozen=True, eq=False)
class TightPlace:
    """A given place, and the distance with a lower promise [m]."""

    name: str
    place: Vector
    reach: float


def tight_places(scenario: Scenario, room: float) -> tuple[TightPlace, ...]:
    if not scenario.airspace.obstacles:
        return ()
    places = scenario.places
    missing = scenario.limits.obstacle_distance + room - scenario.airspace.obstacle_distance(places)
    return tuple(
        TightPlace(name, place, TURN_DISTANCE + EXIT_FACTOR * float(less))
        for name, place, less in zip(place_names(places), places, missing, strict=True)
        if less > 0
    )


def round_places(points: Points, tight: tuple[TightPlace, ...]) -> NDArray[np.intp]:
    """Return the index of the place near each piece of points (n, 3), (n-1,); -1: none."""
    at = np.full(len(points) - 1, -1)
    middles = (points[:-1] + points[1:]) / 2
    for n, one in enumerate(tight):
        at[np.linalg.norm(middles - one.place, axis=1) <= one.reach] = n
    return at


def runs(points: Points, taken: NDArray[np.bool_]) -> Iterator[Points]:
    edges = np.flatnonzero(np.diff(np.concatenate([[False], taken, [False]]).astype(int)))
    for first, last in edges.reshape(-1, 2).tolist():
        yield points[first : last + 1]
