"""Fly single legs slower where flights come too near; no straight gap becomes wider."""

from collections.abc import Iterator
from dataclasses import replace
from itertools import chain, count

import numpy as np

from ipoa_mission.autopilot.commands import Command
from ipoa_mission.errors import MissionError
from ipoa_mission.forecast.forecast import Forecast
from ipoa_mission.mission.items import Mission
from ipoa_mission.routing.attempt import Attempt
from ipoa_mission.routing.build import items_of_waypoints
from ipoa_mission.routing.refusal import ChangeTrials, slower

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
    every = frozenset(range(attempt.route.legs))

    def at(slow: frozenset[int]) -> Attempt:
        return replace(attempt, route=replace(attempt.route, slow=slow, slow_speed=speed))

    try:
        if not at(every).holds:
            return None
        latest = at(frozenset())
        for _ in range(ROUNDS):
            if latest.holds:
                break
            slow = latest.route.slow.union(_more(latest.route.slow, leg) for leg in _too_near(latest))
            if slow == every or slow == latest.route.slow:
                return None
            latest = at(slow)
        for leg in sorted(latest.route.slow, reverse=True):  # a bend needs the leg before it
            if latest.holds and (without := at(latest.route.slow - {leg})).holds:
                latest = without
        return latest if latest.holds else None
    except MissionError:
        return None


def _too_near(attempt: Attempt) -> Iterator[int]:
    ends = np.array(items_of_waypoints(attempt.route)[1:]) + 1
    for limit in attempt.guarantee.forbidding:
        yield min(int(np.searchsorted(ends, limit.item)), len(ends) - 1)
    flight = attempt.guarantee.flight
    for one in attempt.short:
        then = min(int(np.searchsorted(flight.prediction.done, one.time)), len(flight.route.visits) - 1)
        yield min(int(np.searchsorted(ends, flight.route.visits[then].seq)), len(ends) - 1)


def _more(slow: frozenset[int], leg: int) -> int:
    before = next(n for n in range(leg, -2, -1) if n not in slow)
    return before if before >= 0 else next(n for n in count(leg) if n not in slow)


def slowed_where_needed_remarks(forecast: Forecast) -> Iterator[str]:
    """Yield which items are flown slower, and the limit that needs it."""
    mission, cruise = forecast.mission, forecast.world.vehicle.cruise_speed
    stretches = list(_stretches(mission, cruise))
    if not stretches:
        return
    asked = [item.command != Command.DO_CHANGE_SPEED or item.params[1] == cruise for item in mission.items]
    fast = replace(mission, items=tuple(item for item, stays in zip(mission.items, asked, strict=True) if stays))
    guarantee = Forecast(fast, forecast.world).guarantee
    worst = min(guarantee.forbidding, key=lambda limit: limit.slack, default=None)
    why = "" if worst is None else f": at {cruise:g} m/s, {worst.to}: {worst.words(guarantee.confidence)}"
    which = ", ".join(f"{first} to {last}" if last > first else f"{first}" for first, last, _ in stretches)
    yield f"items {which} are flown at {stretches[0][-1]:g} m/s{why}"


def _stretches(mission: Mission, cruise: float) -> Iterator[tuple[int, int, float]]:
    """Yield first item, last item and speed of each slow stretch."""
    first = None
    speed = cruise
    for seq, item in enumerate(mission.items, 1):
        is_end = seq == len(mission.items)
        if item.command == Command.DO_CHANGE_SPEED or is_end:
            if first is not None and speed < cruise:
                yield first, seq - 1, speed
            first, speed = seq + 1, item.params[1]
