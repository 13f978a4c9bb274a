"""Where ArduCopter's RTL leads and how high it goes there: home or a rally point (4.x).

The nearest rally point, unless home is nearer and RALLY_INCL_HOME counts it, or all are farther than RALLY_LIMIT_KM.
Its height there is at least the rally point's.
"""

from collections.abc import Sequence

from ipoa_mission.vehicles.parameters import Parameters
from ipoa_mission.vehicles.returning import HOME, Place, level_distance

LEAST_CONE = 0.5  # RTL_CONE_SLOPE counts from here on


def return_height(parameters: Parameters, height: float, distance: float, goal_up: float) -> float:
    """RTL_ALT [cm] at least, RTL_CLIMB_MIN [cm] more than now, less near the goal by RTL_CONE_SLOPE."""
    least = max(0.0, height + max(0.0, parameters.get("RTL_CLIMB_MIN", 0.0) / 100))
    cone = parameters.get("RTL_CONE_SLOPE", 3.0)
    return height_by_cone(least, parameters["RTL_ALT"] / 100, cone, distance, goal_up)


def height_by_cone(least: float, top: float, cone: float, distance: float, goal_up: float) -> float:
    """`top` or the goal's height, if that is more; near the goal less, by the cone; `least` at least."""
    top = max(top, goal_up, least)
    return min(top, max(distance * cone, least)) if cone >= LEAST_CONE else top


def goal_of_return(parameters: Parameters, here: Place, rally: Sequence[Place]) -> int | None:
    """Which of the rally points a return from `here` leads to; None: home."""
    if not rally:
        return None
    ways = [level_distance(here, place) for place in rally]
    nearest = min(range(len(ways)), key=ways.__getitem__)
    limit = 1000.0 * parameters.get("RALLY_LIMIT_KM", 0.3)
    too_far = limit > 0.0 and ways[nearest] > limit
    home_is_nearer = parameters.get("RALLY_INCL_HOME", 1.0) != 0.0 and ways[nearest] >= level_distance(here, HOME)
    return None if too_far or home_is_nearer else nearest
