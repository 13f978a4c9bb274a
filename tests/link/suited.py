"""A mission as it is for whichever vehicle a test has."""

from dataclasses import replace

from ipoa_mission.link.vehicle import Vehicle
from ipoa_mission.mission.items import Mission


def suited(vehicle: Vehicle, mission: Mission) -> Mission:
    """The mission for this vehicle's autopilot."""
    return replace(mission, autopilot=vehicle.autopilot)
