from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from ipoa_mission.autopilot.energy import Battery, Interval, NotEnoughBattery, shortage
from ipoa_mission.autopilot.failsafe import Contingency
from ipoa_mission.errors import MissionError
from ipoa_mission.forecast.contingency.contingencies import predict_contingency
from ipoa_mission.forecast.flight_energy import LIFTED_DISTANCE, Consumption, battery_of
from ipoa_mission.forecast.forecast import Forecast

RETURN_HINT = 'a rally point near there, a shorter way, a larger battery, less wind; or [safety] returns = "warn"'


class ItemEnergy(NamedTuple):
    seq: int
    takes: Interval
    left: Interval | None


class NoReturn(NamedTuple):
    """An RTL from `time` [s after arming] on lands without the reserve; `takes`: None if it never gets home."""

    time: float
    seq: int
    takes: Interval | None
    why: str

    def __str__(self) -> str:
        return f"item {self.seq}: not enough for an RTL from {self.time:.0f} s after arming on: {self.why}"


@dataclass(frozen=True)
class ReserveNow:
    """Shares of the charge at a time [s after arming]; `lands` if the rest takes the planned energy."""

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
    forecast: Forecast
    used: Consumption
    battery: Battery | None

    def left(self, taken: Interval) -> Interval | None:
        if self.battery is None:
            return None
        return Interval(*(1.0 - wh / self.battery.capacity_wh for wh in (taken.high, taken.likely, taken.low)))

    def taken(self, time: float, ended: Consumption) -> Interval:
        return self.used.until(time).plus(ended.between)

    def against_plan(self, left: float, time: float) -> ReserveNow | None:
        if self.battery is None:
            return None
        until = self.used.until(time)
        capacity = self.battery.capacity_wh
        remaining = self.used.between.rest_after(until)
        lands = Interval(*(left - max(wh, 0.0) / capacity for wh in reversed(remaining)))
        return ReserveNow(time, left, 1.0 - until.likely / capacity, lands, self.battery.reserve)

    @cached_property
    def items(self) -> tuple[ItemEnergy, ...]:
        items = list[ItemEnergy]()
        before = Interval(0.0, 0.0, 0.0)
        for item in self.forecast.estimate.items:
            after = self.used.until(item.done_s)
            items.append(ItemEnergy(item.seq, after.rest_after(before), self.left(after)))
            before = after
        return tuple(items)

    @property
    def share(self) -> float:
        if self.battery is None:
            return 0.0
        takes = self.used.between
        return max(takes.likely / self.battery.usable_wh, takes.high / self.battery.capacity_wh)

    @property
    def shortage(self) -> NotEnoughBattery | None:
        return None if self.battery is None else shortage(self.used.between, self.battery)

    @property
    def refusal(self) -> NotEnoughBattery | None:
        if self.shortage is None and self.plans_returns and self.no_return is not None:
            return NotEnoughBattery(f"{self.no_return}", hint=RETURN_HINT, place="battery")
        return self.shortage

    @property
    def plans_returns(self) -> bool:
        return self.forecast.world.safety.returns == "planned"

    @property
    def words(self) -> list[str]:
        lines, left = [f"energy {self.used}"], self.left(self.used.between)
        if left is not None and self.battery is not None:
            shares = f"{left.likely:.0%} ({left.low:.0%} to {left.high:.0%})"
            lines.append(
                f"lands with {shares} of {self.battery.capacity_wh:.4g} Wh, {self.battery.reserve:.0%} required"
            )
        if self.shortage is not None:
            lines.append(f"refused: {self.shortage}")
        elif (late := self.no_return) is not None:
            lines.append(f"no RTL from item {late.seq} on, {late.time:.0f} s after arming: {late.why}")
        return lines

    @cached_property
    def no_return(self) -> NoReturn | None:
        if self.battery is None:
            return None
        times = list(self._times())
        for n, time in enumerate(times):
            if (short := self._short_from(time)) is None:
                continue
            clear = times[n - 1] if n else time
            while short.time - clear > 1.0:  # [s]
                between = (short.time + clear) / 2
                nearer = self._short_from(between)
                short, clear = (short, between) if nearer is None else (nearer, clear)
            return short
        return None

    def _times(self) -> Iterator[float]:
        track = self.forecast.estimate.track
        flies = np.flatnonzero(np.linalg.norm(track.points - track.points[-1], axis=1) > LIFTED_DISTANCE)
        if not len(flies):
            return
        begin, end = float(track.times[flies[0]]), float(track.times[flies[-1]])
        lifted = track.times[np.argmax(np.linalg.norm(track.points - track.points[0], axis=1) > LIFTED_DISTANCE)]
        done = [item.done_s for item in self.forecast.estimate.items if max(begin, lifted) < item.done_s < end]
        yield from dict.fromkeys([*(done[round(n)] for n in np.linspace(0, len(done) - 1, min(len(done), 12))), end])

    def _short_from(self, time: float) -> NoReturn | None:
        seq = next((item.seq for item in self.forecast.estimate.items if item.done_s >= time), 0)
        try:
            ended = predict_contingency(self.forecast, Contingency.RTL, time).used
        except MissionError as error:
            return NoReturn(time, seq, None, str(error))
        if ended is None or self.battery is None:
            return None
        short = shortage(self.taken(time, ended), self.battery)
        return None if short is None else NoReturn(time, seq, ended.between, str(short).removeprefix("battery: "))


def budget_of(forecast: Forecast) -> Budget | None:
    return forecast.cached(_budget)


def _budget(forecast: Forecast) -> Budget | None:
    used = forecast.energy
    return None if used is None else Budget(forecast, used, battery_of(forecast.scenario))


def refusal_of(forecast: Forecast) -> NotEnoughBattery | None:
    budget = budget_of(forecast)
    return None if budget is None else budget.refusal
