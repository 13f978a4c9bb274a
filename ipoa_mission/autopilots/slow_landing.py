"""How fast each autopilot touches down where no range finder sees the ground: LAND slows down by the height over home.

ArduCopter asks a range finder, then (4.7, LAND in AUTO) the altitude of the LAND item, then terrain data that a ground
station gave it, then the height above home; PX4 the distance to the ground where a sensor gives it, else the height
above home. The last is what counts here: it is what every vehicle has.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass

from ipoa_mission.autopilots.parameters import DEFAULT_PARAMETERS
from ipoa_mission.autopilots.renamed import by_old_names
from ipoa_mission.autopilots.vehicle import Autopilot, Parameters

FASTER = 0.05  # a touchdown faster than the landing speed by less than this is none [m/s]
SLOWEST = 0.05  # [m/s]
SURE = 2.0  # heights and maps of the ground are off by so much: a slow stretch is no shorter [m]
ROUNDING = 0.05  # parameters are raised by whole metres; a ground that is higher by so little needs no more [m]


@dataclass(frozen=True)
class SlowedBy:
    """The parameters by which LAND slows down, the unit of each [m], the most that its firmware documents [m]."""

    names: tuple[str, ...]
    unit: float
    most: float


SLOWED_BY: Mapping[Autopilot, SlowedBy] = {
    Autopilot.ARDUPILOT: SlowedBy(("LAND_ALT_LOW",), 0.01, 100.0),
    Autopilot.PX4: SlowedBy(("MPC_LAND_ALT1", "MPC_LAND_ALT2"), 1.0, 122.0),
}
#: All that decides how fast it touches down, by the older of their names.
DECIDED_BY: Mapping[Autopilot, tuple[str, ...]] = {
    Autopilot.ARDUPILOT: ("LAND_ALT_LOW", "LAND_SPEED", "LAND_SPEED_HIGH", "WPNAV_SPEED_DN", "RNGFND1_TYPE"),
    Autopilot.PX4: ("MPC_LAND_ALT1", "MPC_LAND_ALT2", "MPC_LAND_SPEED", "MPC_Z_V_AUTO_DN", "MPC_Z_VEL_MAX_DN"),
}


@dataclass(frozen=True)
class SlowStretch:
    """LAND's speeds [m/s], and the heights over home where it begins to be slower and is as slow as it gets [m]."""

    landing: float
    descent: float
    begins: float
    ends: float

    def touchdown(self, ground: float) -> float:
        """At how many m/s it touches down on ground so high above home [m]."""
        share = (ground - self.ends) / max(self.begins - self.ends, 1e-6)
        return self.landing + min(max(share, 0.0), 1.0) * max(self.descent - self.landing, 0.0)

    def is_fast(self, ground: float) -> bool:
        """Whether it touches down there faster than it lands."""
        return self.touchdown(ground) > self.landing + FASTER


def slow_stretch(autopilot: Autopilot, parameters: Parameters) -> SlowStretch | None:
    """By these parameters; None where ArduCopter has a range finder. What is not given has the autopilot's default.

    >>> slow_stretch(Autopilot.ARDUPILOT, {}).touchdown(12.0)
    1.5
    """
    p = {**DEFAULT_PARAMETERS[autopilot], **by_old_names(parameters)}
    if autopilot is Autopilot.PX4:
        descent = min(p["MPC_Z_V_AUTO_DN"], p["MPC_Z_VEL_MAX_DN"])
        low = p["MPC_LAND_ALT2"]
        return SlowStretch(max(p["MPC_LAND_SPEED"], SLOWEST), descent, max(p["MPC_LAND_ALT1"], low), low)
    if p["RNGFND1_TYPE"] > 0:
        return None
    low = max(p["LAND_ALT_LOW"] / 100, 1.0)
    fast = (p["LAND_SPEED_HIGH"] or p["WPNAV_SPEED_DN"]) / 100
    return SlowStretch(max(p["LAND_SPEED"] / 100, SLOWEST), fast, low, low)


def raised(autopilot: Autopilot, parameters: Parameters, ground: float) -> Parameters:
    """What lets it slow down as high above ground so high above home [m] as these parameters do above home.

    No parameter goes beyond what its firmware documents.

    >>> raised(Autopilot.PX4, {}, 12.0)
    {'MPC_LAND_ALT1': 22.0, 'MPC_LAND_ALT2': 17.0}
    """
    by, p = SLOWED_BY[autopilot], {**DEFAULT_PARAMETERS[autopilot], **by_old_names(parameters)}
    higher = math.ceil(ground - ROUNDING)
    return {name: round(min(p[name] * by.unit + higher, by.most) / by.unit, 6) for name in by.names}
