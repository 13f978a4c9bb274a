"""What a path must keep: distance to obstacles, height above ground, climb angles, bounds.

Start, goal and via points may lie lower than the least height above ground: the scenario puts them there, and the
vehicle takes off and lands vertically. Round such a place the requirement is relaxed to the place's own height, over
a circle wide enough to climb out of at 1 in 2 (or at the climb limit, if that is flatter).
"""

from dataclasses import dataclass

import numpy as np

from ipoa_mission.geometry import Points, Vector
from ipoa_mission.scenario import Scenario

SLACK = 0.01  # a place that is lower by less than this is not lower [m]
CLIMB_OUT = 0.5  # height over distance
SAME = 1e-3  # places as near as this are one [m]


@dataclass(frozen=True)
class LowZone:
    """A circle in which the ground may be as near as `height` [m]."""

    east: float
    north: float
    radius: float
    height: float


@dataclass(frozen=True)
class Limits:
    """What a path must keep; infinite where there is no limit. Angles in radians above and below the horizontal."""

    obstacle_distance: float
    height_above_ground: float
    ceiling_above_ground: float
    climb_angle: float
    descent_angle: float
    low_zones: tuple[LowZone, ...]

    def required_height(self, points: Points) -> Vector:
        """The height above ground that is required at points (n, 2 or 3), (n,) [m]."""
        required = np.full(len(points), self.height_above_ground)
        for zone in self.low_zones:
            within = np.hypot(points[:, 0] - zone.east, points[:, 1] - zone.north) <= zone.radius
            required[within] = np.minimum(required[within], zone.height)
        return required


def limits_of(scenario: Scenario) -> Limits:
    """The limits that a scenario sets."""
    planning = scenario.planning
    distance = scenario.vehicle.radius + scenario.safety_distance
    height = planning.min_height_above_ground
    angles = (planning.max_climb_angle_deg, planning.max_descent_angle_deg)
    climb, descent = (np.inf if angle is None else float(np.radians(angle)) for angle in angles)
    least = distance if height is None else height
    return Limits(
        distance,
        least,
        planning.max_height_above_ground or np.inf,
        climb,
        descent,
        _low_zones(scenario, least, min(climb, descent)),
    )


def places(scenario: Scenario) -> Points:
    """Start, via points and goal, in this order, (k, 3); a via point where the way already is counts once."""
    stops = [scenario.start_point]
    for via in scenario.via_points:
        if np.linalg.norm(via - stops[-1]) > SAME:
            stops.append(via)
    if len(stops) > 1 and np.linalg.norm(scenario.goal_point - stops[-1]) <= SAME:
        stops.pop()
    return np.vstack([*stops, scenario.goal_point])


def _low_zones(scenario: Scenario, least: float, angle: float) -> tuple[LowZone, ...]:
    spots = places(scenario)
    heights = spots[:, 2] - scenario.airspace.ground(spots)
    slope = min(CLIMB_OUT, float(np.tan(min(angle, 1.5))))
    return tuple(
        LowZone(float(spot[0]), float(spot[1]), float(least - height + SLACK) / slope, float(height) - SLACK)
        for spot, height in zip(spots, heights, strict=True)
        if height < least + SLACK
    )
