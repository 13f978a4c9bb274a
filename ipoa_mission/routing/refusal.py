"""Refuse a plan, with its tightest place and a change that helps, or fly single legs slower.

Slower flights stray less; no straight gap becomes wider.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import chain, count

import numpy as np

from ipoa_mission.centimeters import ceil_cm, floor_cm
from ipoa_mission.errors import MissionError, Remedy
from ipoa_mission.forecast.deviation.clearance_guarantee import KeptLimit
from ipoa_mission.planning.obstruction import NoPath
from ipoa_mission.planning.path_problem import place_names
from ipoa_mission.routing.attempt import Attempt
from ipoa_mission.routing.build import items_of_waypoints
from ipoa_mission.routing.planned_returns import other_options_hint, why_not_planned
from ipoa_mission.routing.resample import Route
from ipoa_mission.scenario import Scenario
from ipoa_mission.world.airspace import Airspace
from ipoa_mission.world.obstacles import Obstacle


@dataclass(frozen=True, eq=False)
class ChangeTrials:
    """`planned` returns None without a valid plan."""

    scenario: Scenario
    planned: Callable[[Scenario], Attempt | None]
    _seen: dict[Remedy, Attempt | None] = field(default_factory=dict)

    @cached_property
    def changes(self) -> dict[Remedy, Scenario]:
        return dict(slower(self.scenario)) | dict(_otherwise(self.scenario))

    def at(self, change: Remedy) -> Attempt | None:
        if change not in self._seen:
            self._seen[change] = self.planned(self.changes[change])
        return self._seen[change]


def slower(scenario: Scenario) -> Iterator[tuple[Remedy, Scenario]]:
    for share in (0.5, 0.25):
        speed = max(round(share * scenario.vehicle.cruise_speed, 1), 0.5)  # [m/s]
        vehicle = scenario.vehicle.model_copy(update={"cruise_speed": speed})
        yield Remedy(("vehicle", "cruise_speed"), speed), scenario.model_copy(update={"vehicle": vehicle})


def _otherwise(scenario: Scenario) -> Iterator[tuple[Remedy, Scenario]]:
    if scenario.route.mode != "fastest":
        route = scenario.route.model_copy(update={"mode": "fastest"})
        yield Remedy(("route", "mode"), "fastest"), scenario.model_copy(update={"route": route})
    lower = 0.9
    if scenario.safety.confidence != "nominal" and scenario.safety.confidence > lower:
        safety = scenario.safety.model_copy(update={"confidence": lower})
        yield Remedy(("safety", "confidence"), lower), scenario.model_copy(update={"safety": safety})


def refusal(nearest: Attempt, trials: ChangeTrials) -> NoPath:
    guarantee = nearest.guarantee
    if nearest.short:
        helps, hint, remedies = _try_changes("", trials)
        words = f"a path exists, but {why_not_planned(nearest.forecast)}; {helps}"
        return NoPath(words, hint=f"{hint}; {other_options_hint(nearest.forecast)}", remedies=remedies)
    tightest = min(guarantee.forbidding, key=lambda limit: limit.slack)
    east, north, height = tightest.place
    where = f"at east {east:.1f}, north {north:.1f}, up {height:.1f} m{_leg(nearest, tightest)}"
    if tightest.limit == "obstacles":
        words = _gap(tightest, nearest.scenario.airspace)
    else:
        words = f"{tightest.to}, where {tightest.words(guarantee.confidence)}"
    return too_few_flights(f"{words}, {where}", ", or add a via point that leads round", trials)


def too_few_flights(words: str, otherwise: str, trials: ChangeTrials) -> NoPath:
    who, chance = f"on {trials.scenario.vehicle.autopilot}", trials.scenario.safety.chance
    if chance is None:
        why = f"a path exists, but flights {who} would leave its limits"
    else:
        why = f"a path exists, but fewer than {100 * (1 - chance):g} % of flights {who} would keep its limits"
    helps, hint, remedies = _try_changes(otherwise, trials)
    return NoPath(f"{why}: {words}; {helps}", hint=hint, remedies=remedies)


def _leg(nearest: Attempt, tightest: KeptLimit) -> str:
    at, curve = nearest.plan.via_at, nearest.plan.curve
    if not len(at):
        return ""
    along = np.linspace(0.0, 1.0, 2000)
    here = along[np.argmin(np.linalg.norm(curve.points(along) - np.array(tightest.place), axis=1))]
    names = place_names(nearest.scenario.places)
    leg = int(np.searchsorted(at, here))
    return f", on the leg from {names[leg]} to {names[leg + 1]}"


def _gap(tightest: KeptLimit, airspace: Airspace) -> str:
    spot = np.array(tightest.place)
    needed = tightest.required + tightest.nominal - tightest.guaranteed
    apart, other = _across(spot, tightest.to, needed, airspace)
    if other is not None and apart < 2 * needed:
        names = f"{tightest.to} and {other}"
        return f"the gap between {names} is {floor_cm(apart):.2f} m wide, and it needs {ceil_cm(2 * needed):.2f} m"
    return f"{floor_cm(tightest.nominal):.2f} m from {tightest.to}, where it needs {ceil_cm(needed):.2f} m"


def _across(spot: np.ndarray, name: str, needed: float, airspace: Airspace) -> tuple[float, str | None]:
    """Return the level width [m] to the opposite obstacle, and its name or None."""
    import shapely

    point = shapely.Point(spot[:2])
    bodies = [body for body, _, _ in airspace.near(spot[None], 4 * needed)]
    named = (body for body in bodies if body.name == name)
    first = min(named, key=lambda body: float(body.distance(spot[None])[0]), default=None)
    if first is None:
        return np.inf, None

    def towards(body: Obstacle) -> np.ndarray:
        line = shapely.shortest_line(point, body.horizontal_shape)
        return np.asarray(np.diff(shapely.get_coordinates(line), axis=0)[0])

    ahead = towards(first)
    best = np.inf
    opposite_name = None
    max_cosine = -0.5  # between the directions to both sides of a gap
    for body in bodies:
        aside = towards(body)
        cosine = float(aside @ ahead) / max(float(np.linalg.norm(aside) * np.linalg.norm(ahead)), 1e-9)
        width = float(shapely.distance(body.horizontal_shape, first.horizontal_shape))
        if body is not first and cosine <= max_cosine and width < best:
            best, opposite_name = width, body.name
    return best, opposite_name


def _try_changes(otherwise: str, trials: ChangeTrials) -> tuple[str, str, tuple[Remedy, ...]]:
    tried = list[Remedy]()
    for change in trials.changes:
        if (attempt := trials.at(change)) is None:
            tried.append(change)
            continue
        clearance = attempt.guarantee.clearance
        with_it = "" if clearance is None else f" with {floor_cm(clearance.guaranteed):.2f} m kept"
        return f"{change} plans it{with_it}", f"{change}, which was tried; or reduce safety_distance", (change,)
    return (f"these changes did not help: {', '.join(map(str, tried))}", f"reduce safety_distance{otherwise}", ())


ROUNDS = 20


def slowed_where_needed(nearest: Attempt, trials: ChangeTrials) -> Attempt | None:
    changes = dict(slower(trials.scenario))
    speeds = [changed.vehicle.cruise_speed for changed in changes.values()]
    speeds = [speed for speed in speeds if speed < trials.scenario.vehicle.cruise_speed]
    for trial in chain([nearest], map(trials.at, changes)):
        if trial is not None:
            here = replace(trial, scenario=trials.scenario)
            slowed = [attempt for speed in speeds if (attempt := _slowed(here, speed)) is not None]
            if slowed:
                return min(slowed, key=lambda attempt: attempt.forecast.estimate.total_s)
    return None


def _slowed(attempt: Attempt, speed: float) -> Attempt | None:
    """Return the attempt with the fewest legs at this speed [m/s]."""
    every, reason = frozenset(range(attempt.route.legs)), ""

    def at(slow: frozenset[int]) -> Attempt:
        return replace(attempt, route=replace(attempt.route, slow=slow, slow_speed=speed, slow_reason=reason))

    try:
        if not at(every).is_acceptable:
            return None
        latest = at(frozenset())
        reason = _reason(latest)
        for _ in range(ROUNDS):
            if latest.is_acceptable:
                break
            slow = latest.route.slow.union(_more(latest.route.slow, leg) for leg in _too_near(latest))
            if slow == every or slow == latest.route.slow:
                return None
            latest = at(slow)
        for leg in sorted(latest.route.slow, reverse=True):  # a bend needs the leg before it
            if latest.is_acceptable and (without := at(latest.route.slow - {leg})).is_acceptable:
                latest = without
        return latest if latest.is_acceptable else None
    except MissionError:
        return None


def _too_near(attempt: Attempt) -> Iterator[int]:
    ends = np.array(items_of_waypoints(attempt.route)[1:]) + 1
    for limit in attempt.guarantee.forbidding:
        yield min(int(np.searchsorted(ends, limit.item)), len(ends) - 1)
    flight = attempt.guarantee.flight
    for shortfall in attempt.short:
        then = min(int(np.searchsorted(flight.prediction.done, shortfall.time)), len(flight.route.visits) - 1)
        yield min(int(np.searchsorted(ends, flight.route.visits[then].seq)), len(ends) - 1)


def _more(slow: frozenset[int], leg: int) -> int:
    before = next(n for n in range(leg, -2, -1) if n not in slow)
    return before if before >= 0 else next(n for n in count(leg) if n not in slow)


def slowed_where_needed_remarks(route: Route) -> Iterator[str]:
    if not route.slow:
        return
    ends = [item + 1 for item in items_of_waypoints(route)[1:]]
    changes = [*route.speed_changes, route.legs]
    stretches = [(ends[begin], ends[end - 1]) for begin, end in zip(changes[::2], changes[1::2], strict=False)]
    which = ", ".join(f"{first} to {last}" if last > first else f"{first}" for first, last in stretches)
    yield f"items {which} are flown at {route.slow_speed:g} m/s{route.slow_reason}"


def _reason(fast: Attempt) -> str:
    guarantee = fast.guarantee
    worst = min(guarantee.forbidding, key=lambda limit: limit.slack, default=None)
    cruise = fast.scenario.vehicle.cruise_speed
    return "" if worst is None else f": at {cruise:g} m/s, {worst.to}: {worst.words(guarantee.confidence)}"
