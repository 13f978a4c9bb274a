"""The way home: straight, as high as the autopilot's parameters and the last waypoint say, over whatever stands there.

An autopilot that returns from above its return altitude stays as high as it is (ArduCopter's RTL_ALT and PX4's
RTL_RETURN_ALT are least heights), so a mission can see to a clear way home whatever the vehicle's
parameters are.
"""

from collections.abc import Callable, Iterable, Iterator
from itertools import takewhile

from ipoa_mission.errors import Remedy
from ipoa_mission.forecast.deviation.room import with_room
from ipoa_mission.forecast.forecast import Forecast
from ipoa_mission.forecast.itinerary.flown_legs import Leg
from ipoa_mission.forecast.shortfalls import HEIGHT_STEP, HIGHEST, SAG
from ipoa_mission.planning.proof import prove_ground
from ipoa_mission.scenario import Scenario

LAND = Remedy(("route", "ending"), "land")
TIGHT_PLACES = 4.0  # at so many tight places the tube has room on the way home


def remedy(forecast: Forecast) -> tuple[str, tuple[Remedy, ...]]:
    """Return what a user can do about a way home that leads through something, in one line and as changes.

    It names the lowest of every five metres of return altitude within the bounds at which the way home keeps the
    required clearance, if one does: near home an autopilot does not climb to it.
    """
    others = 'plan the way home too, with the goal over home and this one under via; or land: route.ending = "land"'
    mission, scenario = forecast.mission, forecast.world
    by = mission.autopilot.book.return_height
    is_clear = clear_in(scenario)
    for altitude in heights_to_try(scenario):
        name, value = by.name, by.spelled(altitude)
        if is_clear(Forecast(mission.with_parameters({name: value}), scenario).ways_home):
            hint = f"{name} = {value:.0f} makes it clear, in the vehicle and under [vehicle.parameters]; or {others}"
            return hint, (Remedy(("vehicle", "parameters", name), float(round(value))), LAND)
    return others, (LAND,)


def heights_to_try(scenario: Scenario) -> Iterator[float]:
    """Return altitudes within the bounds, the lowest first [m]."""
    return takewhile(lambda height: height <= scenario.airspace.bounds.upper[2], heights_above(0.0))


def heights_above(above: float) -> Iterator[float]:
    """Every five meters above a height [m]."""
    return (float(height) for height in range(HEIGHT_STEP, HIGHEST + 1, HEIGHT_STEP) if height > above)


def clear_in(scenario: Scenario) -> Callable[[Iterable[Leg]], bool]:
    """What tells of ways whether they keep what is required of them, with room for the tube."""
    roomy, required = with_room(scenario, TIGHT_PLACES), scenario.limits.obstacle_distance
    spare = 0.0 if scenario.safety.chance is None else SAG

    def is_clear(legs: Iterable[Leg]) -> bool:
        return all(
            roomy.airspace.obstacle_clearance(leg.points).distance >= required + spare
            and all(check.slack >= spare for check in prove_ground(leg.points, roomy))
            for leg in legs
        )

    return is_clear
