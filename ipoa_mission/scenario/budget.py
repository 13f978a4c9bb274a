"""The energy of a planned flight, by the scenario's airframe, against its battery."""

from ipoa_mission.energy.flight import Consumption, consumption, expect_reserve
from ipoa_mission.geometry import Points, Vector
from ipoa_mission.scenario.model import Scenario


def flight_energy(scenario: Scenario, times: Vector, points: Points, speeds: Vector) -> Consumption | None:
    """What flying a track takes, given as for `consumption`; None if the scenario has no airframe.

    The track is the whole flight, take-off, way home and landing included, as an estimate predicts it.
    """
    airframe, battery = scenario.vehicle.airframe, scenario.vehicle.battery
    if airframe is None:
        return None
    wind = battery.head_wind if battery is not None else 0.0
    return consumption(airframe.build(), times, points, speeds, scenario.home.altitude_amsl, wind)


def expect_to_come_home(scenario: Scenario, used: Consumption | None) -> None:
    """Refuse a flight that leaves less than the reserve in the scenario's battery, if it has one.

    Raises:
        NotEnoughBattery: saying what the flight needs and what is left.
    """
    if used is not None and scenario.vehicle.battery is not None:
        expect_reserve(used, scenario.vehicle.battery.build())
