from dataclasses import replace
from typing import Any

from ipoa_mission.autopilot.autopilot import Autopilot
from ipoa_mission.geodesy import Geodetic
from ipoa_mission.link.codec import Codec
from ipoa_mission.link.connect import meet
from ipoa_mission.link.connection import Connection
from ipoa_mission.link.vehicle import Vehicle
from ipoa_mission.mission.items import Mission, return_to_launch, takeoff, waypoint
from ipoa_mission.simulator.built_in_autopilot import BuiltInAutopilot as Mock
from ipoa_mission.simulator.station import Loopback, Station


def suited(vehicle: Vehicle, mission: Mission) -> Mission:
    return replace(mission, autopilot=vehicle.autopilot)


HOME = Geodetic(47.4, 8.5, 400.0)
RALLY = (Geodetic(47.4001, 8.5, 25.0),)
MISSION = Mission(HOME, (takeoff(HOME, 10.0), waypoint(Geodetic(47.4002, 8.5), 12.0), return_to_launch()), rally=RALLY)


def met(autopilot: Autopilot, **habits: Any) -> Vehicle:
    """The built-in autopilot at the other end of a loopback."""
    return meet(Connection(Loopback(Station(Mock(autopilot, HOME, **habits))), Codec(245, 190)))
