"""Change a scenario, or fly single legs slower, where flights come too near; no straight gap becomes wider."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import chain, count

import numpy as np

from ipoa_mission.autopilot.commands import Command
from ipoa_mission.errors import MissionError, Remedy
from ipoa_mission.forecast.forecast import Forecast
from ipoa_mission.mission.items import Mission
from ipoa_mission.routing.attempt import Attempt
from ipoa_mission.routing.build import items_of_waypoints
from ipoa_mission.scenario import Scenario

ROUNDS = 20
SPEED_SHARES = (0.5, 0.25)
LEAST_SPEED = 0.5  # [m/s]
LOWER_CONFIDENCES = (0.9,)


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
    for share in SPEED_SHARES:
        speed = max(round(share * scenario.vehicle.cruise_speed, 1), LEAST_SPEED)
        vehicle = scenario.vehicle.model_copy(update={"cruise_speed": speed})
        yield Remedy(("vehicle", "cruise_speed"), speed), scenario.model_copy(update={"vehicle": vehicle})


def _otherwise(scenario: Scenario) -> Iterator[tuple[Remedy, Scenario]]:
    if scenario.route.mode != "fastest":
        route = scenario.route.model_copy(update={"mode": "fastest"})
        yield Remedy(("route", "mode"), "fastest"), scenario.model_copy(update={"route": route})
    for confidence in LOWER_CONFIDENCES:
        if scenario.safety.confidence != "nominal" and scenario.safety.confidence > confidence:
            safety = scenario.safety.model_copy(update={"confidence": confidence})
            yield Remedy(("safety", "confidence"), confidence), scenario.model_copy(update={"safety": safety})


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
