"""Fly single legs slower where flights come too near; no straight gap becomes wider."""

from collections.abc import Iterator
from dataclasses import replace
from itertools import chain, count

import numpy as np

from ipoa_mission.errors import MissionError
from ipoa_mission.routing.attempt import Attempt
from ipoa_mission.routing.build import items_of_waypoints
from ipoa_mission.routing.refusal import ChangeTrials, slower
from ipoa_mission.routing.route import Route

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
    ends, changes = [item + 1 for item in items_of_waypoints(route)[1:]], [*route.speed_changes, route.legs]
    stretches = [(ends[begin], ends[end - 1]) for begin, end in zip(changes[::2], changes[1::2], strict=False)]
    which = ", ".join(f"{first} to {last}" if last > first else f"{first}" for first, last in stretches)
    yield f"items {which} are flown at {route.slow_speed:g} m/s{route.slow_reason}"


def _reason(fast: Attempt) -> str:
    guarantee = fast.guarantee
    worst = min(guarantee.forbidding, key=lambda limit: limit.slack, default=None)
    cruise = fast.scenario.vehicle.cruise_speed
    return "" if worst is None else f": at {cruise:g} m/s, {worst.to}: {worst.words(guarantee.confidence)}"
