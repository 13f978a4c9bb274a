"""ArduCopter's parameters: defaults (sensors, radio, modes, battery, failsafes as in SITL) and types."""

from collections.abc import Iterator

from ipoa_mission.autopilot.parameters import INT8, INT16, INT32, Parameter, ParameterTable

CENTI = 0.01  # cm, cm/s, cm/s^2, centidegrees

#: ArduCopter 4.7's defaults; newer names by "Parameter Name Changes" 4.6 to 4.7, pull requests 31970 and 32147.
AFFECTING = (
    Parameter("WPNAV_SPEED", 1000.0, meaning="cruise speed", unit=CENTI, newer="WP_SPD"),
    Parameter("WPNAV_SPEED_UP", 250.0, meaning="climb speed", unit=CENTI, newer="WP_SPD_UP"),
    Parameter("WPNAV_SPEED_DN", 150.0, meaning="descent speed", unit=CENTI, newer="WP_SPD_DN"),
    Parameter("WPNAV_ACCEL", 250.0, meaning="acceleration", unit=CENTI, newer="WP_ACC"),
    Parameter("WPNAV_ACCEL_C", 0.0, unit=CENTI, newer="WP_ACC_CNR"),
    Parameter("WPNAV_ACCEL_Z", 100.0, meaning="vertical acceleration", unit=CENTI, newer="WP_ACC_Z"),
    Parameter("WPNAV_JERK", 1.0, meaning="jerk", newer="WP_JERK"),
    Parameter("WPNAV_RADIUS", 200.0, meaning="acceptance radius", unit=CENTI, newer="WP_RADIUS_M"),
    Parameter("WP_YAW_BEHAVIOR", 2.0, INT8, meaning="heading"),
    Parameter("PSC_JERK_XY", 5.0, newer="PSC_JERK_NE"),
    Parameter("PSC_JERK_Z", 5.0, newer="PSC_JERK_D"),
    Parameter("PSC_POSXY_P", 1.0, meaning="position P"),
    Parameter("PSC_VELXY_P", 2.0, meaning="velocity P"),
    Parameter("PSC_VELXY_I", 1.0, meaning="velocity I"),
    Parameter("PSC_VELXY_D", 0.25, meaning="velocity D"),
    Parameter("PSC_VELXY_FLTE", 5.0),
    Parameter("PSC_POSZ_P", 1.0, meaning="height P"),
    Parameter("ATC_SLEW_YAW", 6000.0, meaning="yaw rate", unit=CENTI),
    Parameter("ANGLE_MAX", 3000.0, INT16, meaning="lean", unit=CENTI, newer="ATC_ANGLE_MAX"),
    Parameter("LAND_SPEED", 50.0, INT16, meaning="landing speed", unit=CENTI, newer="LAND_SPD_MS"),
    Parameter("LAND_SPEED_HIGH", 0.0, INT16, unit=CENTI, newer="LAND_SPD_HIGH_MS"),
    Parameter("LAND_ALT_LOW", 1000.0, INT16, meaning="height of slow landing", unit=CENTI, newer="LAND_ALT_LOW_M"),
    Parameter("RTL_ALT", 1500.0, INT32, meaning="return height", unit=CENTI, newer="RTL_ALT_M"),
    Parameter("RTL_SPEED", 0.0, INT16, unit=CENTI, newer="RTL_SPEED_MS"),
    Parameter("RTL_LOIT_TIME", 5000.0, INT32, meaning="wait before landing", unit=0.001),
    Parameter("RTL_ALT_FINAL", 0.0, INT16, meaning="height after a return", unit=CENTI, newer="RTL_ALT_FINAL_M"),
    Parameter("ATC_ACCEL_P_MAX", 110000.0, unit=CENTI, newer="ATC_ACC_P_MAX"),
    Parameter("ATC_ACCEL_R_MAX", 110000.0, unit=CENTI, newer="ATC_ACC_R_MAX"),
    Parameter("ATC_INPUT_TC", 0.15),
    Parameter("MOT_SPOOL_TIME", 0.5, meaning="spool-up"),
    Parameter("DISARM_DELAY", 10.0, INT8, meaning="disarming"),
    Parameter("RTL_CLIMB_MIN", 0.0, INT16, unit=CENTI, newer="RTL_CLIMB_MIN_M"),
    Parameter("RTL_CONE_SLOPE", 3.0, meaning="return cone"),
    Parameter("RALLY_LIMIT_KM", 0.3),
    Parameter("RALLY_INCL_HOME", 1.0),
    Parameter("CIRCLE_RADIUS", 1000.0, unit=CENTI, newer="CIRCLE_RADIUS_M"),
    Parameter("CIRCLE_RATE", 20.0),
    Parameter("ATC_RATE_R_MAX", 0.0),
    Parameter("ATC_RATE_P_MAX", 0.0),
    Parameter("PSC_ANGLE_MAX", 0.0),
    Parameter("RNGFND1_TYPE", 0.0, INT8),
    Parameter("PLDP_SPEED_DN", 0.0),
)
FURTHER = (
    Parameter("MAV_SYSID", 1.0, INT16, meaning="system id"),
    Parameter("FRAME_CLASS", 1.0, INT8),
    Parameter("ARMING_CHECK", 1.0, INT32),
    Parameter("AUTO_OPTIONS", 0.0, INT32),
    Parameter("GUID_OPTIONS", 0.0, INT32),
    Parameter("MIS_OPTIONS", 0.0, INT16),
    Parameter("MIS_RESTART", 0.0, INT8),
    Parameter("LOG_DISARMED", 0.0, INT8),
    Parameter("FENCE_ENABLE", 0.0, INT8, meaning="fence switch"),
    Parameter("FENCE_TYPE", 7.0, INT8),
    Parameter("FENCE_ACTION", 1.0, INT8),
    Parameter("FENCE_OPTIONS", 0.0, INT16),
    Parameter("FENCE_MARGIN", 2.0),
    Parameter("FENCE_RADIUS", 300.0),
    Parameter("FENCE_ALT_MAX", 100.0),
    Parameter("FENCE_ALT_MIN", -10.0),
    Parameter("RTL_ALT_TYPE", 0.0, INT8),
    Parameter("WPNAV_TER_MARGIN", None, newer="WP_TER_MARGIN"),
    Parameter("WPNAV_RFND_USE", None, newer="WP_RFND_USE"),
    Parameter("TERRAIN_ENABLE", None, INT8),
)
POSITIVE = (
    "WPNAV_SPEED", "WPNAV_SPEED_UP", "WPNAV_SPEED_DN", "WPNAV_ACCEL", "WPNAV_ACCEL_Z", "WPNAV_JERK", "WPNAV_RADIUS",
    "PSC_JERK_XY", "PSC_JERK_Z", "PSC_POSXY_P", "PSC_VELXY_FLTE", "PSC_POSZ_P", "ANGLE_MAX", "LAND_SPEED",
)  # fmt: skip


def _radio() -> Iterator[Parameter]:
    for number, stick in enumerate(("ROLL", "PITCH", "THROTTLE", "YAW"), start=1):
        yield Parameter(f"RCMAP_{stick}", float(number), INT8)
    for number, dead_zone in enumerate((20.0, 20.0, 30.0, 20.0, 0.0, 0.0, 0.0, 0.0), start=1):
        values = {"MIN": 1000.0, "TRIM": 1500.0, "MAX": 2000.0, "DZ": dead_zone}
        yield from (Parameter(f"RC{number}_{name}", value, INT16) for name, value in values.items())
        yield Parameter(f"RC{number}_REVERSED", 0.0, INT8)
    for number, mode in enumerate((7.0, 9.0, 6.0, 3.0, 5.0, 0.0), start=1):
        yield Parameter(f"FLTMODE{number}", mode, INT8)


PARAMETER_TABLE = ParameterTable(
    affecting=AFFECTING,
    further=FURTHER,
    set_up=(
        *_radio(),
        Parameter("FLTMODE_CH", 5.0, INT8),
        Parameter("FRAME_TYPE", 0.0, INT8),
        Parameter("COMPASS_DEV_ID", 97539.0, INT32),
        Parameter("COMPASS_DEV_ID2", 131874.0, INT32),
        Parameter("COMPASS_DEV_ID3", 263178.0, INT32),
        Parameter("BATT_MONITOR", 4.0, INT8),
        Parameter("BATT_CAPACITY", 3300.0, INT32),
        Parameter("BATT_ARM_VOLT", 0.0),
        Parameter("BATT_LOW_VOLT", 10.5),
        Parameter("BATT_LOW_MAH", 0.0),
        Parameter("BATT_FS_LOW_ACT", 0.0, INT8),
        Parameter("BATT_FS_CRT_ACT", 0.0, INT8),
        Parameter("FS_THR_ENABLE", 1.0, INT8),
        Parameter("FS_THR_VALUE", 975.0, INT16),
        Parameter("FS_GCS_ENABLE", 0.0, INT8),
    ),
    positive=POSITIVE,
    surely_there=(("MAV_SYSID", "SYSID_THISMAV"), ("FRAME_CLASS",)),
    limits_speed="WPNAV_SPEED",
)
