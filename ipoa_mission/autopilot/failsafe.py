"""Contingencies, and failsafes as rules: for each cause a parameter's value selects one and its fallbacks."""

import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field, replace
from enum import StrEnum
from typing import NamedTuple

from ipoa_mission.autopilot.parameters import Parameters, whole

Series = tuple[int, int]


class Contingency(StrEnum):
    """An action that replaces the rest of the mission."""

    RTL = "rtl"  # home or a rally point, by `Autopilot.return_route` and `return_height`
    LAND = "land"  # in place
    SMART_RTL = "smart_rtl"  # back along the flown path
    HOLD = "hold"  # until a new order or an empty battery
    CONTINUE = "continue"
    LAND_START = "land_start"  # to the mission's landing
    TERMINATE = "terminate"  # the motors stop; the vehicle falls
    UNKNOWN = "unknown"  # not modeled; see the action's `words`


COMPUTED = (Contingency.RTL, Contingency.LAND, Contingency.SMART_RTL, Contingency.HOLD)  # their paths are known
TIMED = (Contingency.RTL, Contingency.LAND)  # flight models end them on the ground
IN_PLACE = (Contingency.LAND, Contingency.HOLD)


class FlightStage(StrEnum):
    TAKEOFF = "take-off"
    ROUTE = "route"
    RETURN = "return"
    LANDING = "landing"


class Cause(StrEnum):
    LOW_BATTERY = "low battery"
    CRITICAL_BATTERY = "critical battery"
    FENCE_BREACHED = "fence breached"
    STATION_LOST = "ground station lost"
    POSITION_LOST = "position lost (EKF)"
    POSITION_INACCURATE = "position inaccurate"
    TERRAIN_UNKNOWN = "terrain data missing"
    TRAFFIC_NEAR = "traffic near"
    BY_HAND = "by hand"  # an order by a pilot or station; the vehicle refuses a mode that it cannot enter


@dataclass(frozen=True)
class FailsafeAction:
    """A contingency, and its `fallbacks`, each where the one before cannot be flown."""

    contingency: Contingency
    fallbacks: tuple[Contingency, ...] = ()
    words: str = ""  # remarks
    after_s: float = 0.0  # of a hold before it
    since: Series = (0, 0)  # the first with this value of the parameter

    def in_place(self) -> "FailsafeAction":
        first, *rest = self.fallbacks or (Contingency.CONTINUE,)
        return replace(self, contingency=first, fallbacks=tuple(rest), after_s=0.0)

    def __str__(self) -> str:
        return " or ".join((self.contingency, *self.fallbacks)) + (f" ({self.words})" if self.words else "")


GOES_ON = FailsafeAction(Contingency.CONTINUE)


@dataclass(frozen=True)
class FailsafeRule:
    cause: str
    parameter: str = ""
    actions: Mapping[int, FailsafeAction] = field(default_factory=dict)
    default: float = 0.0  # of the parameter
    usual: FailsafeAction = GOES_ON  # without a parameter, and for its values not in `actions`
    needs: Mapping[str, float] = field(default_factory=dict)  # defaults; one must be above 0, unless empty
    since: Series = (0, 0)
    until: Series = (99, 0)  # the first without the rule

    def value(self, parameters: Parameters) -> float:
        return parameters.get(self.parameter, self.default) if self.parameter else math.nan

    def is_monitored(self, parameters: Parameters) -> bool:
        return not self.needs or any(parameters.get(name, default) > 0.0 for name, default in self.needs.items())

    def action(self, parameters: Parameters, series: Series) -> FailsafeAction:
        if not self.is_monitored(parameters):
            return replace(GOES_ON, words=f"not checked: needs {' or '.join(self.needs)} above 0")
        value = self.value(parameters)
        if not self.parameter:
            return self.usual
        if not math.isfinite(value):
            return FailsafeAction(Contingency.UNKNOWN, words="the value is not a number")
        action = self.actions.get(int(value), self.usual)
        return action if action.since <= series else self.usual

    def failsafe(
        self, parameters: Parameters, series: Series, action: FailsafeAction, at: FlightStage, at_stage: FailsafeAction
    ) -> "Failsafe":
        """Return the failsafe with the `action`, and another one, `at_stage`."""
        known = {value: action for value, action in self.actions.items() if action.since <= series}
        returns = (value for value, action in known.items() if action.contingency is Contingency.RTL)
        differs = {} if at_stage == action else {at: at_stage}
        return Failsafe(self.cause, self.parameter, self.value(parameters), action, differs, next(returns, None))


@dataclass(frozen=True)
class Failsafe:
    cause: str
    parameter: str
    value: float
    action: FailsafeAction  # in cruise
    differs: Mapping[FlightStage, FailsafeAction] = field(default_factory=dict)  # the actions of other stages
    returns_at: int | None = None  # the parameter's value with RTL

    @property
    def lands_by_choice(self) -> bool:
        """Return whether the vehicle lands although another value would return."""
        return self.action.contingency is Contingency.LAND and self.returns_at is not None

    def at(self, stage: FlightStage) -> FailsafeAction:
        return self.differs.get(stage, self.action)


class StationLoss(NamedTuple):
    """Parameters of a lost ground station; a tuple lists names of one parameter."""

    timeout: str  # of its silence [s]
    default_s: float
    decided_by: tuple[str | tuple[str, ...], ...]
    heeds: tuple[str, ...] = ()  # the first system id that counts
    heeds_to: str = ""  # the last one

    def words(self, failsafes: Iterable[Failsafe], parameters: Parameters, station: int) -> str:
        """Return the action for a station's id; empty if unknown."""
        lost = next((failsafe for failsafe in failsafes if failsafe.cause == Cause.STATION_LOST), None)
        if lost is None or lost.parameter not in parameters:
            return ""
        by = f"{lost.parameter} {lost.value:g}"
        if lost.action.contingency is Contingency.CONTINUE:
            also = f", {lost.action.words}" if lost.action.words else ""
            return f"without its ground station the vehicle continues ({by}{also})"
        first = next((whole(parameters, name) for name in self.heeds if name in parameters), station)
        if not first <= station <= max(first, whole(parameters, self.heeds_to, first)):
            return f"{by} counts for station {first}, not for this one ({station})"
        seconds = parameters.get(self.timeout, self.default_s)
        return f"{seconds:g} s without its ground station lead to {lost.action} ({by})"


def order_rules(*contingencies: Contingency) -> tuple[FailsafeRule, ...]:
    return tuple(FailsafeRule(Cause.BY_HAND, usual=FailsafeAction(contingency)) for contingency in contingencies)


class FailsafeProfile(NamedTuple):
    """A vehicle's rules, and the function that resolves them by parameters of older names."""

    rules: tuple[FailsafeRule, ...] = ()
    resolve: Callable[[Parameters, Series], tuple[Failsafe, ...]] = lambda *_: ()
    further_parameters: tuple[str, ...] = ()
    station_loss: StationLoss | None = None

    @property
    def parameters(self) -> frozenset[str]:
        of_rules = (name for rule in self.rules for name in (rule.parameter, *rule.needs) if name)
        return frozenset((*of_rules, *self.further_parameters))

    def defaults(self, series: Series) -> dict[str, float]:
        values = dict[str, float]()
        for rule in self.rules:
            if rule.since <= series < rule.until:
                values |= {rule.parameter: rule.default} if rule.parameter else {}
                values |= rule.needs
        return values


class FenceLimit(NamedTuple):
    """A limit [m] and its parameter; infinite: none."""

    name: str
    value: float


class OwnFence(NamedTuple):
    """Distance from home, and heights between take-off and landing [m]."""

    radius: FenceLimit
    ceiling: FenceLimit
    floor: FenceLimit
