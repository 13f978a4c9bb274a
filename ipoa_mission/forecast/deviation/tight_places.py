"""Places that the scenario itself puts nearer to an obstacle than the tube is wide.

Nobody can keep more there than the place leaves. What lies so near to such a place that a vehicle cannot be clear of it
yet is promised by itself, and not as a part of the flight.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ipoa_mission.geometry import Points, Vector
from ipoa_mission.scenario import Scenario
from ipoa_mission.scenario.path_limits import place_names

WAY_OUT = 2.0  # metres flown for each metre farther away
TURN = 5.0  # in which a vehicle turns away from what is beside the place [m]


@dataclass(frozen=True, eq=False)
class TightPlace:
    """A given place: its name in the scenario, where it is, and how far from it less is promised [m]."""

    name: str
    place: Vector
    reach: float


def tight_places(scenario: Scenario, room: float) -> tuple[TightPlace, ...]:
    """The start, via points and goal that leave less than `room` [m] beside what is required of obstacles."""
    if not scenario.airspace.obstacles:
        return ()
    places = scenario.places
    missing = scenario.limits.obstacle_distance + room - scenario.airspace.obstacle_distance(places)
    return tuple(
        TightPlace(name, place, TURN + WAY_OUT * float(less))
        for name, place, less in zip(place_names(places), places, missing, strict=True)
        if less > 0
    )


def round_places(points: Points, tight: tuple[TightPlace, ...]) -> NDArray[np.intp]:
    """At which place the pieces between points (n, 3) are, (n-1,); -1: at none."""
    at = np.full(len(points) - 1, -1)
    middles = (points[:-1] + points[1:]) / 2
    for n, one in enumerate(tight):
        at[np.linalg.norm(middles - one.place, axis=1) <= one.reach] = n
    return at


def runs(points: Points, taken: NDArray[np.bool_]) -> Iterator[Points]:
    """The stretches (k, 3) of a path of points (n, 3) whose pieces (n-1,) are taken."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], taken, [False]]).astype(int)))
    for first, last in edges.reshape(-1, 2).tolist():
        yield points[first : last + 1]
