"""The tubes of ArduCopter and PX4 as they were measured; docs/safety.md has the flights, `tools/measure_tube.py` counts.

A quantile is the greatest of the measured ones and an exponential tail, so that it is never below what was flown.
"""

from types import MappingProxyType

from ipoa_mission.autopilots.vehicle import Autopilot
from ipoa_mission.tube.law import Law
from ipoa_mission.tube.spread import Spread

ARDUCOPTER = Law(
    level=Spread((0.0, 0.02, 0.05, 0.09, 0.24, 0.48, 0.82), (1.0, 0.5, 0.1, 0.05, 0.01, 0.002, 0.0005)),
    down=Spread((0.0, 0.05, 0.13, 0.30), (1.0, 0.2, 0.05, 0.01)),
    up=Spread((0.0, 0.05, 0.2, 0.3, 0.65), (1.0, 0.4, 0.1, 0.05, 0.01)),
    turn=4.0,
    ending=1.5,
    source="ArduCopter 4.7.0-dev in its simulator, 37 flights",
    not_valid="wind, other airframes than the simulator's, an error of the satellite position",
)
PX4 = Law(
    level=Spread((0.0, 0.13, 0.57, 0.75, 1.15, 1.55, 1.95), (1.0, 0.5, 0.1, 0.05, 0.01, 0.002, 0.0005)),
    down=Spread((0.0, 1.0, 1.65, 1.95, 2.4), (1.0, 0.5, 0.1, 0.05, 0.01)),
    up=Spread((0.0, 1.0, 2.1, 2.7, 3.2), (1.0, 0.5, 0.1, 0.05, 0.01)),
    turn=8.0,
    ending=1.5,
    source="PX4 1.17.0 in its simulator (SIH), 49 flights",
    not_valid="wind, other airframes than the simulator's, an error of the satellite position",
)
LAWS = MappingProxyType({Autopilot.ARDUPILOT: ARDUCOPTER, Autopilot.PX4: PX4})
