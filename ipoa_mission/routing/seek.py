"""A path with room for the tube: sought where there is room all round first, then through the gaps that are left."""

from dataclasses import replace

import numpy as np

from ipoa_mission.planning.cost import curve_cost
from ipoa_mission.planning.plan import Plan
from ipoa_mission.planning.planner import NoPath, plan_path
from ipoa_mission.planning.proof import prove_curve
from ipoa_mission.progress import Progress
from ipoa_mission.routing.assemble import Option, choose_route, expect_mode, weigh_routes
from ipoa_mission.routing.build import draft_mission
from ipoa_mission.routing.route import NoRoute
from ipoa_mission.scenario import Scenario
from ipoa_mission.tube.promise import Kept, Promise, promise_of
from ipoa_mission.tube.room import with_room
from ipoa_mission.world.obstacles import Obstacle

#: At how many tight places the tube is given room, and whether gaps stay open; tried in this order until a route is
#: safe. Less room than is needed for sure is quicker, and mostly enough.
ROOMS = ((0.5, False), (4.0, False), (0.5, True))
AROUND = 50.0  # what is on the other side of a gap is looked for so far away [m]
SLOWER = (0.5, 0.25)  # shares of the cruise speed that are tried before a gap is called too narrow at any speed


def plan_with_room(scenario: Scenario, seed: int, progress: Progress) -> tuple[Plan, tuple[Option, ...]]:
    """A plan and what each mode of choosing waypoints would come to on it, quickest first.

    Raises:
        BadInput: the optimizer is unknown, or has no such setting; start and goal are the same place; the autopilot
            does not fly the kind of waypoints that the scenario asks for.
        NoPath: a given place breaks a limit, no path was found that keeps them all, or too few flights would keep them.
    """
    expect_mode(scenario.route.mode, scenario.vehicle.autopilot)
    if scenario.safety.chance is None:
        plan = plan_path(scenario, seed, progress)
        return plan, weigh_routes(plan, scenario)
    sought, closed = list[tuple[Obstacle, ...]](), False
    for tight, keep_gaps in ROOMS:
        roomy = with_room(scenario, tight, keep_gaps)
        if (closed and not keep_gaps) or roomy.airspace.obstacles in sought:
            continue  # where there is no path, there is none with more room
        sought.append(roomy.airspace.obstacles)
        try:
            plan = plan_path(roomy, seed, progress)
        except NoPath:
            closed = True
            continue
        plan = replace(plan, cost=curve_cost(plan.curve, scenario), proof=prove_curve(plan.curve, scenario))
        try:
            return plan, weigh_routes(plan, scenario)
        except NoRoute:
            continue
    raise _too_narrow(plan_path(scenario, seed, progress), scenario)


def _too_narrow(plan: Plan, scenario: Scenario) -> NoPath:
    """Why too few flights would keep the limits on a plan that keeps them itself."""
    promise = _best_promise(plan, scenario)
    tightest = None if promise is None else min(promise.limits, key=lambda kept: kept.slack, default=None)
    if promise is None or promise.confidence is None or tightest is None:
        return NoPath("no choice of waypoints keeps the limits in enough flights")
    share = f"{100 * promise.confidence:g} % of flights"
    autopilot = scenario.vehicle.autopilot
    east, north, up = tightest.place
    where = f"at east {east:.1f}, north {north:.1f}, up {up:.1f} m"
    if tightest.limit == "obstacles":
        words = _gap(tightest, scenario)
    else:
        words = f"{tightest.to}, where {tightest.words(promise.confidence)}"
    fits = _speed_that_fits(plan, scenario)
    speed = f"it would fit at {fits:g} m/s" if fits else "no lower speed helps"
    return NoPath(
        f"a path is there, but {share} on {autopilot} would not keep it: {words}, {where}; {speed}",
        hint=f"{f'vehicle.cruise_speed = {fits:g}, or ' if fits else ''}a smaller safety_distance, a lower "
        'safety.confidence, or "nominal" for what the predicted path keeps',
    )


def _best_promise(plan: Plan, scenario: Scenario) -> Promise | None:
    """What the most cautious route of a plan would promise, were it flown."""
    nominal = scenario.model_copy(update={"safety": scenario.safety.model_copy(update={"confidence": "nominal"})})
    missions = [draft_mission(option.route, scenario) for option in weigh_routes(plan, nominal)]
    promises = [promise_of(mission, scenario) for mission in missions]
    return max(promises, key=lambda promise: min(kept.slack for kept in promise.limits), default=None)


def _gap(tightest: Kept, scenario: Scenario) -> str:
    """The gap at a place: between what, how wide, and what this autopilot needs."""
    spot, needed = np.array([tightest.place]), tightest.required + tightest.nominal - tightest.kept
    near = {body.name: float(apart[0]) for body, _, apart in scenario.airspace.near(spot, AROUND)}
    beside = near.pop(tightest.to, tightest.nominal)
    if not near:
        return f"{tightest.nominal:.2f} m from {tightest.to}, where it needs {needed:.2f} m"
    other = min(near, key=lambda name: near[name])
    width = beside + near[other]
    return f"the gap between {tightest.to} and {other} is {width:.2f} m wide, and it needs {2 * needed:.2f} m"


def _speed_that_fits(plan: Plan, scenario: Scenario) -> float | None:
    """The highest of some lower cruise speeds [m/s] at which the plan could be flown; None if there is none."""
    for share in SLOWER:
        speed = round(share * scenario.vehicle.cruise_speed, 1)
        slower = scenario.model_copy(
            update={"vehicle": scenario.vehicle.model_copy(update={"cruise_speed": max(speed, 0.5)})}
        )
        try:
            choose_route(plan, slower, scenario.route.mode)
        except NoRoute:
            continue
        return speed
    return None
