"""What one forecast's flight takes of its battery, item by item, and from where on it would not come home."""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from ipoa_mission.errors import MissionError
from ipoa_mission.forecast.forecast import Forecast
from ipoa_mission.forecast.timing.flight_model import Abort, FlightModel
from ipoa_mission.scenario.budget import battery_of, flight_energy
from ipoa_mission.vehicles.contingency import Contingency
from ipoa_mission.vehicles.energy.consumption import (
    LIFTED_DISTANCE,
    Battery,
    Consumption,
    Interval,
    NotEnoughBattery,
    shortage,
)

LOOKS = 12  # at so many times a return is reckoned at first
NEAREST_S = 1.0  # a point of no return is told so exactly [s]
NEARER = 'a rally point near there, a shorter way, a larger battery, less wind; or [safety] returns = "warn"'


class Taken(NamedTuple):
    """How long an ending takes until it has disarmed, and until it touches the ground, at least and at most [s].

    `used` is what it takes of the battery; None where nothing is known of that.
    """

    lasts: tuple[float, float]
    used: Consumption | None
    touches: tuple[float, float] | None


class ItemEnergy(NamedTuple):
    """What one item takes [Wh], and the share of the battery that is left after it; None without a battery."""

    seq: int
    takes: Interval
    left: Interval | None


class NoReturn(NamedTuple):
    """From a time [s after arming], in item `seq`, an RTL would not land with the reserve; what it `takes` from there.

    `why` says what is missing; None is taken where the vehicle does not get home at all.
    """

    time: float
    seq: int
    takes: Interval | None
    why: str

    def __str__(self) -> str:
        return f"item {self.seq}: not enough for an RTL from {self.time:.0f} s after arming on: {self.why}"


class ReserveNow(NamedTuple):
    """In flight at a time [s after arming]: the share of the battery that is `left`, and the one `planned` to be.

    It lands with the share `lands`, if the rest takes what was planned; `reserve` is required.
    """

    time: float
    left: float
    planned: float
    lands: Interval
    reserve: float

    def __str__(self) -> str:
        lands = f"lands with {self.lands.likely:.0%} ({self.lands.low:.0%} to {self.lands.high:.0%})"
        short = "NOT " if self.lands.likely < self.reserve else ""
        return f"battery {self.left:.0%}, {self.planned:.0%} planned, {lands}, {short}the {self.reserve:.0%} required"


@dataclass(frozen=True, eq=False)
class Budget:
    """A flight against its battery; `budget_of` makes it.

    Attributes:
        forecast: whose it is.
        used: what it takes, second by second.
        battery: None where the scenario has none.
    """

    forecast: Forecast
    used: Consumption
    battery: Battery | None

    def left(self, taken: Interval) -> Interval | None:
        """The share of the battery that is left when so much [Wh] was taken; None without a battery."""
        if self.battery is None:
            return None
        return Interval(*(1.0 - wh / self.battery.capacity_wh for wh in (taken.high, taken.likely, taken.low)))

    def taken(self, time: float, ended: Consumption) -> Interval:
        """What the flight takes [Wh] if it is ended at a time [s] in this way."""
        return Interval(*(now + then for now, then in zip(self.used.until(time), ended.between, strict=True)))

    def against_plan(self, left: float, time: float) -> ReserveNow | None:
        """What becomes of the reserve where so much is `left` of the battery at a time [s]; None without a battery."""
        if self.battery is None:
            return None
        until, whole, capacity = self.used.until(time), self.used.between, self.battery.capacity_wh
        rest = (max(all_of_it - so_far, 0.0) for all_of_it, so_far in zip(whole, until, strict=True))
        low, likely, high = (left - wh / capacity for wh in rest)
        planned = 1.0 - until.likely / capacity
        return ReserveNow(time, left, planned, Interval(high, likely, low), self.battery.reserve)

    @cached_property
    def items(self) -> tuple[ItemEnergy, ...]:
        """Item by item, in the order flown."""
        told, before = [], Interval(0.0, 0.0, 0.0)
        for item in self.forecast.estimate.items:
            after = self.used.until(item.done_s)
            takes = Interval(*(now - then for now, then in zip(after, before, strict=True)))
            told.append(ItemEnergy(item.seq, takes, self.left(after)))
            before = after
        return tuple(told)

    @property
    def share(self) -> float:
        """What it takes of what it may take of its battery: it is short of 1 and more; 0 without a battery."""
        if self.battery is None:
            return 0.0
        takes = self.used.between
        return max(takes.likely / self.battery.usable_wh, takes.high / self.battery.capacity_wh)

    @property
    def shortage(self) -> NotEnoughBattery | None:
        """Why the flight is refused for its energy; None where it is not."""
        return None if self.battery is None else shortage(self.used.between, self.battery)

    @property
    def refusal(self) -> NotEnoughBattery | None:
        """Why the flight is not to be planned: for its energy, or, where returns are planned, for that of an RTL."""
        if self.shortage is None and self.plans_returns and self.no_return is not None:
            return NotEnoughBattery(f"{self.no_return}", hint=NEARER, place="battery")
        return self.shortage

    @property
    def plans_returns(self) -> bool:
        """Whether an RTL is to be possible from every second."""
        return self.forecast.world.safety.returns == "planned"

    @property
    def eats_reserve(self) -> bool:
        """Whether one flight in twenty lands with less than the reserve."""
        return self.battery is not None and self.used.between.high > self.battery.usable_wh

    @property
    def words(self) -> list[str]:
        """What the flight takes and leaves in the battery, and whether that is enough, in lines."""
        lines, left = [f"energy {self.used}"], self.left(self.used.between)
        if left is not None and self.battery is not None:
            shares = f"{left.likely:.0%} ({left.low:.0%} to {left.high:.0%})"
            lines.append(
                f"lands with {shares} of {self.battery.capacity_wh:.4g} Wh, {self.battery.reserve:.0%} required"
            )
        if self.shortage is not None:
            lines.append(f"not to be flown: {self.shortage}")
        elif (late := self.no_return) is not None:
            lines.append(f"no RTL from item {late.seq} on, {late.time:.0f} s after arming: {late.why}")
        return lines

    @cached_property
    def no_return(self) -> NoReturn | None:
        """From where on an RTL would not land with the reserve; None without a battery, and where there is no such."""
        if self.battery is None:
            return None
        times = list(self._times())
        for n, time in enumerate(times):
            found = self._short_from(time)
            if found is None:
                continue
            clear = times[n - 1] if n else time
            while found.time - clear > NEAREST_S:
                between = (found.time + clear) / 2
                nearer = self._short_from(between)
                found, clear = (found, between) if nearer is None else (nearer, clear)
            return found
        return None

    def _times(self) -> Iterator[float]:
        """From its lifting off to its last moment in the air, with the ends of items between."""
        track = self.forecast.estimate.track
        flies = np.flatnonzero(np.linalg.norm(track.points - track.points[-1], axis=1) > LIFTED_DISTANCE)
        if not len(flies):
            return
        begin, end = float(track.times[flies[0]]), float(track.times[flies[-1]])
        lifted = track.times[np.argmax(np.linalg.norm(track.points - track.points[0], axis=1) > LIFTED_DISTANCE)]
        done = [item.done_s for item in self.forecast.estimate.items if max(begin, lifted) < item.done_s < end]
        some = [done[round(n)] for n in np.linspace(0, len(done) - 1, min(len(done), LOOKS))]
        yield from dict.fromkeys([*some, end])

    def _short_from(self, time: float) -> NoReturn | None:
        seq = next((item.seq for item in self.forecast.estimate.items if item.done_s >= time), 0)
        try:
            ended = flown_from(self.forecast, Contingency.RTL, time).used
        except MissionError as error:
            return NoReturn(time, seq, None, str(error))
        if ended is None or self.battery is None:
            return None
        short = shortage(self.taken(time, ended), self.battery)
        return None if short is None else NoReturn(time, seq, ended.between, str(short).removeprefix("battery: "))


def budget_of(forecast: Forecast) -> Budget | None:
    """The budget of a flight, made once; None where nothing is known of its energy.

    Raises:
        MissionError: the vehicle has no model, or does not get on.
    """
    return forecast.cached(_budget)


def refusal_of(forecast: Forecast) -> NotEnoughBattery | None:
    """Why a flight is not to be planned, its returns and all; else as `shortage_of`, and raises as it does."""
    budget = budget_of(forecast)
    return None if budget is None else budget.refusal


def shortage_of(forecast: Forecast) -> NotEnoughBattery | None:
    """Why a flight is refused for its energy; None where it is not, and where too little is known to say.

    Raises:
        MissionError: as `budget_of`.
    """
    budget = budget_of(forecast)
    return None if budget is None else budget.shortage


def _budget(forecast: Forecast) -> Budget | None:
    used = forecast.energy
    return None if used is None else Budget(forecast, used, battery_of(forecast.scenario))


def flown_from(forecast: Forecast, contingency: Contingency, time: float) -> Taken:
    """How long an RTL or LAND that is ordered at a time takes at least and at most [s], and what it takes.

    Raises:
        MissionError: the vehicle does not get on, or its model knows no such flights.
    """
    mission = forecast.mission
    order = Abort(time, contingency)
    prediction = mission.autopilot.part(FlightModel).broken_off(forecast.itinerary, mission, forecast.wind, None, order)
    track = prediction.track.between(time, np.inf)
    lasts = max(float(prediction.low[-1]) - time, 0.0), max(float(prediction.high[-1]) - time, 0.0)
    first, _, last = prediction.touched or (np.nan,) * 3
    touches = (max(first - time, 0.0), max(last - time, 0.0)) if np.isfinite(first) else None
    if len(track.times) < 2 or not track.times[-1] > track.times[0]:
        return Taken(lasts, None, touches)
    used = flight_energy(forecast.scenario, track.times, track.points, track.speeds, mission.vehicle, forecast.wind)
    return Taken(lasts, None if used is None else used.lasting(*lasts), touches)
