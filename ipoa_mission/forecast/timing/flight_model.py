import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Hashable, Sequence
from dataclasses import dataclass
from itertools import count
from typing import ClassVar, Generic, NamedTuple, Protocol, TypeVar

import numpy as np
from numpy.typing import NDArray

from ipoa_mission.autopilot.failsafe import Contingency
from ipoa_mission.autopilot.parameters import Parameters
from ipoa_mission.errors import NotModeled
from ipoa_mission.forecast.itinerary.itinerary import Itinerary, turn_deg
from ipoa_mission.forecast.timing.track import Track
from ipoa_mission.geometry import Place, Points, Vector
from ipoa_mission.wind import CALM, Wind


class Missed(NamedTuple):
    """A waypoint that PX4 misses by height in this `share` of flights; turning back takes `cost_s`."""

    share: float
    cost_s: float


NEVER_MISSED = Missed(0.0, 0.0)
Z_90 = 1.645  # half of the interval of 90 %, in standard deviations


@dataclass(frozen=True, eq=False)
class Prediction:
    """Time of each visit (n,) [s], reason of its slowness (perhaps none without noise), path, and remarks.

    Nine flights in ten are from `low` to `high` (n,) [s]. `missed`: by visit. `touched`: touchdown of a contingency,
    at the earliest, in the mean and at the latest [s].
    """

    done: Vector
    low: Vector
    high: Vector
    reasons: tuple[str, ...]
    track: Track
    remarks: tuple[str, ...] = ()
    missed: tuple[Missed, ...] = ()
    touched: tuple[float, float, float] | None = None


def corner_deg(before: Place, at: Place, after: Place) -> float:
    """Return the turn at a place, 0 to 180; 0 at a vertical side."""
    if math.dist(before[:2], at[:2]) < 0.1 or math.dist(at[:2], after[:2]) < 0.1:
        return 0.0
    return turn_deg(before, at, after)


class LegSpeeds(NamedTuple):
    """Speeds of a leg [m/s], which say why it is slow."""

    planned: float | None  # peak; None where `curved`
    allowed: float  # the requested one as limited by its slope
    asked: float  # the requested one
    top: float  # as limited by drag and wind
    flown: float  # the greatest horizontal one
    corner: float  # [deg]
    stops: bool
    curved: bool = False

    def why_slow(self) -> str:
        reasons = list[str]()
        planned = self.planned
        least = 0.95  # of a speed, to count as reached
        wanted = min(self.asked if planned is None else planned, self.allowed, self.asked)
        if planned is not None and planned < least * min(self.allowed, self.asked):
            reasons.append("leg shorter than its braking distance")
        elif self.allowed < least * self.asked:
            reasons.append("climb or descent rate")
        if self.curved and self.flown < least * min(self.top, wanted):
            reasons.append("acceleration on the curve")
        elif self.top < least * wanted:
            reasons.append("drag at the greatest tilt")
        elif planned is not None and not reasons and self.flown < least * wanted:
            reasons.append("lag behind the path")
        if self.corner >= 10.0:
            reasons.append(f"corner {self.corner:.0f} deg")
        return ", ".join([*reasons, "stop"] if self.stops else reasons)


End = TypeVar("End")


class SharedStretches(Generic[End]):
    """Ends of stretches, shared by flights that begin alike."""

    def __init__(self, most: int) -> None:
        self._most = most
        self._numbers = count()
        self._ends: dict[tuple[Hashable, Hashable], tuple[int, End]] = {}

    def fly(
        self, conditions: Hashable, start: End, stretches: Sequence[Hashable], fly_on: Callable[[End, int], End]
    ) -> list[End]:
        """Return the end of each stretch. It depends on the conditions and the `stretches` so far."""
        before = conditions
        end = start
        ends = list[End]()
        for n, stretch in enumerate(stretches):
            if (before, stretch) not in self._ends:
                self._ends[before, stretch] = next(self._numbers), fly_on(end, n)
            before, end = self._ends[before, stretch]
            ends.append(end)
        while len(self._ends) > self._most:
            del self._ends[next(iter(self._ends))]  # the oldest
        return ends


class Kinematics(NamedTuple):
    """Speeds horizontal, up and down [m/s], horizontal acceleration and jerk."""

    speed: float
    climb: float
    descent: float
    accel: float
    jerk: float = math.inf


class SlowedByAir(Protocol):
    def slowing(self, velocity: Points, axes: NDArray[np.float64]) -> Points:
        """Return the deceleration by the air (n, 3) [m/s^2], at velocity (n, 3) [m/s] and axes (n, 3, 3)."""


class FlightModel(ABC):
    scatter: ClassVar[tuple[float, float, float]]
    """Standard deviations of an item's time about the model's: seconds, share, and seconds of a landing."""
    takeoff_scatter_s: ClassVar[float]
    """Greatest error of the take-off's time [s]."""
    simulated_lag: ClassVar[float]
    """Lag of the simulated vehicle's rotors and rate loop [s]."""

    is_always_noise_free: ClassVar[bool] = False
    """True where `noise_free` has no effect."""

    @abstractmethod
    def predicted(self, itinerary: Itinerary, wind: Wind, noise_free: bool) -> Prediction:
        """Predict the flight, `noise_free` or with the mean of sensor noise; raises as `Forecast.predicted`."""

    def excess_deviation(self, itinerary: Itinerary, wind: Wind, predicted: Prediction) -> Points | None:
        """Return the deviation due to this route, beyond the deviation law, (n, 3) as in `Pieces`; None: nowhere."""
        return None

    @abstractmethod
    def kinematics(self, parameters: Parameters, speed: float | None = None) -> Kinematics:
        """Return the limits that parameters set; `speed` is that of DO_CHANGE_SPEED [m/s]."""

    def predict_contingency(
        self, itinerary: Itinerary, wind: Wind, contingency: Contingency, time: float
    ) -> Prediction:
        """As `Forecast.predicted_with`; `done` has only the end."""
        raise NotModeled(f"{itinerary.mission.autopilot.model} has no model of returns: their duration is unknown")

    def airframe(self, altitude: float) -> SlowedByAir:
        """Return the simulated airframe at an altitude [m AMSL]; raise MissionError if drag cannot be learned."""
        raise NotModeled("this flight model has no airframe: drag cannot be learned")

    def median_times(self, itinerary: Itinerary) -> Vector:
        return self.predicted(itinerary, CALM, noise_free=False).done
