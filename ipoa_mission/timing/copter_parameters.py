"""ArduCopter's parameters in SI units, given by the names of 4.7 (metres) or of before (centimetres)."""

import math
from dataclasses import dataclass

from ipoa_mission.errors import BadInput
from ipoa_mission.vehicle import ARDUCOPTER_DEFAULTS, Parameters, by_old_names

#: Parameters of ArduCopter that count here and are not among the package's defaults, with its own defaults.
FURTHER: Parameters = {
    "RTL_CLIMB_MIN": 0.0,
    "RTL_CONE_SLOPE": 3.0,
    "CIRCLE_RADIUS": 1000.0,
    "CIRCLE_RATE": 20.0,
    "ATC_RATE_R_MAX": 0.0,
    "ATC_RATE_P_MAX": 0.0,
    "PSC_ANGLE_MAX": 0.0,
}
POSITIVE = (
    "WPNAV_SPEED",
    "WPNAV_SPEED_UP",
    "WPNAV_SPEED_DN",
    "WPNAV_ACCEL",
    "WPNAV_ACCEL_Z",
    "WPNAV_JERK",
    "WPNAV_RADIUS",
    "PSC_JERK_Z",
    "ANGLE_MAX",
    "LAND_SPEED",
)


@dataclass(frozen=True)
class CopterLimits:
    """What moves an ArduCopter along a mission: m, s, m/s, m/s^2, m/s^3, m/s^4, rad."""

    speed: float
    climb: float
    descent: float
    accel: float
    accel_z: float
    corner_accel: float
    jerk: float
    snap: float
    jerk_z: float
    radius: float
    lean: float
    lean_lag: float
    spool_up: float
    land_speed: float
    land_speed_high: float
    land_low: float
    rtl_height: float
    rtl_climb: float
    rtl_cone: float
    rtl_speed: float
    rtl_loiter: float
    rtl_final: float
    circle_radius: float
    circle_rate: float


def copter_limits(parameters: Parameters) -> CopterLimits:
    """The limits that these parameters set; what is not given has ArduCopter 4.7's default.

    Jerk and snap are what the S-curves use: WPNAV_JERK and the attitude controller's rates limit the first, the lean's
    time constant (as leaning is what accelerates a multirotor) and its angular acceleration, halved, the second.

    Raises:
        BadInput: a parameter that must be positive is not.
    """
    p = {**ARDUCOPTER_DEFAULTS, **FURTHER, **by_old_names(parameters)}
    for name in POSITIVE:
        if not p[name] > 0:
            raise BadInput(f"{name}: expected more than 0, not {p[name]:g}")
    gravity = 9.80665
    turning = math.radians(min(p["ATC_RATE_R_MAX"], p["ATC_RATE_P_MAX"]))
    jerk = min(p["WPNAV_JERK"], turning * gravity) if turning > 0 else p["WPNAV_JERK"]
    snap = jerk * math.pi / (2 * max(p["ATC_INPUT_TC"], 0.1))
    spinning = math.radians(min(p["ATC_ACCEL_R_MAX"], p["ATC_ACCEL_P_MAX"]) / 100)
    if spinning > 0:
        snap = min(snap, spinning * gravity)
    lean_deg = p["PSC_ANGLE_MAX"] if p["PSC_ANGLE_MAX"] > 0 else p["ANGLE_MAX"] / 100
    accel, descent = p["WPNAV_ACCEL"] / 100, p["WPNAV_SPEED_DN"] / 100
    return CopterLimits(
        speed=p["WPNAV_SPEED"] / 100,
        climb=p["WPNAV_SPEED_UP"] / 100,
        descent=descent,
        accel=accel,
        accel_z=p["WPNAV_ACCEL_Z"] / 100,
        corner_accel=p["WPNAV_ACCEL_C"] / 100 if p["WPNAV_ACCEL_C"] > 0 else 2 * accel,
        jerk=jerk,
        snap=snap / 2,
        jerk_z=p["PSC_JERK_Z"],
        radius=p["WPNAV_RADIUS"] / 100,
        lean=math.radians(min(lean_deg, 80.0)),
        lean_lag=max(p["ATC_INPUT_TC"], 0.05),
        spool_up=p["MOT_SPOOL_TIME"],
        land_speed=p["LAND_SPEED"] / 100,
        land_speed_high=p["LAND_SPEED_HIGH"] / 100 if p["LAND_SPEED_HIGH"] > 0 else descent,
        land_low=max(p["LAND_ALT_LOW"] / 100, 1.0),
        rtl_height=p["RTL_ALT"] / 100,
        rtl_climb=p["RTL_CLIMB_MIN"] / 100,
        rtl_cone=p["RTL_CONE_SLOPE"],
        rtl_speed=p["RTL_SPEED"] / 100 if p["RTL_SPEED"] > 0 else p["WPNAV_SPEED"] / 100,
        rtl_loiter=p["RTL_LOIT_TIME"] / 1000,
        rtl_final=p["RTL_ALT_FINAL"] / 100,
        circle_radius=p["CIRCLE_RADIUS"] / 100,
        circle_rate=math.radians(abs(p["CIRCLE_RATE"])),
    )
