"""PX4's parameters as the multicopter's mission uses them, checked; they are in SI units already."""

import math
from dataclasses import dataclass

from ipoa_mission.errors import BadInput
from ipoa_mission.timing.body import GRAVITY
from ipoa_mission.touchdown import Px4Touchdown
from ipoa_mission.vehicle import PX4_DEFAULTS, Parameters, Px4Return

#: Parameters of PX4 that count here and are not among the package's defaults, with its own defaults.
FURTHER: Parameters = {
    "MPC_XY_VEL_P_ACC": 1.8,
    "MPC_XY_VEL_I_ACC": 0.4,
    "MPC_XY_VEL_D_ACC": 0.2,
    "MPC_Z_VEL_P_ACC": 4.0,
    "MPC_Z_VEL_I_ACC": 2.0,
    "MPC_Z_VEL_MAX_UP": 3.0,
    "MPC_Z_VEL_MAX_DN": 1.5,
    "MPC_TILTMAX_AIR": 45.0,
    "MPC_THR_HOVER": 0.5,
    "MPC_USE_HTE": 1.0,
    "HTE_HT_NOISE": 0.0036,
    "MC_ROLL_P": 6.5,
    "MIS_YAW_ERR": 12.0,
    "COM_DISARM_LAND": 2.0,
    "MPC_LAND_ALT3": 1.0,
    "MPC_LAND_CRWL": 0.3,
    "MPC_THR_MIN": 0.12,
    "LNDMC_TRIG_TIME": 1.0,
    "LNDMC_Z_VEL_MAX": 0.25,
}
TURN_FIRST = 4.0  # MPC_YAW_MODE: the nose first, then the way
POSITIVE = (
    "MPC_XY_CRUISE",
    "MPC_XY_VEL_MAX",
    "MPC_XY_TRAJ_P",
    "MPC_XY_ERR_MAX",
    "MPC_XY_P",
    "MPC_ACC_HOR",
    "MPC_JERK_AUTO",
    "MPC_Z_V_AUTO_UP",
    "MPC_Z_V_AUTO_DN",
    "MPC_ACC_UP_MAX",
    "MPC_ACC_DOWN_MAX",
    "MPC_TKO_SPEED",
    "MPC_LAND_SPEED",
    "MPC_LAND_CRWL",
    "MPC_XY_VEL_P_ACC",
    "MPC_YAWRAUTO_MAX",
    "MPC_YAWRAUTO_ACC",
    "NAV_ACC_RAD",
    "NAV_MC_ALT_RAD",
    "MC_ROLL_P",
    "MPC_Z_VEL_MAX_UP",
    "MPC_Z_VEL_MAX_DN",
    "MPC_THR_HOVER",
)


@dataclass(frozen=True)
class Px4Limits:
    """What moves a PX4 multicopter along a mission: m, s, m/s, m/s^2, m/s^3, rad."""

    cruise: float
    most_speed: float
    corner_gain: float
    most_error: float
    accel: float
    jerk: float
    climb: float
    descent: float
    most_climb: float
    most_descent: float
    accel_up: float
    accel_down: float
    radius: float
    height_radius: float
    p_xy: float
    p_v: float
    i_v: float
    d_v: float
    p_z: float
    p_vz: float
    i_vz: float
    hover_learning: float
    lean: float
    lean_lag: float
    spool_up: float
    takeoff_speed: float
    takeoff_ramp: float
    land_speed: float
    land_high: float
    land_low: float
    crawl_below: float
    crawl_speed: float
    yaw_rate: float
    yaw_accel: float
    yaw_error: float
    turns_first: bool
    returning: Px4Return
    land_delay: float
    disarm_delay: float
    touchdown: Px4Touchdown


def px4_limits(parameters: Parameters) -> Px4Limits:
    """The limits that these parameters set; what is not given has PX4 1.17's default.

    Downwards the vertical controller may use a little more than the trajectory does (FlightTaskAuto: 1.2 times). What
    hovering takes is learned by a Kalman filter with a process noise of HTE_HT_NOISE a second and, as the flights are
    smooth, its least measurement noise, 1 m/s^2; so its time constant is hover / (noise g).

    Raises:
        BadInput: a parameter that must be positive is not.
    """
    p = {**PX4_DEFAULTS, **FURTHER, **parameters}
    for name in POSITIVE:
        if not p[name] > 0:
            raise BadInput(f"{name}: expected more than 0, not {p[name]:g}")
    climb = min(p["MPC_Z_V_AUTO_UP"], p["MPC_Z_VEL_MAX_UP"])
    descent = min(p["MPC_Z_V_AUTO_DN"], p["MPC_Z_VEL_MAX_DN"])
    learns = p["MPC_USE_HTE"] > 0 and p["HTE_HT_NOISE"] > 0
    return Px4Limits(
        cruise=p["MPC_XY_CRUISE"],
        most_speed=p["MPC_XY_VEL_MAX"],
        corner_gain=p["MPC_XY_TRAJ_P"],
        most_error=p["MPC_XY_ERR_MAX"],
        accel=p["MPC_ACC_HOR"],
        jerk=p["MPC_JERK_AUTO"],
        climb=climb,
        descent=descent,
        most_climb=p["MPC_Z_VEL_MAX_UP"],
        most_descent=max(p["MPC_Z_VEL_MAX_DN"], 1.2 * descent),
        accel_up=p["MPC_ACC_UP_MAX"],
        accel_down=p["MPC_ACC_DOWN_MAX"],
        radius=p["NAV_ACC_RAD"],
        height_radius=p["NAV_MC_ALT_RAD"],
        p_xy=p["MPC_XY_P"],
        p_v=p["MPC_XY_VEL_P_ACC"],
        i_v=p["MPC_XY_VEL_I_ACC"],
        d_v=p["MPC_XY_VEL_D_ACC"],
        p_z=p["MPC_Z_P"],
        p_vz=p["MPC_Z_VEL_P_ACC"],
        i_vz=p["MPC_Z_VEL_I_ACC"],
        hover_learning=p["MPC_THR_HOVER"] / (p["HTE_HT_NOISE"] * GRAVITY) if learns else math.inf,
        lean=math.radians(min(p["MPC_TILTMAX_AIR"], 80.0)),
        lean_lag=1 / p["MC_ROLL_P"],
        spool_up=p["COM_SPOOLUP_TIME"],
        takeoff_speed=min(p["MPC_TKO_SPEED"], p["MPC_Z_VEL_MAX_UP"]),
        takeoff_ramp=max(p["MPC_TKO_RAMP_T"], 0.1),
        land_speed=min(p["MPC_LAND_SPEED"], p["MPC_Z_VEL_MAX_DN"]),
        land_high=max(p["MPC_LAND_ALT1"], p["MPC_LAND_ALT2"]),
        land_low=p["MPC_LAND_ALT2"],
        crawl_below=p["MPC_LAND_ALT3"],
        crawl_speed=p["MPC_LAND_CRWL"],
        yaw_rate=math.radians(p["MPC_YAWRAUTO_MAX"]),
        yaw_accel=math.radians(p["MPC_YAWRAUTO_ACC"]),
        yaw_error=math.radians(p["MIS_YAW_ERR"]),
        turns_first=p["MPC_YAW_MODE"] == TURN_FIRST,
        returning=Px4Return.of(p),
        land_delay=max(p["RTL_LAND_DELAY"], 0.0),
        disarm_delay=max(p["COM_DISARM_LAND"], 0.0),
        touchdown=Px4Touchdown.of(p),
    )
