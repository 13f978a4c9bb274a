"""Where ArduCopter's RTL leads and how high it goes there: home or a rally point (4.x).

The nearest rally point, unless home is nearer and RALLY_INCL_HOME counts it, or all are farther than RALLY_LIMIT_KM.
Its height there is at least the rally point's. Rally points outside the fence of its own are none; whether one is
outside a mission's polygons is not asked here. Ways around obstacles (OA_TYPE) are not modeled.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

from ipoa_mission.vehicles.arducopter.own_fence import is_within, return_ceiling
from ipoa_mission.vehicles.arducopter.parameter_table import PARAMETER_TABLE
from ipoa_mission.vehicles.parameters import Parameters
from ipoa_mission.vehicles.returning import HOME, OverTerrain, Place, level_distance

LEAST_CONE = 0.5  # RTL_CONE_SLOPE counts from here on
LEAST_HEIGHT = 0.3  # RTL_ALT_MIN [m]
ABOVE_TERRAIN = 1.0  # RTL_ALT_TYPE


class CopterReturn(NamedTuple):
    """How high ArduCopter returns: RTL_ALT, RTL_CLIMB_MIN [m], RTL_CONE_SLOPE, and below its fence's ceiling [m]."""

    altitude: float
    climb: float
    cone: float
    ceiling: float

    @classmethod
    def of(cls, parameters: Parameters) -> "CopterReturn":
        """By these parameters, by their older names; what is not given has ArduCopter's default."""
        p = {**PARAMETER_TABLE.moving, **parameters}
        climb = max(p["RTL_CLIMB_MIN"] / 100, 0.0)
        return cls(p["RTL_ALT"] / 100, climb, p["RTL_CONE_SLOPE"], return_ceiling(p))

    def height(self, above: float, distance: float, goal_up: float) -> float:
        """How high above home it returns from so high `above` it [m], so far away, to a goal of the height `goal_up`.

        RTL_ALT, the goal's height and RTL_CLIMB_MIN more than now at least; near the goal no more than the cone asks
        for, under a fence no more than FENCE_MARGIN below it; it never comes down for that.
        """
        least = max(LEAST_HEIGHT, above + self.climb)
        top = max(self.altitude, goal_up, least)
        if self.cone >= LEAST_CONE:
            top = min(top, max(distance * self.cone, least))
        return max(min(top, self.ceiling), above)


def goal_of_return(parameters: Parameters, here: Place, rally: Sequence[Place]) -> int | None:
    """Which of the rally points a return from `here` leads to; None: home."""
    ways = {n: level_distance(here, place) for n, place in enumerate(rally) if is_within(parameters, place)}
    if not ways:
        return None
    nearest = min(ways, key=ways.__getitem__)
    limit = 1000.0 * parameters.get("RALLY_LIMIT_KM", 0.3)
    too_far = limit > 0.0 and ways[nearest] > limit
    home_is_nearer = parameters.get("RALLY_INCL_HOME", 1.0) != 0.0 and ways[nearest] >= level_distance(here, HOME)
    return None if too_far or home_is_nearer else nearest


def over_terrain(parameters: Parameters) -> OverTerrain | None:
    """With RTL_ALT_TYPE 1, and a range finder that navigation uses, or terrain data, without which it is not armed.

    With neither it is as 0, and so is a range finder that does not see the ground.
    """
    seen = parameters.get("RNGFND1_TYPE", 0.0) > 0.0 and parameters.get("WPNAV_RFND_USE", 1.0) > 0.0
    knows = seen or parameters.get("TERRAIN_ENABLE", 1.0) > 0.0
    if not (knows and math.isclose(parameters.get("RTL_ALT_TYPE", 0.0), ABOVE_TERRAIN)):
        return None
    return OverTerrain(max(parameters.get("WPNAV_TER_MARGIN", 10.0), 0.1), not seen)
