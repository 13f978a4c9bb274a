"""What every model of a flight answers: how a mission is flown, how long that takes, what may be learned of it."""

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar, Protocol

import numpy as np
from numpy.typing import NDArray

from ipoa_mission.errors import NotModeled
from ipoa_mission.forecast.itinerary.itinerary import Itinerary
from ipoa_mission.forecast.timing.bound import Kinematics
from ipoa_mission.forecast.timing.prediction import Prediction
from ipoa_mission.geometry import Points, Vector
from ipoa_mission.mission.items import Mission
from ipoa_mission.vehicles.contingency import Contingency
from ipoa_mission.vehicles.parameters import Parameters
from ipoa_mission.wind import CALM, Wind


class SlowedByAir(Protocol):
    """An airframe in moving air."""

    def slowing(self, velocity: Points, axes: NDArray[np.float64]) -> Points:
        """What the air takes of its speed (n, 3) [m/s^2], by velocity (n, 3) [m/s] and axes (n, 3, 3)."""


@dataclass(frozen=True)
class Abort:
    """A flight is ended otherwise than its mission says, from a `time` on [s after arming]: by an RTL or a LAND."""

    time: float
    contingency: Contingency


class FlightModel(ABC):
    """How one autopilot flies a mission in its simulator, and by how much recorded flights lie about that."""

    scatter: ClassVar[tuple[float, float, float]]
    """Standard deviations of an item's time about the model's: seconds, share, and seconds of an ending."""
    simulated: ClassVar[Mapping[str, float]]
    """The numbers of the simulated vehicle by which others differ: drag, lag [s], lift_delay, landing_delay [s]."""

    is_always_sure: ClassVar[bool] = False
    """Whether it flies the same, `sure` of where it is or not."""

    @abstractmethod
    def predicted(self, route: Itinerary, mission: Mission, wind: Wind, fast: bool | None, sure: bool) -> Prediction:
        """The flight of the mission's itinerary; `fast` and `sure` are as in `Forecast.flown`.

        Raises:
            BadInput: an item never ends, or a parameter has no sense.
            MissionError: the vehicle does not get on.
        """

    @abstractmethod
    def kinematics(self, parameters: Parameters, speed: float | None = None) -> Kinematics:
        """The limits that parameters set; `speed` is what DO_CHANGE_SPEED asks for [m/s]."""

    def broken_off(self, route: Itinerary, mission: Mission, wind: Wind, fast: bool | None, order: Abort) -> Prediction:
        """The flight with another end, which is its only item.

        Raises:
            MissionError: as `predicted` does; or the model knows no such flights.
        """
        raise NotModeled("this model knows no flights that are broken off")

    def airframe(self, altitude: float) -> SlowedByAir:
        """The simulated vehicle's, so high above the sea [m].

        Raises:
            MissionError: the model has none, and nothing of drag can be learned.
        """
        raise NotModeled("this model of a flight has no airframe whose drag could be learned")

    def usual(self, route: Itinerary, mission: Mission) -> Vector:
        """When each visit is done in most flights (n,) [s]."""
        return self.predicted(route, mission, CALM, True, False).done
