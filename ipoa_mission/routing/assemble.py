"""Choose the route of a plan, and assemble its mission."""

from collections.abc import Iterator
from dataclasses import replace

from ipoa_mission.autopilot.autopilot import Autopilot, registered
from ipoa_mission.errors import BadInput
from ipoa_mission.mission.items import Mission
from ipoa_mission.planning.planner import Plan
from ipoa_mission.routing.attempt import Attempt
from ipoa_mission.routing.build import build_mission
from ipoa_mission.routing.fastest import fastest_routes
from ipoa_mission.routing.resample import NoRoute, Route, corridor, every, push_clear
from ipoa_mission.scenario import Scenario

HALVINGS = 5  # before a mode gives up
NARROW = 2  # halvings


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
    """Return the route of a mode; raise NoRoute if no tried one keeps the required clearance."""
    attempt = fastest_routes(plan, scenario)[0] if mode == "fastest" else narrowed_route(plan, scenario, mode)
    if attempt.keeps_limits:
        return attempt
    attempt.draft.expect_known_path()
    proof = attempt.proof
    why = "flights would come too close too often" if proof.is_proved else proof.words()
    hint = "plan with a larger safety_distance, or ask for a smaller route.tolerance or route.spacing"
    raise NoRoute(f"the legs between waypoints come too close: {why}", hint, code="legs-too-near")


def best_route(
    plan: Plan, scenario: Scenario, promising: float, is_moved: bool = False, thorough: bool = False
) -> tuple[Attempt, float]:
    """Return the best route of the mode, or a quick try that lacks more than `promising` [m] or a contingency.

    Also return the time that a path without contingencies would take [s]. Along a path that `is_moved` no other route
    is sought while the quick try lacks a contingency, unless `thorough`.
    """
    if scenario.route.mode != "fastest":
        route = narrowed_route(plan, scenario, scenario.route.mode)
        return route, route.quick_prediction.seconds
    quick = _quick_route(plan, scenario)
    if (is_moved and not thorough and quick.short) or (not quick.is_guaranteed and quick.slack < promising):
        return quick, quick.quick_prediction.seconds
    first, *_ = routes = fastest_routes(plan, scenario)
    for route in routes:
        if route.is_acceptable:
            return route, route.quick_prediction.seconds
        if quick.short and not thorough:
            return quick, first.quick_prediction.seconds
    best = first if first.is_guaranteed else max(quick, first, key=lambda attempt: attempt.merit)
    return best, best.quick_prediction.seconds


def narrowed_route(plan: Plan, scenario: Scenario, mode: str) -> Attempt:
    """Return the widest route of a mode that keeps the limits, else the narrowest."""
    expect_mode(mode, scenario.vehicle.autopilot)
    attempts = (_route(plan, scenario, mode, halvings) for halvings in range(HALVINGS))
    kept = next((attempt for attempt in attempts if attempt.keeps_limits), None)
    return kept or _route(plan, scenario, mode, HALVINGS)


def _quick_route(plan: Plan, scenario: Scenario) -> Attempt:
    """Return the first guaranteed of a few routes near the path, else the farthest from its limits."""
    tried = list[Attempt]()
    for attempt in _near_routes(plan, scenario):
        if attempt.is_guaranteed:
            return attempt
        tried.append(attempt)
    return max(tried, key=lambda attempt: attempt.slack)


def _near_routes(plan: Plan, scenario: Scenario) -> Iterator[Attempt]:
    near = _route(plan, scenario, "corridor", NARROW)
    yield near
    guidance = scenario.vehicle.autopilot.guidance
    if guidance.turns_at_acceptance_radius:
        yield replace(near, route=replace(near.route, radius=guidance.small_acceptance_radius))
    yield _route(plan, scenario, "corridor", 2 * NARROW)
    yield _route(plan, scenario, "corridor", 0)


def expect_mode(mode: str, autopilot: Autopilot) -> None:
    if mode == "spline" and not autopilot.guidance.flies_splines:
        firmwares = " and ".join(sorted({each.firmware_name for each in registered() if each.guidance.flies_splines}))
        raise BadInput(f"expected even, corridor or fastest: spline waypoints are for {firmwares}", place="route.mode")


def _route(plan: Plan, scenario: Scenario, mode: str, halvings: int) -> Attempt:
    """Return a cleared route, narrowed to half as often as `halvings`."""
    via = scenario.via_points
    if mode == "corridor":
        points, _ = corridor(plan.curve, scenario.route.tolerance / 2**halvings, via=via)
    else:
        points = every(plan.curve, scenario.route.spacing / 2**halvings, via)
    return Attempt(plan, Route(push_clear(points, scenario), spline=mode == "spline"), scenario)
