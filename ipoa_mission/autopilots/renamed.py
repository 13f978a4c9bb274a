"""ArduCopter's parameters by the names of before 4.7 and by those since."""

from collections.abc import Mapping

from ipoa_mission.autopilots.vehicle import Parameters

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
