"""Build the mission for a plan, with the waypoints that the scenario asks for."""

from collections.abc import Callable, Iterable, Iterator
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
    """Return the route of one mode that keeps the required clearance; raise NoRoute if no tried route does."""
    attempt = _routes(plan, scenario, mode)[0]
    if attempt.keeps_limits:
        return attempt
    attempt.draft.expect_known_path()
    proof = attempt.proof
    why = "flights would come too close too often" if proof.is_proved else proof.words()
    hint = "plan with a larger safety_distance, or ask for a smaller route.tolerance or route.spacing"
    raise NoRoute(f"the legs between waypoints come too close: {why}", hint, code="legs-too-near")


def best_route(plan: Plan, scenario: Scenario, promising: float) -> Attempt:
    """Return the best route of the scenario's mode, or a quick try if that lacks more than `promising` [m]."""
    quick = _first_guaranteed(_near_routes(plan, scenario))
    if not quick.is_guaranteed and quick.slack < promising:
        return quick
    whole, *rest = _routes(plan, scenario, scenario.route.mode)
    if rest:
        return next((route for route in (whole, *rest) if route.is_acceptable), whole)
    return whole if whole.is_guaranteed else max(quick, whole, key=lambda attempt: attempt.merit)


def _routes(plan: Plan, scenario: Scenario, mode: str) -> list[Attempt]:
    return fastest_routes(plan, scenario) if mode == "fastest" else [narrowed_route(plan, scenario, mode)]


def narrowed_route(plan: Plan, scenario: Scenario, mode: str) -> Attempt:
    """Return the widest route of a mode that keeps the limits, or the narrowest."""
    choose, width = _chooser(plan, scenario, mode)
    attempts = (choose(width / 2**halvings) for halvings in range(HALVINGS))
    return next((attempt for attempt in attempts if attempt.keeps_limits), None) or choose(width / 2**HALVINGS)


def _first_guaranteed(attempts: Iterable[Attempt]) -> Attempt:
    seen = list[Attempt]()
    for attempt in attempts:
        seen.append(attempt)
        if attempt.is_guaranteed:
            return attempt
    return max(seen, key=lambda attempt: attempt.slack)


def _near_routes(plan: Plan, scenario: Scenario) -> Iterator[Attempt]:
    mode = scenario.route.mode
    choose, width = _chooser(plan, scenario, "corridor" if mode == "fastest" else mode)
    yield choose(width)
    yield (narrow := choose(width / 2**NARROW))
    if mode == "fastest":
        if (guidance := scenario.vehicle.autopilot.guidance).takes_radius:
            yield replace(narrow, route=replace(narrow.route, radius=guidance.turned_late))
        yield choose(width / 2 ** (2 * NARROW))


def expect_mode(mode: str, autopilot: Autopilot) -> None:
    if mode == "spline" and not autopilot.guidance.flies_splines:
        firmwares = " and ".join(sorted({each.firmware_name for each in registered() if each.guidance.flies_splines}))
        raise BadInput(f"expected even, corridor or fastest: spline waypoints are for {firmwares}", place="route.mode")


def _chooser(plan: Plan, scenario: Scenario, mode: str) -> tuple[Callable[[float], Attempt], float]:
    """Return a function from width [m] to a cleared route, and the asked width."""
    expect_mode(mode, scenario.vehicle.autopilot)
    via = scenario.via_points

    def choose(width: float) -> Attempt:
        points = corridor(plan.curve, width, via=via)[0] if mode == "corridor" else every(plan.curve, width, via)
        return Attempt(plan, Route(push_clear(points, scenario), spline=mode == "spline"), scenario)

    return choose, scenario.route.tolerance if mode == "corridor" else scenario.route.spacing
