"""What a vehicle does by itself when something fails: rules as tables, and what its parameters make of them."""

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace

from ipoa_mission.vehicles.contingency import Contingency, FlightStage
from ipoa_mission.vehicles.parameters import Parameters

Series = tuple[int, int]
STATION_LOST = "ground station lost"
BY_HAND = "by hand"
"""The cause of what a pilot or a ground station orders; it is refused where it is not to be had."""


@dataclass(frozen=True)
class FailsafeAction:
    """An ending, what is tried in its place where that is not to be had, and what is to be known of it.

    `after_s`: for so long it first brakes and holds [s]. `since`: the first series that knows the value.
    """

    contingency: Contingency
    otherwise: tuple[Contingency, ...] = ()
    words: str = ""
    after_s: float = 0.0
    since: Series = (0, 0)

    def in_place(self) -> "FailsafeAction":
        """What is done where the ending is not to be had; nothing where nothing else is tried."""
        first, *rest = self.otherwise or (Contingency.CONTINUE,)
        return replace(self, contingency=first, otherwise=tuple(rest), after_s=0.0)

    def __str__(self) -> str:
        return " or ".join((self.contingency, *self.otherwise)) + (f" ({self.words})" if self.words else "")


GOES_ON = FailsafeAction(Contingency.CONTINUE)
NO_NUMBER = FailsafeAction(Contingency.UNKNOWN, words="the value is no number")


@dataclass(frozen=True)
class FailsafeRule:
    """A cause, the parameter that decides what follows it, and what follows each of its values.

    `parameter` is empty where nothing is to be chosen; `other` is what the firmware does then, and at a value that
    `answers` does not have. It looks for the cause only where one of `needs` (name and default) is more than 0.
    `until`: the first series that has it no more.
    """

    cause: str
    parameter: str
    default: float
    answers: Mapping[int, FailsafeAction]
    other: FailsafeAction
    needs: Mapping[str, float] = field(default_factory=dict)
    since: Series = (0, 0)
    until: Series = (99, 0)

    def value(self, parameters: Parameters) -> float:
        """Of the parameter that decides; NaN where there is none."""
        return parameters.get(self.parameter, self.default) if self.parameter else math.nan

    def looks(self, parameters: Parameters) -> bool:
        """Whether the vehicle looks for the cause at all."""
        return not self.needs or any(parameters.get(name, usual) > 0.0 for name, usual in self.needs.items())

    def answer(self, parameters: Parameters, series: Series) -> FailsafeAction:
        """What follows, before it is asked in which stage; parameters by their older names."""
        if not self.looks(parameters):
            return replace(GOES_ON, words=f"not looked for: {' or '.join(self.needs)} would have to be above 0")
        value = self.value(parameters)
        if not self.parameter or not math.isfinite(value):
            return NO_NUMBER if self.parameter else self.other
        found = self.answers.get(int(value), self.other)
        return found if found.since <= series else self.other

    def returns_at(self, series: Series) -> int | None:
        """The first value of the parameter at which the vehicle returns; None where it has none."""
        values = (
            value for value, one in self.answers.items() if one.contingency is Contingency.RTL and one.since <= series
        )
        return next(values, None)


@dataclass(frozen=True)
class Failsafe:
    """What follows a cause on the `route` by the parameters of a vehicle, and at other stages what differs.

    `returns_at`: the value of `parameter` with which it would return; None where it has none.
    """

    cause: str
    parameter: str
    value: float
    route: FailsafeAction
    differs: Mapping[FlightStage, FailsafeAction] = field(default_factory=dict)
    returns_at: int | None = None

    @property
    def lands_by_choice(self) -> bool:
        """Whether it lands where it is on the route, though with another value of its parameter it would return."""
        return self.route.contingency is Contingency.LAND and self.returns_at is not None

    def at(self, stage: FlightStage) -> FailsafeAction:
        """What follows in this stage of a mission."""
        return self.differs.get(stage, self.route)


@dataclass(frozen=True)
class StationLoss:
    """When a vehicle takes its ground station for lost: not heard for `timeout`, by default `usual` [s].

    `decided_by`: all parameters that decide what follows. `heeds` has the first system id of the stations that count,
    and `heeds_to` the last, where that is more; without it all count. What has several names is known by any of them.
    """

    timeout: str
    usual: float
    decided_by: tuple[str | tuple[str, ...], ...]
    heeds: tuple[str, ...] = ()
    heeds_to: str = ""

    def words(self, failsafes: Iterable[Failsafe], parameters: Parameters, station: int) -> str:
        """What follows, by the values of a vehicle, for a station with this id; nothing where they do not tell."""
        lost = next((one for one in failsafes if one.cause == STATION_LOST), None)
        if lost is None or lost.parameter not in parameters:
            return ""
        by = f"{lost.parameter} {lost.value:g}"
        if lost.route.contingency is Contingency.CONTINUE:
            also = f", {lost.route.words}" if lost.route.words else ""
            return f"without its ground station the vehicle goes on ({by}{also})"
        first = next((int(parameters[name]) for name in self.heeds if name in parameters), station)
        if not first <= station <= max(first, int(parameters.get(self.heeds_to, first))):
            return f"{by} counts for station {first}, and this one is {station}"
        seconds = parameters.get(self.timeout, self.usual)
        return f"{seconds:g} s without its ground station lead to {lost.route} ({by})"


def ordered(*contingencies: Contingency) -> tuple[FailsafeRule, ...]:
    """A rule of each that can be ordered by hand."""
    return tuple(FailsafeRule(BY_HAND, "", math.nan, {}, FailsafeAction(contingency)) for contingency in contingencies)
