"""Seek a path with margins for the deviation bound: first around gaps, then through them.

The way home is planned as a leg if the straight RTL is not clear.
"""

from collections.abc import Iterator
from dataclasses import replace
from itertools import islice, pairwise
from typing import NamedTuple

from ipoa_mission.centimeters import ceil_cm, floor_cm
from ipoa_mission.errors import MissionError
from ipoa_mission.forecast.contingency.shortfalls import clear_in
from ipoa_mission.forecast.deviation.kept_limits import clearance_task, tight_places, with_margins
from ipoa_mission.forecast.deviation.law import DeviationLaw, law_of
from ipoa_mission.forecast.deviation.proximity import TYPICAL_CHANCE
from ipoa_mission.forecast.leg_limits import broken_limits
from ipoa_mission.forecast.timing.track import THINNING_TOLERANCE
from ipoa_mission.planning.obstruction import DISTANCE_TOLERANCE, NoPath, NotFound, find_closures
from ipoa_mission.planning.path_problem import PathTask, place_names
from ipoa_mission.planning.planner import Plan, is_as_printed, move_aside, plan_path
from ipoa_mission.planning.problem import prepare
from ipoa_mission.progress import Progress, silent
from ipoa_mission.routing.assemble import best_route, expect_mode, narrowed_route
from ipoa_mission.routing.attempt import Attempt
from ipoa_mission.routing.obstacle_growth import ObstacleGrowth, approximation_growth, initial_growth
from ipoa_mission.routing.refusal import ChangeTrials, refusal, slowed_where_needed, too_few_flights
from ipoa_mission.scenario import Scenario
from ipoa_mission.world.obstacles import Obstacle


class TooNarrow(MissionError, code="too-narrow"):
    """Geometry alone shows that too few flights would keep the limits."""


def expect_wide(scenario: Scenario) -> None:
    """Raise TooNarrow if every way leads through a gap below the least deviation bound."""
    chance = scenario.safety.chance
    law = law_of(scenario.vehicle.autopilot, scenario.wind.strongest)
    if chance is None or not scenario.airspace.obstacles:
        return
    if tight_places(scenario, 2 * THINNING_TOLERANCE + law.lateral_bound(chance)):
        return  # less clearance is required there
    more = least_reach(law, chance)
    wider = scenario.model_copy(update={"safety_distance": scenario.safety_distance + more})
    names = place_names(scenario.places)
    problem = prepare(wider)
    for places, gap in zip(pairwise(names), find_closures(problem, scenario.places), strict=True):
        if gap is not None and gap.needed - 2 * more < gap.width < gap.needed - DISTANCE_TOLERANCE:
            between = " and ".join(gap.names)
            east, north = gap.place
            sizes = f"{floor_cm(gap.width):.2f} m wide, and it needs {ceil_cm(gap.needed):.2f} m at least"
            leg = f", on the leg from {places[0]} to {places[1]}" if len(names) > 2 else ""
            raise TooNarrow(f"the gap between {between} is {sizes}, at east {east:.1f}, north {north:.1f} m{leg}")


def least_reach(law: DeviationLaw, chance: float) -> float:
    """Return the least extra distance next to an obstacle [m]; less above and below it."""
    vertical = [quantiles.distance(TYPICAL_CHANCE) for quantiles in (law.down, law.up)]
    facing = min(1.0, min(vertical) / law.lateral.distance(TYPICAL_CHANCE))
    reach = [quantiles.distance(chance) for quantiles in (law.down, law.up, law.lowest, law.highest)]
    reach.append(facing * law.lateral.distance(chance))
    if law.farthest is not None:
        reach.append(facing * law.farthest.distance(chance / 2))
    return max(min(reach), 0.0)


class Margin(NamedTuple):
    sharing: float
    keep_gaps: bool
    height_factor: float


# As `with_margins` takes them.
MARGINS = (
    Margin(sharing=0.5, keep_gaps=False, height_factor=0.9),
    Margin(sharing=0.5, keep_gaps=False, height_factor=9.0),
    Margin(sharing=4.0, keep_gaps=False, height_factor=9.0),
    Margin(sharing=0.5, keep_gaps=True, height_factor=0.9),
)


class SeekEffort(NamedTuple):
    hopeless_slack: float = -0.15  # [m]
    max_moves: int = 4  # of a path
    max_vain_moves: int = 2  # in a row with little gain
    min_gain: float = 0.01  # of a move [m]
    max_searches: int = 6
    seed_count: int = 2
    max_delay: float = 1.1  # ratio to the first route's time


EFFORT = SeekEffort()


def plan_with_margins(scenario: Scenario, seed: int, progress: Progress) -> Attempt:
    """Return a route along a plan whose flights keep what is required.

    Raises:
        BadInput: unknown optimizer or setting; start equal to goal; waypoints that the autopilot does not fly.
        NoPath: a given place breaks a limit, or no path was found whose flights keep them all.
        NoRoute: no waypoints of that kind keep the limits; the way from home to the start is not clear.
        Unsafe: it would touch down fast, and nothing helps.
    """
    expect_mode(scenario.route.mode, scenario.vehicle.autopilot)
    try:
        return _plan(scenario, seed, progress)
    except WayHomeBlocked:
        return _plan(by_way_of_the_goal(scenario), seed, progress)


def _plan(scenario: Scenario, seed: int, progress: Progress) -> Attempt:
    trials = ChangeTrials(scenario, lambda changed: _plan_once(changed, seed))
    try:
        attempt = seek(scenario, seed, progress)
    except TooNarrow as error:
        raise too_few_flights(str(error), ", or move the places of this leg", trials) from None
    if not attempt.is_acceptable and attempt.short:  # before a refusal every moved path has its quickest route
        attempt = seek(scenario, seed, progress, thorough=True)
    if attempt.is_acceptable:
        return attempt
    slowed = slowed_where_needed(attempt, trials)
    if slowed is None:
        raise refusal(attempt, trials)
    return slowed


def _plan_once(scenario: Scenario, seed: int) -> Attempt | None:
    try:
        attempt = seek(scenario, seed, silent, plans=1)
    except MissionError:
        return None
    return attempt if attempt.is_acceptable else None


def seek(
    scenario: Scenario, seed: int, progress: Progress, plans: int = EFFORT.max_searches, thorough: bool = False
) -> Attempt:
    """Return the first acceptable attempt of at most `plans` paths, or the next if quicker, or else the nearest.

    The next path is planned if the first lost time to its contingencies.

    Raises:
        TooNarrow: no attempt can hold.
        NoPath, NoRoute, Unsafe, BadInput: as `plan_with_margins`.
    """
    expect_wide(scenario)
    nearest: Attempt | None = None
    slow: Attempt | None = None
    no_path: NoPath | None = None
    planned = set[bytes]()
    closed = set[int]()
    for number, margins in islice(_margins_in_turn(scenario, seed, closed), plans):
        try:
            plan = plan_path(margins.world, seed=number, progress=progress)
            curve = plan.curve.control.tobytes()
            if curve in planned:
                continue
            planned.add(curve)
            progress(0.9, "choosing waypoints, proving returns")
            attempt, delay = _move_until_safe(plan, margins, scenario, thorough)
        except MissionError as error:
            if slow is not None:
                return slow
            if not isinstance(error, NoPath):
                raise
            closed.add(number)
            if margins.world is scenario and not isinstance(error, NotFound):
                raise
            no_path = error
            continue
        if slow is not None:
            return min(slow, attempt, key=lambda route: (not route.is_acceptable, route.quick_prediction.seconds))
        if attempt.is_acceptable:
            if delay < EFFORT.max_delay or plans == 1:
                return attempt
            slow = attempt
        elif nearest is None or attempt.slack > nearest.slack:
            nearest = attempt
    if slow is not None:
        return slow
    if nearest is None:
        assert no_path is not None
        raise no_path
    return nearest


class _Margins(NamedTuple):
    """`world` has enlarged obstacles; `growth` is added where an attempt is too near."""

    world: PathTask
    growth: ObstacleGrowth


def _margins_in_turn(scenario: Scenario, seed: int, closed: set[int]) -> Iterator[tuple[int, _Margins]]:
    """Yield each seed's margins, then none; for seeds in `closed`, which found no path, those that keep gaps."""
    none = initial_growth(scenario)
    for number in range(seed, seed + EFFORT.seed_count):
        tried = list[tuple[tuple[Obstacle, ...], float]]()
        for margin in MARGINS if scenario.safety.chance is not None else ():
            if number in closed and not margin.keep_gaps:
                continue
            world = with_margins(clearance_task(scenario), *margin)
            enlarged = world.airspace.obstacles, world.limits.height_above_ground
            if enlarged in tried:
                continue
            tried.append(enlarged)
            if (none.above_landings >= 0.0).any():
                world = none.enlarge(world, scenario, margin.keep_gaps)
            yield number, _Margins(world, none)
        if scenario.safety.chance is None and not is_as_printed(scenario):
            little = approximation_growth(scenario)
            yield number, _Margins(little.enlarge(scenario, scenario, gaps=True), little)
        yield number, _Margins(scenario, none)


def _move_until_safe(plan: Plan, margins: _Margins, scenario: Scenario, thorough: bool) -> tuple[Attempt, float]:
    """Return the best attempt after moving the plan aside, and its flight time over the first's."""
    best, quickest_s = best_route(plan, scenario, EFFORT.hopeless_slack, thorough=thorough)
    latest = best
    growth = margins.growth
    in_vain = 0
    for _ in range(0 if is_as_printed(scenario) else EFFORT.max_moves):
        expect_way_home(latest)
        if best.is_acceptable or in_vain == EFFORT.max_vain_moves:
            break
        growth = growth.more(latest, scenario)
        wider = (growth.enlarge(margins.world, scenario, gaps) for gaps in (False, True))
        moved = next(filter(None, (move_aside(latest.plan, world) for world in wider)), None)
        if moved is None:
            break
        latest, _ = best_route(replace(latest.plan, curve=moved), scenario, EFFORT.hopeless_slack, True, thorough)
        in_vain = 0 if latest.slack > best.slack + EFFORT.min_gain else in_vain + 1
        best = max(best, latest, key=lambda attempt: attempt.merit)
    if not best.is_guaranteed and best.slack >= EFFORT.hopeless_slack and scenario.route.mode == "fastest":
        slow = (narrowed_route(best.plan, scenario, mode) for mode in ("corridor", "even"))
        best = next((attempt for attempt in slow if attempt.is_guaranteed), best)
    return best, best.quick_prediction.seconds / quickest_s


class WayHomeBlocked(MissionError, code="way-home-blocked"):
    """The straight way home is not clear at any altitude."""


def expect_way_home(attempt: Attempt) -> None:
    """Raise WayHomeBlocked if a planned return is not clear, or the ground below if it may land."""
    scenario = attempt.scenario
    if scenario.safety.returns != "planned" or scenario.route.ending != "rtl" or leads_home(scenario):
        return
    if not attempt.is_guaranteed:
        return
    after = attempt.guarantee.flight.cruise_span[1]
    lands = any(shortfall.comes_down and shortfall.time > after for shortfall in attempt.short)
    returns = attempt.forecast.ways_home
    if lands or not clear_in(scenario)(returns) or any(broken_limits(leg, scenario) for leg in returns):
        raise WayHomeBlocked("the straight way home is not clear")


def by_way_of_the_goal(scenario: Scenario) -> Scenario:
    """Return the scenario with its goal as a via point, and a goal over home."""
    over_home = type(scenario.goal)(east=0.0, north=0.0, up=float(scenario.start_point[2]))
    return scenario.model_copy(update={"via": (*scenario.via, scenario.goal), "goal": over_home})


def leads_home(scenario: Scenario) -> bool:
    return bool((scenario.goal_point[:2] == 0.0).all())


def by_way_of_the_goal_remarks(scenario: Scenario, asked: Scenario) -> Iterator[str]:
    if leads_home(scenario) and not leads_home(asked):
        yield "the way home is planned by way of the goal, because the straight one is not clear"
