from collections.abc import Mapping
from typing import ClassVar

import numpy as np

from ipoa_mission.autopilot.parameters import Parameters
from ipoa_mission.forecast.deviation.law import DeviationLaw, Quantiles
from ipoa_mission.forecast.itinerary.itinerary import Itinerary
from ipoa_mission.forecast.timing.bound import Kinematics
from ipoa_mission.forecast.timing.flight_model import Abort, FlightModel, SlowedByAir
from ipoa_mission.forecast.timing.prediction import Prediction
from ipoa_mission.geometry import Vector
from ipoa_mission.mission.items import Mission
from ipoa_mission.vehicles.px4_multicopter.dynamics.airframe import KNOWS, SIH, SIH_SENSES, airframe_of
from ipoa_mission.vehicles.px4_multicopter.limits import px4_limits
from ipoa_mission.vehicles.px4_multicopter.timing import STEP, Flights, fly_aborted, fly_px4
from ipoa_mission.wind import Wind

LAW = DeviationLaw(
    level=Quantiles(
        (-1.5, 0.0, 0.12, 0.22, 0.42, 0.62, 1.07, 1.42, 1.72), (1.0, 0.5, 0.3, 0.2, 0.1, 0.05, 0.01, 0.002, 0.0005)
    ),
    down=Quantiles((-2.5, 0.0, 0.75, 1.1, 1.35, 1.75, 2.1), (1.0, 0.5, 0.2, 0.1, 0.05, 0.01, 0.002)),
    up=Quantiles((-2.0, 0.0, 0.55, 1.0, 1.45, 2.1, 2.7), (1.0, 0.5, 0.2, 0.1, 0.05, 0.01, 0.002)),
    lowest=Quantiles((0.0, 0.9, 1.75, 2.0, 2.4), (1.0, 0.5, 0.1, 0.05, 0.01)),
    highest=Quantiles((0.0, 1.0, 2.4, 2.85, 3.2), (1.0, 0.5, 0.1, 0.05, 0.01)),
    farthest=None,
    turn=8.0,
    after_way=1.5,
    memory=4.0,
    height_memory=10.0,
    growth=(0.1, 0.03, 0.1),
    source="PX4 1.17 in its simulator (SIH): 92 flights of 21 missions, 1.5 to 18 m/s, and 22 in wind, by true place",
    strongest=6.0,
)


MEDIAN_RUNS = 8  # with noise; always the same seeds


class Px4Model(FlightModel):
    """PX4 in SIH; flown with noise unless `sure`."""

    scatter = (0.7, 0.02, 2.0)
    simulated: ClassVar[Mapping[str, float]] = {"drag": 1.0, "lag": SIH.lag, "lift_delay": 0.0, "landing_delay": 0.0}

    def predicted(self, route: Itinerary, mission: Mission, wind: Wind, fast: bool | None, sure: bool) -> Prediction:
        senses = KNOWS if sure else SIH_SENSES
        return fly_px4(
            route, mission.parameters, wind, fast, airframe_of(mission.vehicle), senses, mission.firmware_version
        )

    def broken_off(self, route: Itinerary, mission: Mission, wind: Wind, fast: bool | None, order: Abort) -> Prediction:
        return fly_aborted(
            route, mission.parameters, wind, fast, airframe_of(mission.vehicle), order, mission.firmware_version
        )

    def kinematics(self, parameters: Parameters, speed: float | None = None) -> Kinematics:
        limits = px4_limits(parameters)
        level = min(speed or limits.cruise, limits.most_speed)
        return Kinematics(level, limits.climb, limits.descent, limits.accel, limits.jerk)

    def airframe(self, altitude: float) -> SlowedByAir:
        return SIH

    def usual(self, route: Itinerary, mission: Mission) -> Vector:
        flights = Flights(
            route, mission.parameters, airframe=airframe_of(mission.vehicle), version=mission.firmware_version
        )
        steps = MEDIAN_RUNS * sum(order.patience for order in flights.plan.orders) / STEP
        once = flights.prepared(True, True, steps)
        return np.asarray(np.median([once(seed)[0] for seed in range(1, MEDIAN_RUNS + 1)], axis=0))


MODEL = Px4Model()
