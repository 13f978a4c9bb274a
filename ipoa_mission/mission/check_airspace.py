"""The legs of a mission against the world of a scenario: clearance, heights and bounds along every leg, exactly."""

from collections.abc import Iterator

import numpy as np

from ipoa_mission.mission.finding import Finding, Severity, error, warning
from ipoa_mission.mission.items import Command, Mission
from ipoa_mission.mission.legs import Leg, Phase
from ipoa_mission.scenario import Scenario

ROUNDING = 0.02  # [m] that rounding positions to 1e-7 degrees may cost
SAME_HOME = 1.0  # [m]


def check_airspace(mission: Mission, scenario: Scenario, legs: tuple[Leg, ...]) -> Iterator[Finding]:
    """Findings about home, then about each leg.

    Between waypoints a leg must keep the scenario's clearance and bounds. On the climb, on the way home and on the
    landing, which no planner chose, coming nearer is a warning, and touching something an error.
    """
    offset = np.abs(scenario.frame.local(mission.home))
    if offset.max() > SAME_HOME:
        message = f"home: lies {np.linalg.norm(offset):.1f} m from the scenario's home: heights above home differ"
        yield Finding(Severity.WARNING, 0, message)
    if any(item.command == Command.NAV_SPLINE_WAYPOINT for item in mission.items):
        message = "the mission: curves between spline waypoints are checked as straight legs"
        yield Finding(Severity.WARNING, None, message)
    for leg in legs:
        yield from _clearance(mission, scenario, leg)
        if leg.phase in (Phase.CRUISE, Phase.RETURN):
            yield from _ground(mission, scenario, leg)
            yield from _bounds(mission, scenario, leg)


def _clearance(mission: Mission, scenario: Scenario, leg: Leg) -> Iterator[Finding]:
    hull = scenario.vehicle.radius
    required = hull + scenario.safety_distance
    nearest = scenario.airspace.obstacle_clearance(leg.points)
    if nearest.distance >= required - ROUNDING:
        return
    say = error if leg.phase is Phase.CRUISE or nearest.distance < hull - ROUNDING else warning
    message = f"{_the_leg(leg)} comes too near: {nearest}: expected {required:g} m (safety distance and radius)"
    yield say(leg.seq, mission.items[leg.seq - 1], message)


def _ground(mission: Mission, scenario: Scenario, leg: Leg) -> Iterator[Finding]:
    hull, asked = scenario.vehicle.radius, scenario.planning.min_height_above_ground
    required = hull + scenario.safety_distance if asked is None else asked
    lowest = scenario.airspace.terrain_clearance(leg.points)
    item = mission.items[leg.seq - 1]
    if lowest.distance < required - ROUNDING:
        say = error if leg.phase is Phase.CRUISE or lowest.distance < hull - ROUNDING else warning
        below = "goes below the ground" if lowest.distance < 0 else "comes too near to the ground"
        yield say(leg.seq, item, f"{_the_leg(leg)} {below}: {lowest}: expected {required:g} m")
    highest = scenario.planning.max_height_above_ground
    if highest is not None:
        heights = leg.points[:, 2] - scenario.airspace.ground(leg.points)
        if heights.max() > highest + ROUNDING:
            say = error if leg.phase is Phase.CRUISE else warning
            yield say(
                leg.seq, item, f"{_the_leg(leg)} rises to {heights.max():.2f} m above ground: expected {highest:g} m"
            )


def _bounds(mission: Mission, scenario: Scenario, leg: Leg) -> Iterator[Finding]:
    margin = scenario.airspace.bounds_margin(leg.points)
    if margin.distance < -ROUNDING:
        east, north, up = margin.place
        where = f"east {east:.2f}, north {north:.2f}, up {up:.2f} m"
        say = error if leg.phase is Phase.CRUISE else warning
        message = f"{_the_leg(leg)} leaves the bounds: {-margin.distance:.2f} m beyond {margin.what} at {where}"
        yield say(leg.seq, mission.items[leg.seq - 1], message)


def _the_leg(leg: Leg) -> str:
    return {
        Phase.CRUISE: "the leg to it",
        Phase.TAKEOFF: "the climb",
        Phase.RETURN: "the way home",
        Phase.LANDING: "the descent",
    }[leg.phase]
