"""From a plan to a mission: choose the waypoints as the scenario asks, and build the mission that flies them.

Each mode of `scenario.route` is one way to choose: `even` as the paper resamples, `corridor` the fewest straight legs,
`spline` one smooth curve (ArduPilot), `fastest` whichever is quickest on this autopilot.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass

from ipoa_mission.autopilots.vehicle import Autopilot
from ipoa_mission.errors import BadInput
from ipoa_mission.items import Mission
from ipoa_mission.planning.plan import Plan
from ipoa_mission.planning.spline import Spline
from ipoa_mission.routing.build import build_mission
from ipoa_mission.routing.fastest import fastest_route
from ipoa_mission.routing.prove_route import prove_route
from ipoa_mission.routing.resample import corridor, every
from ipoa_mission.routing.route import NoRoute, Route, push_clear
from ipoa_mission.routing.trial import flies_safely, fly
from ipoa_mission.scenario import Scenario
from ipoa_mission.timing.bound import least_time
from ipoa_mission.timing.route import kinematics

HALVINGS = 6  # of the step or the tolerance, before a mode gives up


@dataclass(frozen=True)
class Option:
    """A way to choose waypoints and what it would come to on this autopilot, from start to goal."""

    mode: str
    route: Route
    seconds: float
    deviation: float
    """How far the vehicle would leave the planned curve [m]."""
    flies_clear: bool
    """Whether the predicted path keeps every limit, corners cut and overshot."""
    ratio: float
    """How many times the least time that the planned curve takes under the same limits, or the quickest route if one
    is quicker than that, beside the curve.
    """


def assemble(plan: Plan, scenario: Scenario) -> Mission:
    """The mission that flies `plan`: waypoints chosen as `scenario.route` asks, and its ending.

    Raises:
        BadInput: the start lies too low over home for a take-off to end there, or the autopilot has no such waypoints.
        NoRoute: no choice of waypoints keeps the required clearance.
    """
    return build_mission(choose_route(plan, scenario, scenario.route.mode), scenario)


def choose_route(plan: Plan, scenario: Scenario, mode: str) -> Route:
    """The waypoints that one mode chooses; their legs keep the required clearance."""
    return MODES[mode](plan, scenario)


def weigh_routes(plan: Plan, scenario: Scenario, needed: str | None = None) -> tuple[Option, ...]:
    """What every mode that this autopilot can fly would come to, quickest first.

    Raises:
        BadInput, NoRoute: as `assemble`, of the mode that is `needed`; the others are left out where they fail.
    """
    flights = []
    for mode in sorted(MODES, key=lambda mode: mode != needed):
        try:
            route = choose_route(plan, scenario, mode)
        except (BadInput, NoRoute):
            if mode == needed:
                raise
            continue
        flights.append((mode, route, fly(route, plan.curve, scenario)))
    least = min([_least_time(plan, scenario), *(round(flown.seconds, 3) for _, _, flown in flights)])
    options = []
    for mode, route, flown in flights:
        seconds, away = round(flown.seconds, 3), round(flown.deviation, 3)
        options.append(Option(mode, route, seconds, away, flown.keeps_limits(scenario), round(seconds / least, 4)))
    return tuple(sorted(options, key=lambda option: (option.seconds, option.mode != "fastest")))


def _least_time(plan: Plan, scenario: Scenario) -> float:
    """What no vehicle with these limits can beat on the planned curve [s]."""
    vehicle = scenario.vehicle
    limits = kinematics(vehicle.autopilot, vehicle.autopilot_parameters(), vehicle.cruise_speed)
    return least_time(plan.curve.sample(max(2, math.ceil(plan.curve.length))), limits).seconds


def _even(plan: Plan, scenario: Scenario) -> Route:
    def choose(spacing: float) -> Route:
        return Route(every(plan.curve, spacing, scenario.via_points))

    return _narrowed(choose, scenario.route.spacing, plan.curve, scenario)


def _corridor(plan: Plan, scenario: Scenario) -> Route:
    def choose(tolerance: float) -> Route:
        return Route(corridor(plan.curve, tolerance, via=scenario.via_points))

    return _narrowed(choose, scenario.route.tolerance, plan.curve, scenario)


def expect_mode(mode: str, autopilot: Autopilot) -> None:
    """Complain of a mode that chooses waypoints which an autopilot does not fly."""
    if mode == "spline" and autopilot is not Autopilot.ARDUPILOT:
        raise BadInput("route.mode: expected even, corridor or fastest: only ArduPilot flies spline waypoints")


def _spline(plan: Plan, scenario: Scenario) -> Route:
    expect_mode("spline", scenario.vehicle.autopilot)

    def choose(spacing: float) -> Route:
        return Route(every(plan.curve, spacing, scenario.via_points), spline=True)

    return _narrowed(choose, scenario.route.spacing, plan.curve, scenario)


def _narrowed(choose: Callable[[float], Route], width: float, curve: Spline, scenario: Scenario) -> Route:
    """The route with the greatest width (halved until it serves) whose legs keep their limits."""
    for _ in range(HALVINGS):
        chosen = choose(width)
        route = Route(push_clear(chosen.points, scenario), chosen.spline)
        proof = prove_route(route, scenario, spare=0.0)
        if proof.holds and flies_safely(route, curve, scenario):
            return route
        width /= 2
    why = "flights would come too close too often" if proof.holds else proof.words()
    raise NoRoute(
        f"the legs between waypoints come too close: {why}",
        hint="plan with a larger safety_distance, or ask for a smaller route.tolerance or route.spacing",
    )


MODES: dict[str, Callable[[Plan, Scenario], Route]] = {
    "even": _even,
    "corridor": _corridor,
    "spline": _spline,
    "fastest": lambda plan, scenario: fastest_route(plan.curve, scenario, lambda: _corridor(plan, scenario)),
}
