from dataclasses import replace

from ipoa_mission.link.vehicle import Vehicle
from ipoa_mission.mission.items import Mission


def suited(vehicle: Vehicle, mission: Mission) -> Mission:
    return replace(mission, autopilot=vehicle.autopilot)
