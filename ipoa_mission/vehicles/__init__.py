"""Vehicle plug-ins: a registered `Autopilot` for each firmware and vehicle class."""

from ipoa_mission.vehicles.arducopter.vehicle import ARDUCOPTER
from ipoa_mission.vehicles.autopilot import Autopilot, register
from ipoa_mission.vehicles.px4_multicopter.vehicle import PX4_MULTICOPTER

Autopilot.PX4 = register(PX4_MULTICOPTER)
Autopilot.ARDUPILOT = register(ARDUCOPTER)
