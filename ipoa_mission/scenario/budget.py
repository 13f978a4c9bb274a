"""The energy of a flight, by the scenario's airframe and what was learned of the vehicle, against its battery."""

from ipoa_mission.geometry import Points, Vector
from ipoa_mission.scenario.model import Scenario
from ipoa_mission.vehicles.energy.flight import Consumption, consumption, expect_reserve, hovering
from ipoa_mission.vehicles.learned import LearnedVehicle


def flight_energy(
    scenario: Scenario | None, times: Vector, points: Points, speeds: Vector, learned: LearnedVehicle | None = None
) -> Consumption | None:
    """What flying a track takes, given as for `consumption`; None where neither airframe nor hover power is known.

    The track is the whole flight, take-off, way home and landing included, as an estimate predicts it. `learned` goes
    before what the scenario knows of the vehicle.
    """
    vehicle = None if scenario is None else scenario.vehicle
    learned = learned or (None if vehicle is None else vehicle.learned)
    hover_w = None if learned is None or learned.hover_power is None else learned.hover_power.value
    if scenario is None or vehicle is None or vehicle.airframe is None:
        return None if hover_w is None else hovering(hover_w, times, points, speeds)
    wind = vehicle.battery.head_wind if vehicle.battery is not None else 0.0
    airframe, altitude = vehicle.airframe.build(), scenario.home.altitude_amsl
    return consumption(airframe, times, points, speeds, altitude, wind, hover_w)


def expect_to_come_home(scenario: Scenario, used: Consumption | None) -> None:
    """Refuse a flight that leaves less than the reserve in the scenario's battery, if it has one.

    Raises:
        NotEnoughBattery: saying what the flight needs and what is left.
    """
    if used is not None and scenario.vehicle.battery is not None:
        expect_reserve(used, scenario.vehicle.battery.build())
