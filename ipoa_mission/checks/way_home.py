"""The way home: straight, as high as the autopilot's parameters and the last waypoint say, over whatever stands there.

An autopilot that returns from above its return altitude stays as high as it is (ArduCopter's RTL_ALT and PX4's
RTL_RETURN_ALT are least heights), so a mission can see to a clear way home whatever the vehicle's
parameters are.
"""

from collections.abc import Iterable, Iterator
from dataclasses import replace
from itertools import takewhile

from ipoa_mission.commands import Command
from ipoa_mission.items import Mission, waypoint
from ipoa_mission.itinerary.legs import Leg, Phase, flown_legs
from ipoa_mission.planning.proof import prove, prove_heights
from ipoa_mission.scenario import Scenario
from ipoa_mission.tube.room import with_room
from ipoa_mission.world.frame import Geodetic

HEIGHT_STEP, HIGHEST = 5, 500  # [m] above home
TIGHT_PLACES = 4.0  # at so many tight places the tube has room on the way home
SAG = 0.3  # the predicted way home is up to so much lower than it is set [m]


def raise_way_home(mission: Mission, scenario: Scenario) -> Mission:
    """The mission with a waypoint high over its last place, if its way home is not clear and that makes it so.

    The waypoint has the lowest of every five metres above home at which the way home keeps the required clearance; the
    climb to it must do so, within the bounds. If there is none the mission stays as it is. A spline waypoint before it
    is held for a second: if it flew on, ArduCopter's curve would dip first, to rise there.
    """
    if mission.items[-1].command != Command.NAV_RETURN_TO_LAUNCH:
        return mission
    roomy = with_room(scenario, TIGHT_PLACES)
    if _is_clear(_ways_home(mission, scenario), roomy):
        return mission
    last = mission.items[-2]
    stopped = replace(last, params=(1.0, *last.params[1:])) if last.command == Command.NAV_SPLINE_WAYPOINT else last
    above = Geodetic(last.latitude_deg, last.longitude_deg, mission.home.altitude)
    for height in _heights(mission.altitude_above_home(last)):
        climb = waypoint(above, height)
        raised = replace(mission, items=(*mission.items[:-2], stopped, climb, mission.items[-1]))
        way_up, *ways = (
            leg
            for leg in flown_legs(raised, scenario.frame, scenario.airspace.ground)
            if leg.seq == len(mission.items) or leg.phase is Phase.RETURN
        )
        if any(check.slack < 0 for check in prove(way_up.points, scenario).checks if check.limit != "climb"):
            return mission
        if _is_clear(ways, roomy):
            return raised
    return mission


def remedy(mission: Mission, scenario: Scenario) -> str:
    """What a user can do about a way home that leads through something, in one line.

    It names the lowest of every five metres of return altitude within the bounds at which the way home keeps the
    required clearance, if one does: near home an autopilot does not climb to it.
    """
    others = 'plan the way home too, with the goal over home and this one under via; or land: route.ending = "land"'
    by = mission.autopilot.book.return_height
    roomy = with_room(scenario, TIGHT_PLACES)
    for altitude in heights_to_try(scenario):
        name, value = by.name, by.spelled(altitude)
        if _is_clear(_ways_home(mission.with_parameters({name: value}), scenario), roomy):
            return f"{name} = {value:.0f} makes it clear, in the vehicle and under [vehicle.parameters]; or {others}"
    return others


def climb_for_way_home(mission: Mission) -> Iterator[str]:
    """That it climbs over its last place before it returns, where it does."""
    match mission.items:
        case (*_, before, last, end) if end.command == Command.NAV_RETURN_TO_LAUNCH:
            there = (last.latitude_deg, last.longitude_deg) == (before.latitude_deg, before.longitude_deg)
            if there and last.altitude > before.altitude:
                seq = len(mission.items) - 1
                yield f"item {seq}: climbs to {last.altitude:.0f} m over the goal, for a clear way home"


def heights_to_try(scenario: Scenario) -> Iterator[float]:
    """Return altitudes within the bounds, the lowest first [m]."""
    return takewhile(lambda height: height <= scenario.airspace.bounds.upper[2], _heights(0.0))


def _heights(above: float) -> Iterator[float]:
    return (float(height) for height in range(HEIGHT_STEP, HIGHEST + 1, HEIGHT_STEP) if height > above)


def _ways_home(mission: Mission, scenario: Scenario) -> list[Leg]:
    legs = flown_legs(mission, scenario.frame, scenario.airspace.ground)
    return [leg for leg in legs if leg.phase is Phase.RETURN]


def _is_clear(legs: Iterable[Leg], roomy: Scenario) -> bool:
    spare, required = 0.0 if roomy.safety.chance is None else SAG, roomy.limits.obstacle_distance
    return all(
        roomy.airspace.obstacle_clearance(leg.points).distance >= required + spare
        and all(check.slack >= spare for check in prove_heights(leg.points, roomy) if check.limit == "ground")
        for leg in legs
    )
