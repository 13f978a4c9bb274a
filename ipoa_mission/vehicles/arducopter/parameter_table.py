"""ArduCopter's parameters: defaults (sensors, radio, modes, battery, failsafes as in SITL) and types."""

from collections.abc import Mapping

from ipoa_mission.autopilot.parameters import (
    INT8,
    INT16,
    INT32,
    REAL32,
    Declared,
    Parameters,
    ParameterTable,
    Quantity,
    declared,
)

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


#: ArduCopter 4.7's (cm, cm/s, cm/s^2 and centidegrees).
DEFAULTS: Parameters = {
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
    "PSC_POSXY_P": 1.0,
    "PSC_VELXY_P": 2.0,
    "PSC_VELXY_I": 1.0,
    "PSC_VELXY_D": 0.25,
    "PSC_VELXY_FLTE": 5.0,
    "PSC_POSZ_P": 1.0,
    "ATC_SLEW_YAW": 6000.0,
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
    "RTL_CLIMB_MIN": 0.0,
    "RTL_CONE_SLOPE": 3.0,
    "RALLY_LIMIT_KM": 0.3,
    "RALLY_INCL_HOME": 1.0,
    "CIRCLE_RADIUS": 1000.0,
    "CIRCLE_RATE": 20.0,
    "ATC_RATE_R_MAX": 0.0,
    "ATC_RATE_P_MAX": 0.0,
    "PSC_ANGLE_MAX": 0.0,
    "RNGFND1_TYPE": 0.0,
    "PLDP_SPEED_DN": 0.0,
}


_STICKS = ("ROLL", "PITCH", "THROTTLE", "YAW")
_DEAD_ZONES = (20.0, 20.0, 30.0, 20.0, 0.0, 0.0, 0.0, 0.0)


def _channel(number: int, dead_zone: float) -> dict[str, Declared]:
    values = {"MIN": 1000.0, "TRIM": 1500.0, "MAX": 2000.0, "DZ": dead_zone}
    told = {f"RC{number}_{name}": (value, INT16) for name, value in values.items()}
    return {**told, f"RC{number}_REVERSED": (0.0, INT8)}


SET_UP: Mapping[str, Declared] = {
    **{f"RCMAP_{stick}": (float(channel), INT8) for channel, stick in enumerate(_STICKS, start=1)},
    **{name: it for n, zone in enumerate(_DEAD_ZONES, start=1) for name, it in _channel(n, zone).items()},
    **{f"FLTMODE{n}": (mode, INT8) for n, mode in enumerate((7.0, 9.0, 6.0, 3.0, 5.0, 0.0), start=1)},
    "FLTMODE_CH": (5.0, INT8),
    "FRAME_TYPE": (0.0, INT8),
    "COMPASS_DEV_ID": (97539.0, INT32),
    "COMPASS_DEV_ID2": (131874.0, INT32),
    "COMPASS_DEV_ID3": (263178.0, INT32),
    "BATT_MONITOR": (4.0, INT8),
    "BATT_CAPACITY": (3300.0, INT32),
    "BATT_ARM_VOLT": (0.0, REAL32),
    "BATT_LOW_VOLT": (10.5, REAL32),
    "BATT_LOW_MAH": (0.0, REAL32),
    "BATT_FS_LOW_ACT": (0.0, INT8),
    "BATT_FS_CRT_ACT": (0.0, INT8),
    "FS_THR_ENABLE": (1.0, INT8),
    "FS_THR_VALUE": (975.0, INT16),
    "FS_GCS_ENABLE": (0.0, INT8),
}

STATION_PARAMETERS = {
    "MAV_SYSID": 1.0,
    "FRAME_CLASS": 1.0,
    "ARMING_CHECK": 1.0,
    "AUTO_OPTIONS": 0.0,
    "GUID_OPTIONS": 0.0,
    "MIS_OPTIONS": 0.0,
    "MIS_RESTART": 0.0,
    "LOG_DISARMED": 0.0,
    "FENCE_ENABLE": 0.0,
    "FENCE_TYPE": 7.0,
    "FENCE_ACTION": 1.0,
    "FENCE_OPTIONS": 0.0,
    "FENCE_MARGIN": 2.0,
    "FENCE_RADIUS": 300.0,
    "FENCE_ALT_MAX": 100.0,
    "FENCE_ALT_MIN": -10.0,
    "RTL_ALT_TYPE": 0.0,
}

TYPES = declared(
    {
        INT8: "WP_YAW_BEHAVIOR DISARM_DELAY FRAME_CLASS FENCE_ENABLE FENCE_ACTION FENCE_TYPE RTL_ALT_TYPE MIS_RESTART "
        "LOG_DISARMED TERRAIN_ENABLE RNGFND1_TYPE",
        INT16: "ANGLE_MAX LAND_SPEED LAND_SPEED_HIGH LAND_ALT_LOW RTL_SPEED RTL_ALT_FINAL RTL_CLIMB_MIN MAV_SYSID "
        "FENCE_OPTIONS MIS_OPTIONS",
        INT32: "RTL_ALT RTL_LOIT_TIME AUTO_OPTIONS GUID_OPTIONS ARMING_CHECK",
    }
)

MEANINGS = {
    "cruise speed": "WPNAV_SPEED",
    "climb speed": "WPNAV_SPEED_UP",
    "descent speed": "WPNAV_SPEED_DN",
    "acceleration": "WPNAV_ACCEL",
    "vertical acceleration": "WPNAV_ACCEL_Z",
    "jerk": "WPNAV_JERK",
    "acceptance radius": "WPNAV_RADIUS",
    "heading": "WP_YAW_BEHAVIOR",
    "yaw rate": "ATC_SLEW_YAW",
    "lean": "ANGLE_MAX",
    "landing speed": "LAND_SPEED",
    "height of slow landing": "LAND_ALT_LOW",
    "return height": "RTL_ALT",
    "height at the end of a return": "RTL_ALT_FINAL",
    "wait before landing": "RTL_LOIT_TIME",
    "return cone": "RTL_CONE_SLOPE",
    "spool-up": "MOT_SPOOL_TIME",
    "disarming": "DISARM_DELAY",
    "position P": "PSC_POSXY_P",
    "velocity P": "PSC_VELXY_P",
    "velocity I": "PSC_VELXY_I",
    "velocity D": "PSC_VELXY_D",
    "height P": "PSC_POSZ_P",
    "fence switch": "FENCE_ENABLE",
    "system id": "MAV_SYSID",
}

UNITS = {
    **dict.fromkeys(("WPNAV_SPEED", "WPNAV_SPEED_UP", "WPNAV_SPEED_DN", "WPNAV_ACCEL", "WPNAV_ACCEL_Z"), 0.01),
    **dict.fromkeys(("WPNAV_RADIUS", "ANGLE_MAX", "LAND_SPEED", "RTL_ALT"), 0.01),
    "RTL_LOIT_TIME": 0.001,
}

PARAMETER_TABLE = ParameterTable(
    moving=DEFAULTS,
    others=STATION_PARAMETERS,
    set_up=SET_UP,
    types=TYPES,
    climb=Quantity("WPNAV_SPEED_UP", 0.01),
    descent=Quantity("WPNAV_SPEED_DN", 0.01),
    return_height=Quantity("RTL_ALT", 0.01),
    fence_switch="FENCE_ENABLE",
    system_id="MAV_SYSID",
    meanings=MEANINGS,
    units=UNITS,
    surely_there=(("MAV_SYSID", "SYSID_THISMAV"), ("FRAME_CLASS",)),
    renamed=RENAMED,
    speed=Quantity("WPNAV_SPEED", 0.01),
)
