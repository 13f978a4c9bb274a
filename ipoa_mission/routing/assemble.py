"""From a plan to a mission: choose the waypoints as the scenario asks, and build the mission that flies them.

Each mode of `scenario.route` is one way to choose: `even` as the paper resamples, `corridor` the fewest straight legs,
`spline` one smooth curve (ArduPilot), `fastest` whichever is quickest on this autopilot.
"""

import math
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, replace

from ipoa_mission.errors import BadInput, MissionError
from ipoa_mission.forecast.timing.bound import least_time
from ipoa_mission.forecast.timing.route_time import kinematics
from ipoa_mission.mission.items import Mission
from ipoa_mission.planning.plan import Plan
from ipoa_mission.routing.attempt import Attempt, Flown
from ipoa_mission.routing.build import build_mission
from ipoa_mission.routing.fastest import SEARCH, fastest_route
from ipoa_mission.routing.resample import corridor, every
from ipoa_mission.routing.route import NoRoute, Route, push_clear
from ipoa_mission.scenario import Scenario
from ipoa_mission.vehicles.autopilot import Autopilot

HALVINGS = 6  # of the step or the tolerance, before a mode gives up
NARROW = 2  # so many times halved, the waypoints lie close along the curve
TURNED_LATE = 2.5  # where PX4, which then flies slower, turns to the next waypoint [m]
MODES = ("even", "corridor", "spline", "fastest")


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
    passed_over: str = ""
    """Why `fastest` does not fly it, where it is quicker than what that flies."""


def assemble(plan: Plan, scenario: Scenario) -> Mission:
    """Make the mission that flies a plan: waypoints chosen as `scenario.route` asks, and its ending.

    Args:
        plan: the path.
        scenario: what it was planned for.

    Returns:
        Home, items, fence and rally points, the vehicle's parameters.

    Raises:
        BadInput: the start lies too low over home for a take-off to end there, or the autopilot has no such waypoints.
        NoRoute: no choice of waypoints keeps the required clearance.

    Example:
        >>> from ipoa_mission import Command, assemble, plan_path, read_scenario
        >>> scenario = read_scenario("missions/sitl.toml")
        >>> mission = assemble(plan_path(scenario, seed=7), scenario)
        >>> Command(mission.items[0].command).name
        'NAV_TAKEOFF'
    """
    return build_mission(choose_route(plan, scenario, scenario.route.mode).route, scenario)


def choose_route(plan: Plan, scenario: Scenario, mode: str) -> Attempt:
    """The waypoints that one mode chooses; their legs, and the path that is predicted, keep the required clearance.

    Raises:
        NoRoute: none that were tried do; it has the widest and a narrow one.
    """
    if mode == "fastest":
        return fastest_route(plan, scenario) or choose_route(plan, scenario, "corridor")
    choose, width = _chooser(plan, scenario, mode)
    tried = list[Attempt]()
    for _ in range(HALVINGS):
        tried.append(attempt := choose(width))
        if attempt.proof.holds and attempt.sketched.keeps_limits:
            return attempt
        width /= 2
    proof = attempt.proof
    why = "flights would come too close too often" if proof.holds else proof.words()
    hint = "plan with a larger safety_distance, or ask for a smaller route.tolerance or route.spacing"
    refused = NoRoute(f"the legs between waypoints come too close: {why}", hint, code="legs-too-near")
    refused.tried = tried[0].route, tried[NARROW].route
    raise refused


def best_route(plan: Plan, scenario: Scenario, promising: float) -> Attempt:
    """The best of the quick routes, and of all where that is short of a limit by less than `promising` [m]."""
    quick = _first_promised(_near_routes(plan, scenario))
    if not quick.is_promised and quick.slack < promising:
        return quick
    whole = _first_promised(_routes(plan, scenario))  # another path makes endings clear, and no slower route
    return whole if whole.is_promised else max(quick, whole, key=lambda attempt: attempt.merit)


def _first_promised(attempts: Iterable[Attempt]) -> Attempt:
    """The first of them that is, or else the one that comes nearest to it."""
    seen = list[Attempt]()
    for attempt in attempts:
        seen.append(attempt)
        if attempt.is_promised:
            return attempt
    return max(seen, key=lambda attempt: attempt.slack)


def _routes(plan: Plan, scenario: Scenario) -> Iterator[Attempt]:
    """The route of the scenario's mode; where the fastest is not promised, those of other modes."""
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
                modes.remove("corridor")  # that was its last resort


def _near_routes(plan: Plan, scenario: Scenario) -> tuple[Attempt, ...]:
    """A few routes of the scenario's mode, chosen quickly; nobody looked whether they keep anything."""
    mode = scenario.route.mode
    choose, width = _chooser(plan, scenario, "corridor" if mode == "fastest" else mode)
    wide, narrow = choose(width), choose(width / 2**NARROW)
    if mode != "fastest":
        return wide, narrow
    takes_radius = scenario.vehicle.autopilot.guidance.takes_radius
    late = (replace(narrow, route=replace(narrow.route, radius=TURNED_LATE)),) if takes_radius else ()
    return wide, narrow, *late, choose(width / 2 ** (2 * NARROW))


def weigh_routes(plan: Plan, scenario: Scenario, chosen: Attempt | None = None) -> tuple[Option, ...]:
    """Weigh every mode that this autopilot can fly against the others.

    Args:
        plan: the path.
        scenario: what it was planned for.
        chosen: the try of the scenario's own mode, if it is known and keeps its limits.

    Returns:
        What each would come to, quickest first.

    Raises:
        BadInput, NoRoute: as `assemble`, where nothing is `chosen` and the scenario's own mode fails; the others are
            left out where they do.

    Example:
        >>> from ipoa_mission import plan_path, read_scenario, weigh_routes
        >>> scenario = read_scenario("missions/sitl.toml")
        >>> "fastest" in [option.mode for option in weigh_routes(plan_path(scenario, seed=7), scenario)]
        True
    """
    needed, attempts = scenario.route.mode, dict[str, tuple[Attempt, bool]]()
    for mode in sorted(MODES, key=lambda mode: mode != needed):
        try:
            attempt = choose_route(plan, scenario, mode) if mode != needed or chosen is None else chosen
        except (BadInput, NoRoute):
            if mode == needed:
                raise
            continue
        attempts[mode] = attempt, attempt is chosen or not attempt.draft.promise.forbidding
    least = min([_least_time(plan, scenario), *(round(attempt.flown.seconds, 3) for attempt, _ in attempts.values())])
    options, of_needed = [], attempts[needed][0].flown
    for mode, (attempt, is_clear) in attempts.items():
        seconds, away = round(attempt.flown.seconds, 3), round(attempt.flown.deviation, 3)
        is_quicker = needed == "fastest" and attempt.flown.seconds < of_needed.seconds
        why = _passed_over(attempt, of_needed, is_clear) if is_quicker else ""
        options.append(Option(mode, attempt.route, seconds, away, is_clear, round(seconds / least, 4), why))
    return tuple(sorted(options, key=lambda option: (option.seconds, option.mode != "fastest")))


def _passed_over(attempt: Attempt, chosen: Flown, is_clear: bool) -> str:
    """Why a route is not the fastest, though it is quicker than the `chosen` one."""
    flown, tolerance = attempt.flown, attempt.scenario.route.tolerance
    if not is_clear:
        return "not clear"
    if flown.deviation > tolerance:
        return f"more than {tolerance:g} m off the curve"
    if flown.overrun > SEARCH.most_overrun:
        return "would brake beyond the goal"
    if flown.seconds + flown.late > (1 - SEARCH.equal_share) * (chosen.seconds + chosen.late):
        return "hardly quicker"
    try:
        return "not sought" if attempt.holds else "its ending is not clear"
    except MissionError as error:
        return str(error)


def _least_time(plan: Plan, scenario: Scenario) -> float:
    """What no vehicle with these limits can beat on the planned curve [s]."""
    vehicle = scenario.vehicle
    limits = kinematics(vehicle.autopilot, vehicle.autopilot_parameters(), vehicle.cruise_speed)
    return least_time(plan.curve.sample(max(2, math.ceil(plan.curve.length))), limits).seconds


def expect_mode(mode: str, autopilot: Autopilot) -> None:
    """Complain of a mode that chooses waypoints which an autopilot does not fly."""
    if mode == "spline" and not autopilot.guidance.flies_splines:
        raise BadInput("expected even, corridor or fastest: only ArduPilot flies spline waypoints", place="route.mode")


def _chooser(plan: Plan, scenario: Scenario, mode: str) -> tuple[Callable[[float], Attempt], float]:
    """How a mode chooses waypoints by a width, moved clear, and the width that the scenario asks for [m]."""
    expect_mode(mode, scenario.vehicle.autopilot)
    via = scenario.via_points

    def choose(width: float) -> Attempt:
        points = corridor(plan.curve, width, via=via) if mode == "corridor" else every(plan.curve, width, via)
        return Attempt(plan, Route(push_clear(points, scenario), spline=mode == "spline"), scenario)

    return choose, scenario.route.tolerance if mode == "corridor" else scenario.route.spacing
