"""The tubes of ArduCopter and PX4 as they were measured; docs/safety.md has the flights.

Speed drives neither: a PX4 at 1.5 m/s lies as far beside its path as one at 9 m/s, because what moves it is what it
believes of its own position.
"""

from types import MappingProxyType

from ipoa_mission.autopilots.firmware import FIRMWARE
from ipoa_mission.autopilots.vehicle import Autopilot
from ipoa_mission.tube.law import Law
from ipoa_mission.tube.spread import Spread

NOT_VALID = (
    "stronger winds than these, other airframes and parameters than the simulators', what satellites are wrong by"
)
#: The strongest wind, gusts and all, in which flights kept to the tube [m/s]. PX4's simulated vehicle, of which drag
#: leaves 9.8 m/s, hardly gets on against more.
STRONGEST = MappingProxyType({Autopilot.ARDUPILOT: 8.0, Autopilot.PX4: 6.0})

ARDUCOPTER = Law(
    level=Spread((-0.1, 0.0, 0.02, 0.04, 0.06, 0.12, 0.28, 0.5), (1.0, 0.5, 0.2, 0.1, 0.05, 0.01, 0.002, 0.0005)),
    down=Spread((-0.3, 0.0, 0.02, 0.04, 0.1, 0.25), (1.0, 0.5, 0.2, 0.1, 0.01, 0.002)),
    up=Spread((-0.1, 0.09, 0.11, 0.13, 0.17, 0.27, 0.43), (1.0, 0.5, 0.2, 0.1, 0.05, 0.01, 0.002)),
    lowest=Spread((0.0, 0.05, 0.13, 0.30), (1.0, 0.2, 0.05, 0.01)),
    highest=Spread((0.0, 0.05, 0.2, 0.3, 0.65), (1.0, 0.4, 0.1, 0.05, 0.01)),
    farthest=Spread((0.0, 0.06, 0.1, 0.17, 0.25, 0.6), (1.0, 0.5, 0.25, 0.1, 0.05, 0.01)),
    turn=4.0,
    ending=1.5,
    memory=2.0,
    height_memory=10.0,
    growth=(0.06, 0.03, 0.1),
    source="ArduCopter 4.7.0-dev in its simulator: 42 flights, 17 of them by its true position, and 25 in wind",
    not_valid=NOT_VALID,
)
PX4 = Law(
    level=Spread(
        (-1.5, 0.0, 0.12, 0.22, 0.42, 0.62, 1.07, 1.42, 1.72), (1.0, 0.5, 0.3, 0.2, 0.1, 0.05, 0.01, 0.002, 0.0005)
    ),
    down=Spread((-2.5, 0.0, 0.75, 1.1, 1.35, 1.75, 2.1), (1.0, 0.5, 0.2, 0.1, 0.05, 0.01, 0.002)),
    up=Spread((-2.0, 0.0, 0.55, 1.0, 1.45, 2.1, 2.7), (1.0, 0.5, 0.2, 0.1, 0.05, 0.01, 0.002)),
    lowest=Spread((0.0, 0.9, 1.75, 2.0, 2.4), (1.0, 0.5, 0.1, 0.05, 0.01)),
    highest=Spread((0.0, 1.0, 2.4, 2.85, 3.2), (1.0, 0.5, 0.1, 0.05, 0.01)),
    farthest=None,
    turn=8.0,
    ending=1.5,
    memory=4.0,
    height_memory=10.0,
    growth=(0.1, 0.03, 0.1),
    source="PX4 1.17 in its simulator (SIH): 92 flights of 21 missions, 1.5 to 18 m/s, and 22 in wind, by true place",
    not_valid=NOT_VALID,
)
_LAWS = MappingProxyType({Autopilot.ARDUPILOT: ARDUCOPTER, Autopilot.PX4: PX4})


def not_measured(autopilot: Autopilot, wind: float) -> str | None:
    """Why nothing measured stands behind the tube in this wind [m/s], in words; None where something does."""
    strongest = STRONGEST[autopilot]
    if wind <= strongest:
        return None
    flown = f"{FIRMWARE[autopilot].name}'s tube was measured in wind up to {strongest:g} m/s"
    return f"{flown}: what its flights keep in {wind:g} m/s is extrapolated"


def law_of(autopilot: Autopilot, wind: float = 0.0) -> Law:
    """The tube of an autopilot in a wind of this speed [m/s]."""
    return _LAWS[autopilot].in_wind(wind)
