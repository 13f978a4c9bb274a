"""Estimate a flight's energy by curve, airframe or hover power."""

from dataclasses import replace

from ipoa_mission.autopilot.energy import Battery, Consumption, PowerCurve, TimedPath, by_curve, consumption
from ipoa_mission.autopilot.learned import LearnedVehicle
from ipoa_mission.scenario import Scenario
from ipoa_mission.wind import CALM, Wind


def flight_energy(
    scenario: Scenario | None, path: TimedPath, learned: LearnedVehicle | None = None, wind: Wind = CALM
) -> Consumption | None:
    """Return a flight's energy; None without airframe and hover power."""
    vehicle = None if scenario is None else scenario.vehicle
    learned = learned or (None if vehicle is None else vehicle.learned)
    head_wind = vehicle.battery.head_wind if vehicle is not None and vehicle.battery is not None else 0.0
    curve = curve_of(learned)
    measured = None if learned is None else learned.hover_power
    hover_w = None if measured is None else measured.value

    def consumed(against: float) -> Consumption | None:
        if curve is not None:
            return by_curve(curve, path, wind, against)
        if scenario is None or vehicle is None or vehicle.airframe is None:
            return None if hover_w is None else by_curve(PowerCurve(hover_w), path)
        above_home = replace(path, altitude_amsl=scenario.home.altitude_amsl)
        return consumption(vehicle.airframe.build(), above_home, wind, against, hover_w)

    used = consumed(head_wind)
    if used is None:
        return None
    if wind.spread > 0.0 and (against := consumed(head_wind + wind.spread)) is not None:
        used = replace(used, most_w=against.most_w)
    return used.widened(*_share(learned))


def _share(learned: LearnedVehicle | None) -> tuple[float, float]:
    """Return actual over predicted energy, nine flights in ten (docs/lab/profiles.md)."""
    if learned is None or learned.hover_power is None:
        return 0.75, 1.4
    ratio = learned.energy_ratio
    return (0.85, 1.25) if ratio is None else (ratio.low, ratio.high)


def curve_of(learned: LearnedVehicle | None) -> PowerCurve | None:
    if learned is None or learned.hover_power is None or learned.airspeed is None:
        return None
    terms = ("square", "cube", "climb", "descent")
    square, cube, climb, descent = (learned.value(f"{term}_power", 0.0) for term in terms)
    return PowerCurve(learned.hover_power.value, square, cube, climb, descent, learned.airspeed.value)


def battery_of(scenario: Scenario | None) -> Battery | None:
    section = None if scenario is None else scenario.vehicle.battery
    return None if section is None else section.build()
