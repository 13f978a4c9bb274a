"""Build the mission for a plan, with the waypoints that the scenario asks for."""

from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace

from ipoa_mission.autopilot.autopilot import Autopilot
from ipoa_mission.errors import BadInput
from ipoa_mission.mission.items import Mission
from ipoa_mission.planning.plan import Plan
from ipoa_mission.routing.attempt import Attempt
from ipoa_mission.routing.build import build_mission
from ipoa_mission.routing.fastest import fastest_route
from ipoa_mission.routing.resample import corridor, every
from ipoa_mission.routing.route import NoRoute, Route, push_clear
from ipoa_mission.scenario import Scenario

HALVINGS = 6  # before a mode gives up
NARROW = 2  # halvings
TURNED_LATE = 2.5  # acceptance radius of PX4 in slower flight [m]


def assemble_mission(plan: Plan, scenario: Scenario) -> Mission:
    """Build the mission that flies a plan, with waypoints and ending as `scenario.route` asks.

    Args:
        plan: the path.
        scenario: the scenario of the plan.

    Returns:
        Home, items, fence and rally points, the vehicle's parameters.

    Raises:
        BadInput: the start is too low for a take-off to end there, or the autopilot has no such waypoints.
        NoRoute: no choice of waypoints keeps the required clearance.

    Example:
        >>> from ipoa_mission import Command, assemble_mission, plan_path, read_scenario
        >>> scenario = read_scenario("missions/sitl.toml")
        >>> mission = assemble_mission(plan_path(scenario, seed=7), scenario)
        >>> Command(mission.items[0].command).name
        'NAV_TAKEOFF'
    """
    return build_mission(choose_route(plan, scenario, scenario.route.mode).route, scenario)


def choose_route(plan: Plan, scenario: Scenario, mode: str) -> Attempt:
    """Return the route of one mode that keeps the required clearance.

    Raises:
        NoRoute: no tried route does; `tried` holds the widest and a narrow one.
    """
    if mode == "fastest":
        return fastest_route(plan, scenario) or choose_route(plan, scenario, "corridor")
    choose, width = _chooser(plan, scenario, mode)
    tried = list[Attempt]()
    for _ in range(HALVINGS):
        tried.append(attempt := choose(width))
        if attempt.proof.is_proved and attempt.quick_prediction.keeps_limits:
            return attempt
        width /= 2
    proof = attempt.proof
    why = "flights would come too close too often" if proof.is_proved else proof.words()
    hint = "plan with a larger safety_distance, or ask for a smaller route.tolerance or route.spacing"
    refused = NoRoute(f"the legs between waypoints come too close: {why}", hint, code="legs-too-near")
    refused.tried = tried[0].route, tried[NARROW].route
    raise refused


def best_route(plan: Plan, scenario: Scenario, promising: float) -> Attempt:
    """Return the best quick route, or the best of all if it lacks less than `promising` [m]."""
    quick = _first_guaranteed(_near_routes(plan, scenario))
    if not quick.is_guaranteed and quick.slack < promising:
        return quick
    whole = _first_guaranteed(_routes(plan, scenario))
    if whole.rivals and not whole.is_acceptable:
        return next((rival for rival in whole.rivals if rival.is_acceptable), whole)
    return whole if whole.is_guaranteed else max(quick, whole, key=lambda attempt: attempt.merit)


def _first_guaranteed(attempts: Iterable[Attempt]) -> Attempt:
    seen = list[Attempt]()
    for attempt in attempts:
        seen.append(attempt)
        if attempt.is_guaranteed:
            return attempt
    return max(seen, key=lambda attempt: attempt.slack)


def _routes(plan: Plan, scenario: Scenario) -> Iterator[Attempt]:
    """Yield the scenario's mode, then other modes."""
    modes = [scenario.route.mode]
    if modes == ["fastest"]:
        modes += ["corridor", "even"]
    while modes:
        mode = modes.pop(0)
        try:
            yield choose_route(plan, scenario, mode)
        except NoRoute as error:
            yield from (Attempt(plan, route, scenario) for route in error.tried)
            if mode == "fastest":
                modes.remove("corridor")  # the fallback of `fastest`


def _near_routes(plan: Plan, scenario: Scenario) -> tuple[Attempt, ...]:
    mode = scenario.route.mode
    choose, width = _chooser(plan, scenario, "corridor" if mode == "fastest" else mode)
    wide, narrow = choose(width), choose(width / 2**NARROW)
    if mode != "fastest":
        return wide, narrow
    takes_radius = scenario.vehicle.autopilot.guidance.takes_radius
    late = (replace(narrow, route=replace(narrow.route, radius=TURNED_LATE)),) if takes_radius else ()
    return wide, narrow, *late, choose(width / 2 ** (2 * NARROW))


def expect_mode(mode: str, autopilot: Autopilot) -> None:
    if mode == "spline" and not autopilot.guidance.flies_splines:
        raise BadInput("expected even, corridor or fastest: only ArduPilot flies spline waypoints", place="route.mode")


def _chooser(plan: Plan, scenario: Scenario, mode: str) -> tuple[Callable[[float], Attempt], float]:
    """Return a function from width [m] to a cleared route, and the asked width."""
    expect_mode(mode, scenario.vehicle.autopilot)
    via = scenario.via_points

    def choose(width: float) -> Attempt:
        points = corridor(plan.curve, width, via=via) if mode == "corridor" else every(plan.curve, width, via)
        return Attempt(plan, Route(push_clear(points, scenario), spline=mode == "spline"), scenario)

    return choose, scenario.route.tolerance if mode == "corridor" else scenario.route.spacing
