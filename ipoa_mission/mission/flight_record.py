from dataclasses import dataclass
from enum import StrEnum
from functools import cached_property
from typing import Any


class DeviationKind(StrEnum):
    AWAY = "moves-away"
    PASSED = "passed-item"
    OUTSIDE = "left-corridor"
    LATE = "late"
    HOME = "home-moved"


class OnDeviation(StrEnum):
    HOLD = "hold"
    RTL = "rtl"
    REPORT = "report"


@dataclass(frozen=True)
class Deviation:
    """On the way to `item`: `measured` and `allowed` in meters, for LATE in seconds."""

    kind: DeviationKind
    item: int
    time_s: float
    measured: float
    allowed: float
    words: str

    def __str__(self) -> str:
        return f"item {self.item}: {self.words}"

    def as_json(self) -> dict[str, Any]:
        unit = "s" if self.kind is DeviationKind.LATE else "m"
        rounded = {"time_s": round(self.time_s, 2), "found": round(self.measured, 2), "allowed": round(self.allowed, 2)}
        return {"kind": str(self.kind), "item": self.item, **rounded, "unit": unit, "words": str(self)}


@dataclass(frozen=True)
class Sample:
    """Seconds since arming, degrees, altitude AMSL [m], height above home [m], speed [m/s]."""

    time_s: float
    latitude_deg: float
    longitude_deg: float
    altitude: float
    height: float
    speed: float


@dataclass(frozen=True)
class FlightRecord:
    """A flight as it was flown; times since arming.

    Attributes:
        item_reached_s: index into `Mission.items` -> when it was reached, or passed [s]. A final LAND or RTL is done
            when the motors stop.
        total_s: its duration [s].
        path: position samples.
        messages: the vehicle's texts.
        completed: it landed and was disarmed at the end of its mission.
        why_not: the reason for an incomplete flight.
        armed: as last reported.
        in_air: as last reported.
        deviations: from the forecast, also of a completed flight.
        remarks: on the log that it was read from.
        late_items: those done unheard, by the given time.
    """

    item_reached_s: dict[int, float]
    total_s: float
    path: tuple[Sample, ...]
    messages: tuple[str, ...]
    completed: bool
    why_not: str = ""
    armed: bool = False
    in_air: bool = False
    deviations: tuple[Deviation, ...] = ()
    remarks: tuple[str, ...] = ()
    late_items: frozenset[int] = frozenset()

    @cached_property
    def timed_items_s(self) -> dict[int, float]:
        return {index: time_s for index, time_s in self.item_reached_s.items() if index not in self.late_items}

    @cached_property
    def home_altitude(self) -> float:
        """Return home's altitude as set at arming [m AMSL]. PX4 1.17 also changes it in flight."""
        from statistics import median

        until_s = self.path[0].time_s + 2.0  # it is set after arming
        return median(sample.altitude - sample.height for sample in self.path if sample.time_s <= until_s)

    @property
    def heights(self) -> list[float]:
        """Return each sample's height above home as set at arming [m]."""
        return [sample.altitude - self.home_altitude for sample in self.path]

    @property
    def home_drift(self) -> float:
        """Return the greatest change of home's altitude in flight [m]."""
        drifts = (abs(height - sample.height) for height, sample in zip(self.heights, self.path, strict=True))
        return max(drifts, default=0.0)

    @property
    def failure(self) -> str:
        return self.why_not or "; ".join(map(str, self.deviations))
