"""Goal and height of ArduCopter's RTL (4.x).

It flies to the nearest rally point inside its own fence, at least at that height. Home counts if nearer and
RALLY_INCL_HOME, or if all are beyond RALLY_LIMIT_KM. Not modeled: polygon fences, and OA_TYPE.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

from ipoa_mission.autopilot.parameters import Parameters
from ipoa_mission.autopilot.returning import HOME, OverTerrain, Place, level_distance
from ipoa_mission.vehicles.arducopter.own_fence import is_within, return_ceiling
from ipoa_mission.vehicles.arducopter.parameter_table import PARAMETER_TABLE

LEAST_CONE = 0.5  # RTL_CONE_SLOPE below is ignored
LEAST_HEIGHT = 0.3  # RTL_ALT_MIN [m]
ABOVE_TERRAIN = 1.0  # RTL_ALT_TYPE


class CopterReturn(NamedTuple):
    """RTL_ALT, RTL_CLIMB_MIN [m], RTL_CONE_SLOPE, and the fence's limit [m]."""

    altitude: float
    climb: float
    cone: float
    ceiling: float

    @classmethod
    def of(cls, parameters: Parameters) -> "CopterReturn":
        p = {**PARAMETER_TABLE.moving, **parameters}
        climb = max(p["RTL_CLIMB_MIN"] / 100, 0.0)
        return cls(p["RTL_ALT"] / 100, climb, p["RTL_CONE_SLOPE"], return_ceiling(p))

    def height(self, above: float, distance: float, goal_up: float) -> float:
        """Return the height above home [m], from `above` home over a level distance to `goal_up`.

        Near the goal the cone limits it, and FENCE_MARGIN below a ceiling. It never descends for a limit.
        """
        least = max(LEAST_HEIGHT, above + self.climb)
        top = max(self.altitude, goal_up, least)
        if self.cone >= LEAST_CONE:
            top = min(top, max(distance * self.cone, least))
        return max(min(top, self.ceiling), above)


def goal_of_return(parameters: Parameters, here: Place, rally: Sequence[Place]) -> int | None:
    """Return the index of RTL's rally point; None: home."""
    ways = {n: level_distance(here, place) for n, place in enumerate(rally) if is_within(parameters, place)}
    if not ways:
        return None
    nearest = min(ways, key=ways.__getitem__)
    limit = 1000.0 * parameters.get("RALLY_LIMIT_KM", 0.3)
    too_far = limit > 0.0 and ways[nearest] > limit
    home_is_nearer = parameters.get("RALLY_INCL_HOME", 1.0) != 0.0 and ways[nearest] >= level_distance(here, HOME)
    return None if too_far or home_is_nearer else nearest


def over_terrain(parameters: Parameters) -> OverTerrain | None:
    """RTL_ALT_TYPE 1 needs a range finder or terrain data.

    While a range finder sees no ground, it acts as RTL_ALT_TYPE 0. Arming needs terrain data without one.
    """
    seen = parameters.get("RNGFND1_TYPE", 0.0) > 0.0 and parameters.get("WPNAV_RFND_USE", 1.0) > 0.0
    knows = seen or parameters.get("TERRAIN_ENABLE", 1.0) > 0.0
    if not (knows and math.isclose(parameters.get("RTL_ALT_TYPE", 0.0), ABOVE_TERRAIN)):
        return None
    return OverTerrain(max(parameters.get("WPNAV_TER_MARGIN", 10.0), 0.1), not seen)
