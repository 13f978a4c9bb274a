from collections.abc import Mapping
from typing import ClassVar

from ipoa_mission.autopilot.parameters import Parameters
from ipoa_mission.forecast.deviation.law import DeviationLaw, Quantiles
from ipoa_mission.forecast.itinerary.itinerary import Itinerary
from ipoa_mission.forecast.timing.bound import Kinematics
from ipoa_mission.forecast.timing.flight_model import Abort, FlightModel, SlowedByAir
from ipoa_mission.forecast.timing.prediction import Prediction
from ipoa_mission.mission.items import Mission
from ipoa_mission.vehicles.arducopter.dynamics.airframe import ARDUPILOT_SIMULATOR, airframe_of
from ipoa_mission.vehicles.arducopter.limits import CopterLimits, copter_limits
from ipoa_mission.vehicles.arducopter.timing import fly_aborted, fly_arducopter
from ipoa_mission.wind import Wind

LAW = DeviationLaw(
    level=Quantiles((-0.1, 0.0, 0.02, 0.04, 0.06, 0.12, 0.28, 0.5), (1.0, 0.5, 0.2, 0.1, 0.05, 0.01, 0.002, 0.0005)),
    down=Quantiles((-0.3, 0.0, 0.02, 0.04, 0.1, 0.25), (1.0, 0.5, 0.2, 0.1, 0.01, 0.002)),
    up=Quantiles((-0.1, 0.09, 0.11, 0.13, 0.17, 0.27, 0.43), (1.0, 0.5, 0.2, 0.1, 0.05, 0.01, 0.002)),
    lowest=Quantiles((0.0, 0.05, 0.13, 0.30), (1.0, 0.2, 0.05, 0.01)),
    highest=Quantiles((0.0, 0.05, 0.2, 0.3, 0.65), (1.0, 0.4, 0.1, 0.05, 0.01)),
    farthest=Quantiles((0.0, 0.06, 0.1, 0.17, 0.25, 0.6), (1.0, 0.5, 0.25, 0.1, 0.05, 0.01)),
    turn=4.0,
    after_way=1.5,
    memory=2.0,
    height_memory=10.0,
    growth=(0.06, 0.03, 0.1),
    source="ArduCopter 4.7.0-dev in its simulator: 42 flights, 17 of them by its true position, and 25 in wind",
    strongest=8.0,
)


class ArduCopterModel(FlightModel):
    """ArduCopter 4.x in SITL."""

    scatter = (0.15, 0.01, 0.6)
    is_always_sure = True
    simulated: ClassVar[Mapping[str, float]] = {
        "drag": 1.0,
        "lag": ARDUPILOT_SIMULATOR.lag,
        "lift_delay": 0.0,
        "landing_delay": 0.0,
    }

    def predicted(self, route: Itinerary, mission: Mission, wind: Wind, fast: bool | None, sure: bool) -> Prediction:
        airframe = airframe_of(mission.vehicle).at_altitude(mission.home.altitude)
        return fly_arducopter(route, _limits(mission), wind, fast, airframe)

    def broken_off(self, route: Itinerary, mission: Mission, wind: Wind, fast: bool | None, order: Abort) -> Prediction:
        airframe = airframe_of(mission.vehicle).at_altitude(mission.home.altitude)
        return fly_aborted(route, _limits(mission), wind, fast, airframe, order)

    def kinematics(self, parameters: Parameters, speed: float | None = None) -> Kinematics:
        limits = copter_limits(parameters)
        speeds = (speed or limits.speed, limits.climb, limits.descent)
        return Kinematics(*speeds, limits.accel, limits.jerk, across=max(limits.accel, limits.corner_accel))

    def airframe(self, altitude: float) -> SlowedByAir:
        return ARDUPILOT_SIMULATOR.at_altitude(altitude)


def _limits(mission: Mission) -> CopterLimits:
    return copter_limits(mission.parameters, mission.firmware_version)


MODEL = ArduCopterModel()
