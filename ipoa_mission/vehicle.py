"""What flies: the autopilot family, its parameters by the autopilot's own names and units, how high PX4 returns."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from enum import StrEnum
from types import MappingProxyType
from typing import TypeAlias

Parameters: TypeAlias = Mapping[str, float]
SINGLE_MAX = 3.4e38  # what MAVLink's floats can carry


class Autopilot(StrEnum):
    """The two firmware families that the package speaks, writes and estimates for."""

    PX4 = "px4"
    ARDUPILOT = "ardupilot"


#: ArduCopter 4.7's own defaults for what moves a mission (cm, cm/s, cm/s^2 and centidegrees, as it has them).
ARDUCOPTER_DEFAULTS: Parameters = MappingProxyType(
    {
        "WPNAV_SPEED": 1000.0,
        "WPNAV_SPEED_UP": 250.0,
        "WPNAV_SPEED_DN": 150.0,
        "WPNAV_ACCEL": 250.0,
        "WPNAV_ACCEL_C": 0.0,
        "WPNAV_ACCEL_Z": 100.0,
        "WPNAV_JERK": 1.0,
        "WPNAV_RADIUS": 200.0,
        "WP_YAW_BEHAVIOR": 2.0,
        "PSC_JERK_XY": 5.0,
        "PSC_JERK_Z": 5.0,
        "ANGLE_MAX": 3000.0,
        "LAND_SPEED": 50.0,
        "LAND_SPEED_HIGH": 0.0,
        "LAND_ALT_LOW": 1000.0,
        "RTL_ALT": 1500.0,
        "RTL_SPEED": 0.0,
        "RTL_LOIT_TIME": 5000.0,
        "RTL_ALT_FINAL": 0.0,
        "ATC_ACCEL_P_MAX": 110000.0,
        "ATC_ACCEL_R_MAX": 110000.0,
        "ATC_INPUT_TC": 0.15,
        "MOT_SPOOL_TIME": 0.5,
        "DISARM_DELAY": 10.0,
    }
)

#: ArduCopter's name from 4.7 on: name before, and how many of the old unit make one of the new. The renaming is its own
#: ("Parameter Name Changes", 4.6 to 4.7, and pull requests 31970 and 32147).
RENAMED: Mapping[str, tuple[str, float]] = {
    "WP_SPD": ("WPNAV_SPEED", 100.0),
    "WP_SPD_UP": ("WPNAV_SPEED_UP", 100.0),
    "WP_SPD_DN": ("WPNAV_SPEED_DN", 100.0),
    "WP_ACC": ("WPNAV_ACCEL", 100.0),
    "WP_ACC_CNR": ("WPNAV_ACCEL_C", 100.0),
    "WP_ACC_Z": ("WPNAV_ACCEL_Z", 100.0),
    "WP_JERK": ("WPNAV_JERK", 1.0),
    "WP_RADIUS_M": ("WPNAV_RADIUS", 100.0),
    "PSC_JERK_NE": ("PSC_JERK_XY", 1.0),
    "PSC_JERK_D": ("PSC_JERK_Z", 1.0),
    "ATC_ANGLE_MAX": ("ANGLE_MAX", 100.0),
    "ATC_ACC_R_MAX": ("ATC_ACCEL_R_MAX", 100.0),
    "ATC_ACC_P_MAX": ("ATC_ACCEL_P_MAX", 100.0),
    "LAND_SPD_MS": ("LAND_SPEED", 100.0),
    "LAND_SPD_HIGH_MS": ("LAND_SPEED_HIGH", 100.0),
    "LAND_ALT_LOW_M": ("LAND_ALT_LOW", 100.0),
    "RTL_ALT_M": ("RTL_ALT", 100.0),
    "RTL_SPEED_MS": ("RTL_SPEED", 100.0),
    "RTL_ALT_FINAL_M": ("RTL_ALT_FINAL", 100.0),
    "RTL_CLIMB_MIN_M": ("RTL_CLIMB_MIN", 100.0),
    "CIRCLE_RADIUS_M": ("CIRCLE_RADIUS", 100.0),
}

#: PX4 1.17's own defaults for a multicopter in AUTO.MISSION (SI units and degrees, as it has them).
PX4_DEFAULTS: Parameters = MappingProxyType(
    {
        "MPC_XY_CRUISE": 5.0,
        "MPC_XY_VEL_MAX": 12.0,
        "MPC_XY_TRAJ_P": 0.5,
        "MPC_XY_ERR_MAX": 2.0,
        "MPC_XY_P": 0.95,
        "MPC_ACC_HOR": 3.0,
        "MPC_ACC_HOR_MAX": 5.0,
        "MPC_JERK_AUTO": 4.0,
        "MPC_Z_P": 1.0,
        "MPC_Z_V_AUTO_UP": 3.0,
        "MPC_Z_V_AUTO_DN": 1.5,
        "MPC_ACC_UP_MAX": 4.0,
        "MPC_ACC_DOWN_MAX": 3.0,
        "MPC_TKO_SPEED": 1.5,
        "MPC_TKO_RAMP_T": 3.0,
        "MPC_LAND_SPEED": 0.7,
        "MPC_LAND_ALT1": 10.0,
        "MPC_LAND_ALT2": 5.0,
        "MPC_YAW_MODE": 0.0,
        "MPC_YAWRAUTO_MAX": 60.0,
        "MPC_YAWRAUTO_ACC": 20.0,
        "NAV_ACC_RAD": 2.0,
        "NAV_MC_ALT_RAD": 0.8,
        "COM_SPOOLUP_TIME": 1.0,
        "RTL_RETURN_ALT": 60.0,
        "RTL_DESCEND_ALT": 30.0,
        "RTL_MIN_DIST": 10.0,
        "RTL_CONE_ANG": 45.0,
        "RTL_LAND_DELAY": 0.0,
    }
)

DEFAULT_PARAMETERS: Mapping[Autopilot, Parameters] = MappingProxyType(
    {Autopilot.ARDUPILOT: ARDUCOPTER_DEFAULTS, Autopilot.PX4: PX4_DEFAULTS}
)


def by_old_names(parameters: Parameters) -> dict[str, float]:
    """The same parameters, those of ArduCopter 4.7 by the names and in the units of before."""
    old = {name: value for name, value in parameters.items() if name not in RENAMED}
    return old | {RENAMED[name][0]: value * RENAMED[name][1] for name, value in parameters.items() if name in RENAMED}


def overridden(parameters: Parameters, by: Parameters) -> dict[str, float]:
    """All of these parameters, with the value that `by` gives where it names one, by its name before or after 4.7.

    >>> overridden({"WP_SPD": 8.0, "RTL_ALT": 3000.0}, {"WPNAV_SPEED": 500.0})
    {'RTL_ALT': 3000.0, 'WPNAV_SPEED': 500.0}
    """
    given = by_old_names(dict.fromkeys(by, 0.0))
    return {name: value for name, value in parameters.items() if not by_old_names({name: 0.0}).keys() & given} | dict(
        by
    )


@dataclass(frozen=True)
class Px4Return:
    """How high PX4 returns: RTL_RETURN_ALT, RTL_DESCEND_ALT, RTL_MIN_DIST, NAV_ACC_RAD [m], RTL_CONE_ANG [deg]."""

    altitude: float
    descend_altitude: float
    least_distance: float
    radius: float
    cone_deg: float

    @classmethod
    def of(cls, parameters: Parameters) -> "Px4Return":
        """By these parameters; what is not given has PX4's default."""
        names = ("RTL_RETURN_ALT", "RTL_DESCEND_ALT", "RTL_MIN_DIST", "NAV_ACC_RAD", "RTL_CONE_ANG")
        return cls(*(parameters.get(name, PX4_DEFAULTS[name]) for name in names))

    def height(self, above: float, distance: float) -> float:
        """How high above home PX4 1.17 returns from so high `above` it, `distance` away on the level [m], as recorded.

        No higher than RTL_DESCEND_ALT, or than it is: so did all 21 recorded flights that end in RTL.
        """
        return max(above, min(self.height_by_manual(above, distance), self.descend_altitude))

    def height_by_manual(self, above: float, distance: float) -> float:
        """The same by its manual: RTL_RETURN_ALT at least, near home less.

        Within RTL_MIN_DIST a cone of RTL_CONE_ANG is high enough, though not less than two NAV_ACC_RAD; within
        NAV_ACC_RAD twice the distance.
        """
        if distance <= self.radius:
            return max(above, 2.0 * distance)
        top = self.altitude
        if self.cone_deg > 0.0 and distance <= self.least_distance:
            top = min(top, distance / math.tan(math.radians(min(max(self.cone_deg, 1.0), 89.0))))
        return max(above, top, 2.0 * self.radius)
