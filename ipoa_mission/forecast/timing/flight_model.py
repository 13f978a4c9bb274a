from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar, Protocol

import numpy as np
from numpy.typing import NDArray

from ipoa_mission.autopilot.parameters import Parameters
from ipoa_mission.autopilot.returning import Contingency
from ipoa_mission.errors import NotModeled
from ipoa_mission.forecast.itinerary.itinerary import Itinerary
from ipoa_mission.forecast.timing.bound import Kinematics
from ipoa_mission.forecast.timing.prediction import Prediction
from ipoa_mission.geometry import Points, Vector
from ipoa_mission.mission.items import Mission
from ipoa_mission.wind import CALM, Wind


class SlowedByAir(Protocol):
    def slowing(self, velocity: Points, axes: NDArray[np.float64]) -> Points:
        """Return the deceleration by the air (n, 3) [m/s^2], at velocity (n, 3) [m/s] and axes (n, 3, 3)."""


@dataclass(frozen=True)
class Abort:
    time: float
    contingency: Contingency


class FlightModel(ABC):
    """The interface of an autopilot's flight model."""

    scatter: ClassVar[tuple[float, float, float]]
    """Standard deviations of an item's time about the model's: seconds, share, and seconds of an ending."""
    simulated: ClassVar[Mapping[str, float]]
    """Values of the simulated vehicle that others may change: drag, lag [s], lift_delay, landing_delay [s]."""

    is_always_sure: ClassVar[bool] = False
    """True where `sure` has no effect."""

    @abstractmethod
    def predicted(self, route: Itinerary, mission: Mission, wind: Wind, fast: bool | None, sure: bool) -> Prediction:
        """Predict the flight; `fast` and `sure` as in `Forecast.predicted`.

        Raises:
            BadInput: an item never ends, or a parameter is invalid.
            MissionError: the vehicle makes no progress.
        """

    @abstractmethod
    def kinematics(self, parameters: Parameters, speed: float | None = None) -> Kinematics:
        """Return the limits that parameters set; `speed` is that of DO_CHANGE_SPEED [m/s]."""

    def broken_off(self, route: Itinerary, mission: Mission, wind: Wind, fast: bool | None, order: Abort) -> Prediction:
        """Predict the flight to an abort, and its contingency; the only time is of its end.

        Raises:
            MissionError: as `predicted`; or the model has no such flights.
        """
        raise NotModeled("this model has no aborted flights")

    def airframe(self, altitude: float) -> SlowedByAir:
        """Return the simulated airframe at an altitude [m AMSL]; raise MissionError if drag cannot be learned."""
        raise NotModeled("this flight model has no airframe: drag cannot be learned")

    def usual(self, route: Itinerary, mission: Mission) -> Vector:
        return self.predicted(route, mission, CALM, True, False).done
