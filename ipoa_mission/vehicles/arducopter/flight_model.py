from collections.abc import Mapping
from typing import ClassVar

from ipoa_mission.autopilot.parameters import Parameters
from ipoa_mission.forecast.itinerary.itinerary import Itinerary
from ipoa_mission.forecast.timing.bound import Kinematics
from ipoa_mission.forecast.timing.flight_model import Abort, FlightModel, SlowedByAir
from ipoa_mission.forecast.timing.prediction import Prediction
from ipoa_mission.mission.items import Mission
from ipoa_mission.vehicles.arducopter.dynamics.airframe import ARDUPILOT_SIMULATOR, airframe_of
from ipoa_mission.vehicles.arducopter.limits import CopterLimits, copter_limits
from ipoa_mission.vehicles.arducopter.timing import fly_aborted, fly_arducopter
from ipoa_mission.wind import Wind


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
