from collections.abc import Mapping

#: New name: old name and old units per new unit ("Parameter Name Changes" 4.6 to 4.7, pull requests 31970 and 32147).
RENAMED: Mapping[str, tuple[str, float]] = {
    "WP_SPD": ("WPNAV_SPEED", 100.0),
    "WP_SPD_UP": ("WPNAV_SPEED_UP", 100.0),
    "WP_SPD_DN": ("WPNAV_SPEED_DN", 100.0),
    "WP_ACC": ("WPNAV_ACCEL", 100.0),
    "WP_ACC_CNR": ("WPNAV_ACCEL_C", 100.0),
    "WP_ACC_Z": ("WPNAV_ACCEL_Z", 100.0),
    "WP_JERK": ("WPNAV_JERK", 1.0),
    "WP_RADIUS_M": ("WPNAV_RADIUS", 100.0),
    "WP_TER_MARGIN": ("WPNAV_TER_MARGIN", 1.0),
    "WP_RFND_USE": ("WPNAV_RFND_USE", 1.0),
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
