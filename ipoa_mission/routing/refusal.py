"""Refuse a plan, with its tightest place and a change that helps, or fly single legs slower."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import chain, count

import numpy as np

from ipoa_mission.centimeters import ceil_cm, floor_cm
from ipoa_mission.errors import MissionError, Remedy
from ipoa_mission.forecast.deviation.clearance_guarantee import KeptLimit
from ipoa_mission.geometry import Vector, place_words
from ipoa_mission.planning.obstruction import NoPath
from ipoa_mission.planning.path_problem import place_names
from ipoa_mission.routing.attempt import Attempt
from ipoa_mission.routing.build import items_of_waypoints
from ipoa_mission.routing.planned_returns import other_options_hint, why_not_planned
from ipoa_mission.routing.resample import Route
from ipoa_mission.scenario import Scenario
from ipoa_mission.world.airspace import Airspace
from ipoa_mission.world.obstacles import Obstacle

ROUNDS = 20


@dataclass(frozen=True, eq=False)
class ChangeTrials:
    """Changes of a scenario, each planned once."""

    scenario: Scenario
    plan: Callable[[Scenario], Attempt | None]
    _attempts: dict[Remedy, Attempt | None] = field(default_factory=dict)

    @cached_property
    def changes(self) -> dict[Remedy, Scenario]:
        return dict(_slower(self.scenario)) | dict(_other_changes(self.scenario))

    def attempt(self, change: Remedy) -> Attempt | None:
        if change not in self._attempts:
            self._attempts[change] = self.plan(self.changes[change])
        return self._attempts[change]


def _slower(scenario: Scenario) -> Iterator[tuple[Remedy, Scenario]]:
    for share in (0.5, 0.25):
        speed = max(round(share * scenario.vehicle.cruise_speed, 1), 0.5)  # [m/s]
        vehicle = scenario.vehicle.model_copy(update={"cruise_speed": speed})
        yield Remedy(("vehicle", "cruise_speed"), speed), scenario.model_copy(update={"vehicle": vehicle})


def _other_changes(scenario: Scenario) -> Iterator[tuple[Remedy, Scenario]]:
    if scenario.route.mode != "fastest":
        route = scenario.route.model_copy(update={"mode": "fastest"})
        yield Remedy(("route", "mode"), "fastest"), scenario.model_copy(update={"route": route})
    lower = 0.9
    if scenario.safety.confidence != "nominal" and scenario.safety.confidence > lower:
        safety = scenario.safety.model_copy(update={"confidence": lower})
        yield Remedy(("safety", "confidence"), lower), scenario.model_copy(update={"safety": safety})


def refusal(nearest: Attempt, trials: ChangeTrials) -> NoPath:
    """Return an error with a change that plans, if any."""
    if nearest.short:
        helps, hint, remedies = _try_changes("", trials)
        words = f"a path exists, but {why_not_planned(nearest.forecast)}; {helps}"
        return NoPath(words, hint=f"{hint}; {other_options_hint(nearest.forecast)}", remedies=remedies)
    guarantee = nearest.guarantee
    tightest = min(guarantee.forbidding, key=lambda limit: limit.slack)
    where = place_words(tightest.place) + _leg(nearest, tightest)
    if tightest.limit == "obstacles":
        words = _gap(tightest, nearest.scenario.airspace)
    else:
        words = f"{tightest.to}, where {tightest.words(guarantee.confidence)}"
    return too_few_flights(f"{words}, {where}", ", or add a via point that leads round", trials)


def too_few_flights(words: str, otherwise: str, trials: ChangeTrials) -> NoPath:
    who = f"on {trials.scenario.vehicle.autopilot}"
    chance = trials.scenario.safety.chance
    if chance is None:
        why = f"a path exists, but flights {who} would leave its limits"
    else:
        why = f"a path exists, but fewer than {100 * (1 - chance):g} % of flights {who} would keep its limits"
    helps, hint, remedies = _try_changes(otherwise, trials)
    return NoPath(f"{why}: {words}; {helps}", hint=hint, remedies=remedies)


def _leg(nearest: Attempt, tightest: KeptLimit) -> str:
    via_at = nearest.plan.via_at
    if not len(via_at):
        return ""
    parameters = np.linspace(0.0, 1.0, 2000)
    away = np.linalg.norm(nearest.plan.curve.points(parameters) - np.array(tightest.place), axis=1)
    names = place_names(nearest.scenario.places)
    leg = int(np.searchsorted(via_at, parameters[np.argmin(away)]))
    return f", on the leg from {names[leg]} to {names[leg + 1]}"


def _gap(tightest: KeptLimit, airspace: Airspace) -> str:
    place = np.array(tightest.place)
    needed = tightest.required + tightest.nominal - tightest.guaranteed
    width, opposite = _opposite(place, tightest.to, needed, airspace)
    if opposite is not None and width < 2 * needed:
        names = f"{tightest.to} and {opposite}"
        return f"the gap between {names} is {floor_cm(width):.2f} m wide, and it needs {ceil_cm(2 * needed):.2f} m"
    return f"{floor_cm(tightest.nominal):.2f} m from {tightest.to}, where it needs {ceil_cm(needed):.2f} m"


def _opposite(place: Vector, name: str, needed: float, airspace: Airspace) -> tuple[float, str | None]:
    """Return the width [m] of the gap at `place`, and the name opposite to `name`."""
    import shapely

    point = shapely.Point(place[:2])
    bodies = [body for body, _, _ in airspace.near(place[None], 4 * needed)]
    same_name = [body for body in bodies if body.name == name]
    if not same_name:
        return np.inf, None
    tight = min(same_name, key=lambda body: float(body.distance(place[None])[0]))

    def direction_to(body: Obstacle) -> Vector:
        line = shapely.shortest_line(point, body.horizontal_shape)
        return np.asarray(np.diff(shapely.get_coordinates(line), axis=0)[0])

    def is_opposite(body: Obstacle) -> bool:
        direction = direction_to(body)
        lengths = float(np.linalg.norm(direction) * np.linalg.norm(ahead))
        max_cosine = -0.5  # of directions to both sides of a gap
        return body is not tight and float(direction @ ahead) / max(lengths, 1e-9) <= max_cosine

    def width(body: Obstacle) -> float:
        return float(shapely.distance(body.horizontal_shape, tight.horizontal_shape))

    ahead = direction_to(tight)
    opposite = min(filter(is_opposite, bodies), key=width, default=None)
    return (np.inf, None) if opposite is None else (width(opposite), opposite.name)


def _try_changes(otherwise: str, trials: ChangeTrials) -> tuple[str, str, tuple[Remedy, ...]]:
    in_vain = list[Remedy]()
    for change in trials.changes:
        attempt = trials.attempt(change)
        if attempt is None:
            in_vain.append(change)
            continue
        clearance = attempt.guarantee.clearance
        with_it = "" if clearance is None else f" with {floor_cm(clearance.guaranteed):.2f} m kept"
        return f"{change} plans it{with_it}", f"{change}, which was tried; or reduce safety_distance", (change,)
    return (f"these changes did not help: {', '.join(map(str, in_vain))}", f"reduce safety_distance{otherwise}", ())


def slowed_where_needed(nearest: Attempt, trials: ChangeTrials) -> Attempt | None:
    changes = dict(_slower(trials.scenario))
    speeds = [changed.vehicle.cruise_speed for changed in changes.values()]
    speeds = [speed for speed in speeds if speed < trials.scenario.vehicle.cruise_speed]
    for attempt in chain([nearest], map(trials.attempt, changes)):
        if attempt is None:
            continue
        usual = replace(attempt, scenario=trials.scenario)
        slowed = list(filter(None, (_slowed(usual, speed) for speed in speeds)))
        if slowed:
            return min(slowed, key=lambda attempt: attempt.forecast.estimate.total_s)
    return None


def _slowed(attempt: Attempt, speed: float) -> Attempt | None:
    """Return the attempt with the fewest legs at this speed [m/s]."""
    all_legs = frozenset(range(attempt.route.legs))
    reason = ""

    def with_slow(slow: frozenset[int]) -> Attempt:
        return replace(attempt, route=replace(attempt.route, slow=slow, slow_speed=speed, slow_reason=reason))

    try:
        if not with_slow(all_legs).is_acceptable:
            return None
        latest = with_slow(frozenset())
        reason = _reason(latest)
        for _ in range(ROUNDS):
            if latest.is_acceptable:
                break
            slow = latest.route.slow.union(_next_fast(latest.route.slow, leg) for leg in _legs_too_near(latest))
            if slow == all_legs or slow == latest.route.slow:
                return None
            latest = with_slow(slow)
        if not latest.is_acceptable:
            return None
        for leg in sorted(latest.route.slow, reverse=True):  # a bend needs the leg before it
            faster = with_slow(latest.route.slow - {leg})
            if faster.is_acceptable:
                latest = faster
        return latest
    except MissionError:
        return None


def _legs_too_near(attempt: Attempt) -> Iterator[int]:
    ends = np.array(items_of_waypoints(attempt.route)[1:]) + 1
    for limit in attempt.guarantee.forbidding:
        yield min(int(np.searchsorted(ends, limit.item)), len(ends) - 1)
    flight = attempt.guarantee.flight
    for shortfall in attempt.short:
        visit = min(int(np.searchsorted(flight.prediction.done, shortfall.time)), len(flight.itinerary.visits) - 1)
        yield min(int(np.searchsorted(ends, flight.itinerary.visits[visit].seq)), len(ends) - 1)


def _next_fast(slow: frozenset[int], leg: int) -> int:
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
