"""ArduCopter's motion limits, and its times on the ground.

Ground times are read and measured in SITL (docs/lab/flight-time.md).
"""

import math
from dataclasses import dataclass

from ipoa_mission.autopilot.parameters import Parameters
from ipoa_mission.autopilot.version import Version
from ipoa_mission.errors import BadInput
from ipoa_mission.geometry import GRAVITY
from ipoa_mission.vehicles.arducopter.fence_and_rtl import CopterReturn
from ipoa_mission.vehicles.arducopter.parameter_table import PARAMETER_TABLE

ARMING_DELAY_S = 2.0  # motors are off after arming
LIFT_S = 0.2  # from full spin to lift-off
LANDED_S = 0.58 + 1.0  # to least throttle, then to be detected
CENTIMETER = 0.01  # resolution of heights [m]

BRAKES_CLIMB = (4, 8)
SENSE_OF_RATE = (4, 7)  # since then CIRCLE_RATE's sign sets every sense
EXCEPT_RTL = 2.0  # WP_YAW_BEHAVIOR: along the path except in RTL

POSITIVE = (
    "WPNAV_SPEED", "WPNAV_SPEED_UP", "WPNAV_SPEED_DN", "WPNAV_ACCEL", "WPNAV_ACCEL_Z", "WPNAV_JERK", "WPNAV_RADIUS",
    "PSC_JERK_XY", "PSC_JERK_Z", "PSC_POSXY_P", "PSC_VELXY_FLTE", "PSC_POSZ_P", "ANGLE_MAX", "LAND_SPEED",
)  # fmt: skip


def usable(parameters: Parameters) -> Parameters:
    """Drop values that must be positive and are not."""
    return {name: value for name, value in parameters.items() if name not in POSITIVE or value > 0}


@dataclass(frozen=True)
class CopterLimits:
    """Motion limits in m, s, rad; gains in 1/s; a filter in Hz."""

    speed: float
    climb: float
    descent: float
    accel: float
    accel_z: float
    corner_accel: float
    jerk: float
    snap: float
    shaping_jerk: float
    jerk_z: float
    radius: float
    lean: float
    lean_lag: float  # time constant
    spool_up: float
    land_speed: float
    land_speed_high: float
    land_low: float
    payload_speed: float
    returning: CopterReturn
    rtl_speed: float
    rtl_loiter: float
    rtl_final: float
    circle_radius: float
    circle_rate: float
    circle_sense: float
    p_position: float
    p_velocity: float
    i_velocity: float
    d_velocity: float
    velocity_filter: float
    p_height: float
    yaw_rate: float
    rtl_turns: bool
    sees_ground: bool
    brakes_climb: bool

    @property
    def lift_off_s(self) -> float:
        return ARMING_DELAY_S + 2 * self.spool_up + LIFT_S


def copter_limits(parameters: Parameters, version: Version | None = None) -> CopterLimits:
    """Return the limits of these parameters, with ArduCopter 4.7's defaults.

    Since 4.8 a climb is braked with all acceleration, before with half (`shape_pos_vel_accel`). WPNAV_JERK and attitude
    rates limit the S-curves' jerk. The lean's time constant and angular acceleration, halved, limit their snap.

    Raises:
        BadInput: a parameter that must be positive is not.
    """
    p = PARAMETER_TABLE.complete(parameters)
    for name in POSITIVE:
        if not p[name] > 0:
            raise BadInput(f"expected more than 0, not {p[name]:g}", place=name)
    turning = math.radians(min(p["ATC_RATE_R_MAX"], p["ATC_RATE_P_MAX"]))
    jerk = min(p["WPNAV_JERK"], turning * GRAVITY) if turning > 0 else p["WPNAV_JERK"]
    snap = jerk * math.pi / (2 * max(p["ATC_INPUT_TC"], 0.1))
    spinning = math.radians(min(p["ATC_ACCEL_R_MAX"], p["ATC_ACCEL_P_MAX"]) / 100)
    if spinning > 0:
        snap = min(snap, spinning * GRAVITY)
    shaping_jerk = min(p["PSC_JERK_XY"], turning * GRAVITY) if turning > 0 else p["PSC_JERK_XY"]
    accel = p["WPNAV_ACCEL"] / 100
    if spinning > 0:
        shaping_jerk = min(shaping_jerk, math.sqrt(accel * spinning * GRAVITY) / 2)
    lean_deg = p["PSC_ANGLE_MAX"] if p["PSC_ANGLE_MAX"] > 0 else p["ANGLE_MAX"] / 100
    descent, rate = p["WPNAV_SPEED_DN"] / 100, p["CIRCLE_RATE"]
    return CopterLimits(
        speed=p["WPNAV_SPEED"] / 100,
        climb=p["WPNAV_SPEED_UP"] / 100,
        descent=descent,
        accel=accel,
        accel_z=p["WPNAV_ACCEL_Z"] / 100,
        corner_accel=p["WPNAV_ACCEL_C"] / 100 if p["WPNAV_ACCEL_C"] > 0 else 2 * accel,
        jerk=jerk,
        snap=snap / 2,
        shaping_jerk=shaping_jerk,
        jerk_z=p["PSC_JERK_Z"],
        radius=p["WPNAV_RADIUS"] / 100,
        lean=math.radians(min(lean_deg, 80.0)),
        lean_lag=max(p["ATC_INPUT_TC"], 0.05),
        spool_up=p["MOT_SPOOL_TIME"],
        land_speed=p["LAND_SPEED"] / 100,
        land_speed_high=p["LAND_SPEED_HIGH"] / 100 if p["LAND_SPEED_HIGH"] > 0 else descent,
        land_low=max(p["LAND_ALT_LOW"] / 100, 1.0),
        payload_speed=p["PLDP_SPEED_DN"] if p["PLDP_SPEED_DN"] > 0 else p["LAND_SPEED"] / 100,
        returning=CopterReturn.of(p),
        rtl_speed=p["RTL_SPEED"] / 100 if p["RTL_SPEED"] > 0 else p["WPNAV_SPEED"] / 100,
        rtl_loiter=p["RTL_LOIT_TIME"] / 1000,
        rtl_final=p["RTL_ALT_FINAL"] / 100,
        circle_radius=p["CIRCLE_RADIUS"] / 100,
        circle_rate=math.radians(abs(p["CIRCLE_RATE"])),
        circle_sense=0.0 if version is not None and version.series < SENSE_OF_RATE else math.copysign(1.0, rate),
        p_position=p["PSC_POSXY_P"],
        p_velocity=p["PSC_VELXY_P"],
        i_velocity=p["PSC_VELXY_I"],
        d_velocity=p["PSC_VELXY_D"],
        velocity_filter=p["PSC_VELXY_FLTE"],
        p_height=p["PSC_POSZ_P"],
        rtl_turns=p["WP_YAW_BEHAVIOR"] != EXCEPT_RTL,
        sees_ground=p["RNGFND1_TYPE"] > 0,
        brakes_climb=version is None or version.series >= BRAKES_CLIMB,
        yaw_rate=math.radians(p["ATC_SLEW_YAW"] / 100) if p["WP_YAW_BEHAVIOR"] > 0 else 0.0,
    )
