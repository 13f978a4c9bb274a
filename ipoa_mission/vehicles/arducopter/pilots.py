"""Who makes its stand-in's pilots."""

import random

from ipoa_mission.simulator.conditions import Vehicle
from ipoa_mission.simulator.flight import Pilot, Pilots
from ipoa_mission.simulator.situation import Situation
from ipoa_mission.vehicles.arducopter.pilot import ArduPilotPilot
from ipoa_mission.vehicles.parameters import Parameters


class _Pilots(Pilots):
    def pilot(self, body: Vehicle, now: Situation, parameters: Parameters, chance: random.Random) -> Pilot:
        return ArduPilotPilot(body, now, parameters, chance)


PILOTS = _Pilots()
