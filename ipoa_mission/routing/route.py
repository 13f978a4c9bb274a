"""A route: waypoints, moved until the legs between them keep the required clearance."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ipoa_mission.errors import MissionError
from ipoa_mission.geometry import Points, Vector
from ipoa_mission.planning.path_problem import PathTask
from ipoa_mission.planning.proof import Check, prove
from ipoa_mission.world.airspace import Airspace

PUSHES = 30
OVERSHOOT = 0.01  # of a moved leg [m]
SLOPE_STEP = 1e-3  # [m]


class NoRoute(MissionError):
    """No choice of waypoints keeps the required clearance."""


@dataclass(frozen=True, eq=False)
class Route:
    """Waypoints (k, 3), flown in straight legs, or with `spline` in one curve (ArduPilot).

    A spline ends in a straight leg, or with `brakes_on_curve` in a curve of `braking_length`. `radius` is PX4's
    acceptance radius [m] of all waypoints, or of each (k,); 0: its parameter. The `slow` legs, from 0, are flown at
    `slow_speed` [m/s].
    """

    points: Points
    spline: bool = False
    brakes_on_curve: bool = False
    radius: Vector | float = 0.0
    slow: frozenset[int] = frozenset()
    slow_speed: float = 0.0
    slow_reason: str = ""

    @property
    def legs(self) -> int:
        return len(self.points) - 1

    @property
    def speed_changes(self) -> list[int]:
        return [leg for leg in range(self.legs) if (leg in self.slow) != (leg - 1 in self.slow)]


def push_clear(waypoints: Points, task: PathTask) -> Points:
    """Move waypoints (k, 3) aside where a leg keeps too little clearance; ends and given places stay.

    Each breach pushes the ends of its leg by the missing distance, weighted by nearness.
    """
    moved = waypoints.copy()
    is_free = ~(waypoints[:, None] == task.places).all(axis=2).any(axis=1)
    is_free[[0, -1]] = False
    moved_legs = set(_broken_legs(moved, task))  # since their last proof
    for _ in range(PUSHES):
        for leg in range(len(moved) - 1):
            if leg not in moved_legs:
                continue
            moved_legs.remove(leg)
            ends = moved[leg : leg + 2].copy()
            for check in _broken(ends, task):
                _push(moved[leg : leg + 2], is_free[leg : leg + 2], check, task.airspace)
            first, last = (moved[leg : leg + 2] != ends).any(axis=1)
            moved_legs |= {leg - 1, leg} if first else set()
            moved_legs |= {leg, leg + 1} if last else set()
        if not moved_legs:
            break
    return moved


def _broken_legs(waypoints: Points, task: PathTask, first: int = 0) -> list[int]:
    if not _broken(waypoints, task):
        return []
    if len(waypoints) == 2:
        return [first]
    middle = len(waypoints) // 2
    return _broken_legs(waypoints[: middle + 1], task, first) + _broken_legs(waypoints[middle:], task, first + middle)


def _broken(legs: Points, task: PathTask) -> list[Check]:
    """Return the broken limits that moving may repair."""
    checks = prove(legs, task, spare=0.0).checks
    return [check for check in checks if check.slack < 0 and check.limit in ("obstacles", "ground", "bounds")]


def _push(ends: Points, is_free: NDArray[np.bool_], check: Check, airspace: Airspace) -> None:
    """Move the free ones of a leg's ends (2, 3) in place."""
    place, ahead = np.array(check.nearest.place), ends[1] - ends[0]
    share = float(np.clip((place - ends[0]) @ ahead / max(float(ahead @ ahead), 1e-12), 0, 1))
    weights = np.array([1 - share, share]) * is_free
    if not weights.any():
        return
    push = (OVERSHOOT - check.slack) * _outwards(place, check.limit, airspace)
    ends += weights[:, None] / (weights @ [1 - share, share]) * push


def _outwards(place: Vector, limit: str, airspace: Airspace) -> Vector:
    if limit == "ground":
        return np.array([0.0, 0.0, 1.0])
    distance = airspace.obstacle_distance if limit == "obstacles" else airspace.bounds.margin
    around = place + SLOPE_STEP * np.vstack([np.eye(3), -np.eye(3)])
    values = distance(around)
    slope = np.asarray(values[:3] - values[3:])
    return slope / max(float(np.linalg.norm(slope)), 1e-12)
