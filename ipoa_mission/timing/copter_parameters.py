"""ArduCopter's parameters in SI units, whether they are given by the names of 4.7 (metres) or of before (centimetres).

The renaming is ArduPilot's own ("Parameter Name Changes", 4.6 to 4.7, and pull requests 31970 and 32147).
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass

from ipoa_mission.errors import BadInput
from ipoa_mission.vehicle import ARDUCOPTER_DEFAULTS, Parameters

#: Name from 4.7 on: name before, and how many of the old unit make one of the new.
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
    old = {name: value for name, value in parameters.items() if name not in RENAMED}
    old |= {RENAMED[name][0]: value * RENAMED[name][1] for name, value in parameters.items() if name in RENAMED}
    p = {**ARDUCOPTER_DEFAULTS, **FURTHER, **old}
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
