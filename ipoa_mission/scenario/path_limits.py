from dataclasses import dataclass, replace

import numpy as np

from ipoa_mission.errors import BadInput
from ipoa_mission.geometry import Points, Vector
from ipoa_mission.world.airspace import Airspace

SLACK = 0.01  # [m]


@dataclass(frozen=True)
class LowZone:
    """A circle with a lower required height [m]."""

    east: float
    north: float
    radius: float
    height: float


@dataclass(frozen=True)
class Limits:
    """The limits of a path.

    Attributes:
        obstacle_distance: least [m].
        height_above_ground: least height [m].
        ceiling_above_ground: greatest height [m]; infinite: no limit.
        climb_angle: steepest climb above the horizontal [rad]; infinite: no limit.
        descent_angle: steepest descent below it [rad]; infinite: no limit.
        low_zones: circles with a lower required height.

    Example:
        >>> import numpy as np
        >>> Limits(obstacle_distance=2.0, height_above_ground=5.0).required_height(np.zeros((2, 3)))
        array([5., 5.])
    """

    obstacle_distance: float
    height_above_ground: float
    ceiling_above_ground: float = np.inf
    climb_angle: float = np.inf
    descent_angle: float = np.inf
    low_zones: tuple[LowZone, ...] = ()

    def __post_init__(self) -> None:
        are_heights = -np.inf < self.height_above_ground <= self.ceiling_above_ground
        are_angles = self.climb_angle > 0.0 and self.descent_angle > 0.0
        if not (are_heights and are_angles and 0.0 <= self.obstacle_distance < np.inf):
            words = f"expected a distance of 0 or more, a height up to the ceiling, and angles above 0, not {self}"
            raise BadInput(words, place="limits")

    def required_height(self, points: Points) -> Vector:
        """Return the required height above ground at points (n, 2 or 3), (n,) [m]."""
        required = np.full(len(points), self.height_above_ground)
        for zone in self.low_zones:
            within = np.hypot(points[:, 0] - zone.east, points[:, 1] - zone.north) <= zone.radius
            required[within] = np.minimum(required[within], zone.height)
        return required

    def tightened(self, above: float, below: float, places: Points, airspace: Airspace) -> "Limits":
        """Raise the floor of an `airspace` by `above` [m] and lower its ceiling by `below` [m].

        `places` (k, 3) remain valid; the ceiling is never below the floor.
        """
        least = self.height_above_ground + above
        ceiling = self.ceiling_above_ground
        return replace(
            self,
            height_above_ground=least,
            ceiling_above_ground=max(ceiling - below, min(ceiling, least)),
            low_zones=low_zones(places, airspace, least, min(self.climb_angle, self.descent_angle)),
        )


def without_repeats(start: Vector, via: Points, goal: Vector) -> Points:
    same_place = 1e-3  # [m]
    stops = [start]
    for place in via:
        if np.linalg.norm(place - stops[-1]) > same_place:
            stops.append(place)
    if len(stops) > 1 and np.linalg.norm(goal - stops[-1]) <= same_place:
        stops.pop()
    return np.vstack([*stops, goal])


def low_zones(spots: Points, airspace: Airspace, least: float, angle: float) -> tuple[LowZone, ...]:
    """Return circles that lower the required height around places (k, 3) below `least` [m]."""
    heights = spots[:, 2] - airspace.ground(spots)
    slope = min(0.5, float(np.tan(min(angle, 1.5))))  # of the climb-out
    return tuple(
        LowZone(float(spot[0]), float(spot[1]), float(least - height + SLACK) / slope, float(height) - SLACK)
        for spot, height in zip(spots, heights, strict=True)
        if height < least + SLACK
    )
