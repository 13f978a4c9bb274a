"""Waypoints as `plan` writes them for PX4 1.18: with a hold and a radius. ArduCopter holds for whole seconds."""

from functools import partial

from ipoa_mission.autopilot.autopilot import Autopilot
from ipoa_mission.autopilot.version import Version
from ipoa_mission.mission.items import waypoint as plain

waypoint = partial(plain, hold_s=0.1, radius=2.0)

#: It needs no holds; recorded links are of it.
PX4_117 = {Autopilot.PX4: Version(1, 17)}
