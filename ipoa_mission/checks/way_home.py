"""Find a return altitude or an ending that makes the way home clear.

The way home is straight, at a height from the autopilot's parameters and the last waypoint. An autopilot above its
return altitude keeps its height: ArduCopter's RTL_ALT and PX4's RTL_RETURN_ALT are minimum heights.
"""

from collections.abc import Callable, Iterable, Iterator
from itertools import takewhile

from ipoa_mission.errors import Remedy
from ipoa_mission.forecast.clearance_task import clearance_task
from ipoa_mission.forecast.contingency.shortfalls import HEIGHT_STEP, MAX_HEIGHT, SAG
from ipoa_mission.forecast.deviation.room import with_room
from ipoa_mission.forecast.forecast import Forecast
from ipoa_mission.forecast.itinerary.flown_legs import Leg
from ipoa_mission.planning.proof import prove_ground
from ipoa_mission.scenario import Scenario

LAND = Remedy(("route", "ending"), "land")
TIGHT_PLACES = 4.0  # on the way home


def remedy(forecast: Forecast) -> tuple[str, tuple[Remedy, ...]]:
    """Return a hint and changes of the scenario that make the way home clear.

    Both name the lowest return altitude within the bounds, in steps of 5 m, that keeps the required clearance.
    Near home there may be none: an autopilot does not climb to it there.
    """
    others = 'plan the way home too, with the goal over home and this one under via; or land: route.ending = "land"'
    mission, scenario = forecast.mission, forecast.world
    by = mission.autopilot.parameter_table.return_height
    is_clear = clear_in(scenario)
    for altitude in heights_to_try(scenario):
        name, value = by.name, by.spelled(altitude)
        if is_clear(Forecast(mission.with_parameters({name: value}), scenario).ways_home):
            hint = f"{name} = {value:.0f} makes it clear, in the vehicle and under [vehicle.parameters]; or {others}"
            return hint, (Remedy(("vehicle", "parameters", name), float(round(value))), LAND)
    return others, (LAND,)


def heights_to_try(scenario: Scenario) -> Iterator[float]:
    return takewhile(lambda height: height <= scenario.airspace.bounds.upper[2], heights_above(0.0))


def heights_above(above: float) -> Iterator[float]:
    return (float(height) for height in range(HEIGHT_STEP, MAX_HEIGHT + 1, HEIGHT_STEP) if height > above)


def clear_in(scenario: Scenario) -> Callable[[Iterable[Leg]], bool]:
    """Return a test of paths for the required clearance, with room for the deviation bound."""
    roomy, required = with_room(clearance_task(scenario), TIGHT_PLACES), scenario.limits.obstacle_distance
    spare = 0.0 if scenario.safety.chance is None else SAG

    def is_clear(legs: Iterable[Leg]) -> bool:
        return all(
            roomy.airspace.obstacle_clearance(leg.points).distance >= required + spare
            and all(check.slack >= spare for check in prove_ground(leg.points, roomy))
            for leg in legs
        )

    return is_clear
