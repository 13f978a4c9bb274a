"""PX4's parameters: defaults (sensors, radio, modes, battery, failsafes as in SITL) and types."""

from collections.abc import Mapping

from ipoa_mission.autopilot.parameters import INT32, REAL32, Declared, Parameters, ParameterTable, Quantity, declared
from ipoa_mission.autopilot.version import Version

#: Since then the vertical setpoint has its own speed (1ae8f2383f), and a passed waypoint is not flown back to
#: (d0004403a3).
SPLITS_AXES = (1, 18)
MEASURED = (Version(1, 17), Version(1, 18, 0, "beta"))  # docs/lab/flown.md, px4-1.18.md
LEAST_HOLD = 0.1  # at which PX4 is to stop [s]
SINCE_SPLIT: Parameters = {"NAV_ACC_RAD": 10.0}  # c05cc47b75

#: PX4 1.17's for a multicopter (SI units, degrees); `rc.mc_defaults` has precedence over its reference.
DEFAULTS: Parameters = {
    "MPC_XY_CRUISE": 5.0,
    "MPC_XY_VEL_MAX": 12.0,
    "MPC_XY_TRAJ_P": 0.5,
    "MPC_XY_ERR_MAX": 2.0,
    "MPC_Z_ERR_MAX": 1.0,
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
    "RTL_RETURN_ALT": 30.0,
    "RTL_DESCEND_ALT": 10.0,
    "RTL_MIN_DIST": 10.0,
    "RTL_CONE_ANG": 45.0,
    "RTL_LAND_DELAY": 0.0,
    "RTL_TYPE": 0.0,
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
    "SIH_DISTSNSR_OVR": -1.0,
}

_STICKS = ("ROLL", "PITCH", "THROTTLE", "YAW")
_SWITCHES = ("FLTMODE", *(f"{one}_SW" for one in ("RETURN", "LOITER", "OFFB", "KILL", "ARM", "GEAR", "TRANS")))
_KNOBS = ("FLAPS", *(f"{one}{n}" for one in ("AUX", "PARAM") for n in (1, 2, 3)))

SET_UP: Mapping[str, Declared] = {
    "CAL_GYRO0_ID": (1_310_988.0, INT32),
    "CAL_ACC0_ID": (1_310_988.0, INT32),
    "CAL_MAG0_ID": (197_388.0, INT32),
    "CAL_MAG1_ID": (197_644.0, INT32),
    "CAL_MAG2_ID": (0.0, INT32),
    "SYS_AUTOCONFIG": (0.0, INT32),
    **{f"RC_MAP_{name}": (0.0, INT32) for name in (*_STICKS, *_SWITCHES, *_KNOBS)},
    **{f"COM_FLTMODE{n}": (-1.0, INT32) for n in range(1, 7)},
    "BAT1_N_CELLS": (4.0, INT32),
    "BAT1_V_EMPTY": (3.6, REAL32),
    "BAT1_V_CHARGED": (4.05, REAL32),
    "COM_RC_LOSS_T": (0.5, REAL32),
    "COM_LOW_BAT_ACT": (3.0, INT32),
    "NAV_RCL_ACT": (2.0, INT32),
}

STATION_PARAMETERS = {
    "MAV_SYS_ID": 1.0,
    "SYS_AUTOSTART": 4001.0,
    "GF_ACTION": 2.0,
    "GF_MAX_HOR_DIST": 0.0,
    "GF_MAX_VER_DIST": 0.0,
    "MIS_DIST_1WP": 10_000.0,
    "MIS_TAKEOFF_ALT": 2.5,
    "MIS_TKO_LAND_REQ": 0.0,
    "COM_DISARM_LAND": 2.0,
    "COM_DISARM_PRFLT": 10.0,
    "COM_RC_IN_MODE": 1.0,
    "NAV_DLL_ACT": 0.0,
}

TYPES = declared(
    {
        INT32: "MPC_YAW_MODE MPC_USE_HTE RTL_CONE_ANG MAV_SYS_ID SYS_AUTOSTART GF_ACTION MIS_TKO_LAND_REQ "
        "COM_RC_IN_MODE NAV_DLL_ACT"
    }
)

MEANINGS = {
    "cruise speed": "MPC_XY_CRUISE",
    "climb speed": "MPC_Z_V_AUTO_UP",
    "descent speed": "MPC_Z_V_AUTO_DN",
    "acceleration": "MPC_ACC_HOR",
    "vertical acceleration": "MPC_ACC_UP_MAX",
    "jerk": "MPC_JERK_AUTO",
    "acceptance radius": "NAV_ACC_RAD",
    "heading": "MPC_YAW_MODE",
    "yaw rate": "MPC_YAWRAUTO_MAX",
    "lean": "MPC_TILTMAX_AIR",
    "landing speed": "MPC_LAND_SPEED",
    "height of slow landing": "MPC_LAND_ALT2",
    "return height": "RTL_RETURN_ALT",
    "height at the end of a return": "RTL_DESCEND_ALT",
    "wait before landing": "RTL_LAND_DELAY",
    "return cone": "RTL_CONE_ANG",
    "spool-up": "COM_SPOOLUP_TIME",
    "disarming": "COM_DISARM_LAND",
    "position P": "MPC_XY_P",
    "velocity P": "MPC_XY_VEL_P_ACC",
    "velocity I": "MPC_XY_VEL_I_ACC",
    "velocity D": "MPC_XY_VEL_D_ACC",
    "height P": "MPC_Z_P",
    "fence switch": "GF_ACTION",
    "system id": "MAV_SYS_ID",
}

UNITS = dict.fromkeys(
    (
        *("MPC_XY_CRUISE", "MPC_Z_V_AUTO_UP", "MPC_Z_V_AUTO_DN", "MPC_ACC_HOR", "MPC_ACC_UP_MAX"),
        *("NAV_ACC_RAD", "MPC_TILTMAX_AIR", "MPC_LAND_SPEED", "RTL_RETURN_ALT", "RTL_LAND_DELAY"),
    ),
    1.0,
)

PARAMETER_TABLE = ParameterTable(
    moving=DEFAULTS,
    others=STATION_PARAMETERS,
    set_up=SET_UP,
    types=TYPES,
    climb=Quantity("MPC_Z_V_AUTO_UP"),
    descent=Quantity("MPC_Z_V_AUTO_DN"),
    return_height=Quantity("RTL_RETURN_ALT"),
    fence_switch="GF_ACTION",
    system_id="MAV_SYS_ID",
    meanings=MEANINGS,
    units=UNITS,
    surely_there=(("MAV_SYS_ID",), ("SYS_AUTOSTART",)),
    packs_integers=True,
    speed=Quantity("MPC_XY_VEL_MAX"),
)
