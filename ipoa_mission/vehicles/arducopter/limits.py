"""ArduCopter's parameters, and the motion limits, own fence and height of RTL (4.x) that they set.

Defaults of sensors, radio, modes, battery and failsafes are as in SITL. Times on the ground are read and measured
there (docs/lab/flight-time.md).
"""

import math
from collections.abc import Iterator
from enum import IntEnum
from typing import Annotated, NamedTuple

import numpy as np

from ipoa_mission.autopilot.failsafe import FenceLimit, OwnFence
from ipoa_mission.autopilot.parameters import (
    INT8,
    INT16,
    INT32,
    Parameter,
    Parameters,
    ParameterTable,
    parameters_of_fields,
    whole,
)
from ipoa_mission.autopilot.version import Version
from ipoa_mission.geometry import GRAVITY, Vector

CENTI = 0.01  # cm, cm/s, cm/s^2, centidegrees

#: ArduCopter 4.7's defaults; newer names by "Parameter Name Changes" 4.6 to 4.7, pull requests 31970 and 32147.
AFFECTING = (
    Parameter("WPNAV_SPEED", 1000.0, meaning="cruise speed", unit=CENTI, newer="WP_SPD", positive=True),
    Parameter("WPNAV_SPEED_UP", 250.0, meaning="climb speed", unit=CENTI, newer="WP_SPD_UP", positive=True),
    Parameter("WPNAV_SPEED_DN", 150.0, meaning="descent speed", unit=CENTI, newer="WP_SPD_DN", positive=True),
    Parameter("WPNAV_ACCEL", 250.0, meaning="acceleration", unit=CENTI, newer="WP_ACC", positive=True),
    Parameter("WPNAV_ACCEL_C", 0.0, unit=CENTI, newer="WP_ACC_CNR"),
    Parameter("WPNAV_ACCEL_Z", 100.0, meaning="vertical acceleration", unit=CENTI, newer="WP_ACC_Z", positive=True),
    Parameter("WPNAV_JERK", 1.0, meaning="jerk", newer="WP_JERK", positive=True),
    Parameter("WPNAV_RADIUS", 200.0, meaning="acceptance radius", unit=CENTI, newer="WP_RADIUS_M", positive=True),
    Parameter("WP_YAW_BEHAVIOR", 2.0, INT8, meaning="heading"),
    Parameter("PSC_JERK_XY", 5.0, newer="PSC_JERK_NE", positive=True),
    Parameter("PSC_JERK_Z", 5.0, newer="PSC_JERK_D", positive=True),
    Parameter("PSC_POSXY_P", 1.0, meaning="position P", newer="PSC_NE_POS_P", positive=True),
    Parameter("PSC_VELXY_P", 2.0, meaning="velocity P", newer="PSC_NE_VEL_P"),
    Parameter("PSC_VELXY_I", 1.0, meaning="velocity I", newer="PSC_NE_VEL_I"),
    Parameter("PSC_VELXY_D", 0.25, meaning="velocity D", newer="PSC_NE_VEL_D"),
    Parameter("PSC_VELXY_FLTE", 5.0, newer="PSC_NE_VEL_FLTE", positive=True),
    Parameter("PSC_POSZ_P", 1.0, meaning="height P", newer="PSC_D_POS_P", positive=True),
    Parameter("ATC_SLEW_YAW", 6000.0, meaning="yaw rate", unit=CENTI, newer="ATC_RATE_WPY_MAX"),
    Parameter("ANGLE_MAX", 3000.0, INT16, meaning="tilt", unit=CENTI, newer="ATC_ANGLE_MAX", positive=True),
    Parameter("LAND_SPEED", 50.0, INT16, meaning="landing speed", unit=CENTI, newer="LAND_SPD_MS", positive=True),
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
    Parameter("RALLY_INCL_HOME", 1.0, INT8),
    Parameter("CIRCLE_RADIUS", 1000.0, unit=CENTI, newer="CIRCLE_RADIUS_M"),
    Parameter("CIRCLE_RATE", 20.0),
    Parameter("ATC_RATE_R_MAX", 0.0),
    Parameter("ATC_RATE_P_MAX", 0.0),
    Parameter("PSC_ANGLE_MAX", 0.0),
    Parameter("RNGFND1_TYPE", 0.0, INT8),
    Parameter("PLDP_SPEED_DN", 0.0),
    Parameter("RTL_ALT_TYPE", 0.0, INT8),
    Parameter("WPNAV_TER_MARGIN", None, newer="WP_TER_MARGIN"),
    Parameter("WPNAV_RFND_USE", None, newer="WP_RFND_USE"),
    Parameter("TERRAIN_ENABLE", None, INT8),
    Parameter("MIS_OPTIONS", 0.0, INT16),
    Parameter("FENCE_MARGIN", 2.0),
)
#: Of failsafes; only their type is known.
_TYPED = {
    INT8: (
        "AVD_ENABLE", "AVD_F_ACTION", "CHUTE_ENABLED", "FENCE_AUTOENABLE", "FS_CRASH_CHECK", "FS_DR_ENABLE",
        "FS_EKF_ACTION",
        *(f"BATT{n}_{name}" for n in range(2, 10) for name in ("MONITOR", "FS_LOW_ACT", "FS_CRT_ACT")),
    ),
    INT16: ("MAV_GCS_SYSID", "MAV_GCS_SYSID_HI", "SRTL_POINTS", "SYSID_MYGCS"),
    INT32: ("FS_OPTIONS",),
}  # fmt: skip
FURTHER = (
    Parameter("MAV_SYSID", 1.0, INT16, meaning="system id"),
    Parameter("FRAME_CLASS", 1.0, INT8),
    Parameter("ARMING_CHECK", 1.0, INT32),
    Parameter("AUTO_OPTIONS", 0.0, INT32),
    Parameter("GUID_OPTIONS", 0.0, INT32),
    Parameter("MIS_RESTART", 0.0, INT8),
    Parameter("LOG_DISARMED", 0.0, INT8),
    Parameter("FENCE_ENABLE", 0.0, INT8, meaning="fence switch"),
    Parameter("FENCE_TYPE", 7.0, INT8),
    Parameter("FENCE_ACTION", 1.0, INT8),
    Parameter("FENCE_OPTIONS", 0.0, INT16),
    Parameter("FENCE_RADIUS", 300.0),
    Parameter("FENCE_ALT_MAX", 100.0),
    Parameter("FENCE_ALT_MIN", -10.0),
    *(Parameter(name, None, kind) for kind, names in _TYPED.items() for name in names),
)


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
    surely_there=(("MAV_SYSID", "SYSID_THISMAV"), ("FRAME_CLASS",)),
    steered_by=("OA_TYPE",),
    limits_speed="WPNAV_SPEED",
)

ARMING_DELAY_S = 2.0  # motors are off after arming
LIFT_S = 0.2  # from full spin to lift-off
LANDED_S = 0.58 + 1.0  # to least throttle, then to be detected
CENTIMETER = 0.01  # resolution of heights [m]

BRAKES_CLIMB = (4, 8)
SENSE_OF_RATE = (4, 7)  # since then CIRCLE_RATE's sign sets every sense
EXCEPT_RTL = 2.0  # WP_YAW_BEHAVIOR: along the path except in RTL


#: These enable the fence, always or from arming or take-off.
FENCE_SWITCHES = {"FENCE_ENABLE": 0.0, "FENCE_AUTOENABLE": 0.0}


class FenceType(IntEnum):
    """Bits of FENCE_TYPE."""

    CEILING = 1
    CIRCLE = 2
    POLYGONS = 4
    FLOOR = 8


def fence_limits(parameters: Parameters) -> OwnFence | None:
    """Return the limits that FENCE_TYPE enables; None: the fence is off."""
    if not any(parameters.get(name, default) for name, default in FENCE_SWITCHES.items()):
        return None
    p = {**PARAMETER_TABLE.others, **parameters}

    def limit(name: str, bit: FenceType, none: float) -> FenceLimit:
        return FenceLimit(name, p[name] if whole(p, "FENCE_TYPE") & bit else none)

    return OwnFence(
        limit("FENCE_RADIUS", FenceType.CIRCLE, math.inf),
        limit("FENCE_ALT_MAX", FenceType.CEILING, math.inf),
        limit("FENCE_ALT_MIN", FenceType.FLOOR, -math.inf),
    )


class CopterReturn(NamedTuple):
    altitude: float  # RTL_ALT [m]
    climb: float  # RTL_CLIMB_MIN
    cone: float  # RTL_CONE_SLOPE
    ceiling: float  # of the fence

    @classmethod
    def of(cls, parameters: Parameters) -> "CopterReturn":
        p = {**PARAMETER_TABLE.others, **PARAMETER_TABLE.moving, **parameters}
        fence = fence_limits(parameters)
        ceiling = math.inf if fence is None else fence.ceiling.value - p["FENCE_MARGIN"]
        rows = PARAMETER_TABLE.by_name
        altitude, climb = (rows[name].si(p[name]) for name in ("RTL_ALT", "RTL_CLIMB_MIN"))
        return cls(altitude, max(climb, 0.0), p["RTL_CONE_SLOPE"], ceiling)

    def height(self, above: float, distance: float, goal_up: float) -> float:
        """Return the height above home [m], from `above` home over a horizontal distance to `goal_up`.

        Near the goal a cone of at least 0.5 limits it, and FENCE_MARGIN below a ceiling. It never descends for a limit.
        """
        least = max(0.3, above + self.climb)  # RTL_ALT_MIN
        top = max(self.altitude, goal_up, least)
        if self.cone >= 0.5:
            top = min(top, max(distance * self.cone, least))
        return max(min(top, self.ceiling), above)


class CopterLimits(NamedTuple):
    """Motion limits in m, s, rad; gains in 1/s; a filter in Hz."""

    speed: Annotated[float, "WPNAV_SPEED"]
    climb: Annotated[float, "WPNAV_SPEED_UP"]
    descent: Annotated[float, "WPNAV_SPEED_DN"]
    accel: Annotated[float, "WPNAV_ACCEL"]
    accel_z: Annotated[float, "WPNAV_ACCEL_Z"]
    corner_accel: float
    jerk: float
    snap: float
    shaping_jerk: float
    jerk_z: Annotated[float, "PSC_JERK_Z"]
    radius: Annotated[float, "WPNAV_RADIUS"]
    max_tilt: float
    tilt_lag: float  # time constant
    spool_up: Annotated[float, "MOT_SPOOL_TIME"]
    land_speed: Annotated[float, "LAND_SPEED"]
    land_speed_high: float
    land_low: float
    payload_speed: float
    returning: CopterReturn
    rtl_speed: float
    rtl_loiter: Annotated[float, "RTL_LOIT_TIME"]
    rtl_final: Annotated[float, "RTL_ALT_FINAL"]
    circle_rate: float
    circle_sense: float
    p_position: Annotated[float, "PSC_POSXY_P"]
    p_velocity: Annotated[float, "PSC_VELXY_P"]
    i_velocity: Annotated[float, "PSC_VELXY_I"]
    d_velocity: Annotated[float, "PSC_VELXY_D"]
    velocity_filter: Annotated[float, "PSC_VELXY_FLTE"]
    p_height: Annotated[float, "PSC_POSZ_P"]
    yaw_rate: float
    rtl_turns: bool
    sees_ground: bool
    brakes_climb: bool

    def stopping_distance(self, speed: Vector | float) -> Vector:
        """Return the horizontal distance from `speed` [m/s] to a stop [m] (inv_sqrt_controller)."""
        linear = speed / self.p_position
        beyond = self.accel / self.p_position**2 / 2 + speed**2 / (2 * self.accel)
        return np.where(speed <= self.accel / self.p_position, linear, beyond)

    @property
    def lift_off_s(self) -> float:
        return ARMING_DELAY_S + 2 * self.spool_up + LIFT_S


FIELDS = parameters_of_fields(CopterLimits)


def copter_limits(parameters: Parameters, version: Version | None = None) -> CopterLimits:
    """Return the limits of these parameters, with ArduCopter 4.7's defaults.

    Since 4.8 a climb is braked with all acceleration, before with half (`shape_pos_vel_accel`). WPNAV_JERK and attitude
    rates limit the S-curves' jerk. The tilt's time constant and angular acceleration, halved, limit their snap.

    Raises:
        BadInput: a parameter that must be positive is not.
    """
    known = PARAMETER_TABLE.complete(parameters)
    PARAMETER_TABLE.expect_positive(known)
    p = PARAMETER_TABLE.si(known)
    turning = math.radians(min(p["ATC_RATE_R_MAX"], p["ATC_RATE_P_MAX"]))
    jerk = min(p["WPNAV_JERK"], turning * GRAVITY) if turning > 0 else p["WPNAV_JERK"]
    snap = jerk * math.pi / (2 * max(p["ATC_INPUT_TC"], 0.1))
    spinning = math.radians(min(p["ATC_ACCEL_R_MAX"], p["ATC_ACCEL_P_MAX"]))
    if spinning > 0:
        snap = min(snap, spinning * GRAVITY)
    shaping_jerk = min(p["PSC_JERK_XY"], turning * GRAVITY) if turning > 0 else p["PSC_JERK_XY"]
    if spinning > 0:
        shaping_jerk = min(shaping_jerk, math.sqrt(p["WPNAV_ACCEL"] * spinning * GRAVITY) / 2)
    tilt_deg = p["PSC_ANGLE_MAX"] if p["PSC_ANGLE_MAX"] > 0 else p["ANGLE_MAX"]
    sense = 0.0 if version is not None and version.series < SENSE_OF_RATE else math.copysign(1.0, p["CIRCLE_RATE"])
    return CopterLimits(
        **{field: p[name] for field, name in FIELDS.items()},
        corner_accel=p["WPNAV_ACCEL_C"] if p["WPNAV_ACCEL_C"] > 0 else 2 * p["WPNAV_ACCEL"],
        jerk=jerk,
        snap=snap / 2,
        shaping_jerk=shaping_jerk,
        max_tilt=math.radians(min(tilt_deg, 80.0)),
        tilt_lag=max(p["ATC_INPUT_TC"], 0.05),
        land_speed_high=p["LAND_SPEED_HIGH"] if p["LAND_SPEED_HIGH"] > 0 else p["WPNAV_SPEED_DN"],
        land_low=max(p["LAND_ALT_LOW"], 1.0),
        payload_speed=p["PLDP_SPEED_DN"] if p["PLDP_SPEED_DN"] > 0 else p["LAND_SPEED"],
        returning=CopterReturn.of(known),
        rtl_speed=p["RTL_SPEED"] if p["RTL_SPEED"] > 0 else p["WPNAV_SPEED"],
        circle_rate=math.radians(abs(p["CIRCLE_RATE"])),
        circle_sense=sense,
        rtl_turns=p["WP_YAW_BEHAVIOR"] != EXCEPT_RTL,
        sees_ground=p["RNGFND1_TYPE"] > 0,
        brakes_climb=version is None or version.series >= BRAKES_CLIMB,
        yaw_rate=math.radians(p["ATC_SLEW_YAW"]) if p["WP_YAW_BEHAVIOR"] > 0 else 0.0,
    )
