"""PX4's parameters: defaults (sensors, radio, modes, battery, failsafes as in SITL) and types."""

from ipoa_mission.autopilot.parameters import INT32, Parameter, Parameters, ParameterTable
from ipoa_mission.autopilot.version import Version

#: Since then the vertical setpoint has its own speed (1ae8f2383f), and a passed waypoint is not flown back to
#: (d0004403a3).
SPLITS_AXES = (1, 18)
MEASURED = (Version(1, 17), Version(1, 18, 0, "beta"))  # docs/lab/flown.md, px4-1.18.md
SINCE_SPLIT: Parameters = {"NAV_ACC_RAD": 10.0}  # c05cc47b75

#: PX4 1.17's for a multicopter (SI units, degrees); `rc.mc_defaults` has precedence over its reference.
AFFECTING = (
    Parameter("MPC_XY_CRUISE", 5.0, meaning="cruise speed"),
    Parameter("MPC_XY_VEL_MAX", 12.0),
    Parameter("MPC_XY_TRAJ_P", 0.5),
    Parameter("MPC_XY_ERR_MAX", 2.0),
    Parameter("MPC_Z_ERR_MAX", 1.0),
    Parameter("MPC_XY_P", 0.95, meaning="position P"),
    Parameter("MPC_ACC_HOR", 3.0, meaning="acceleration"),
    Parameter("MPC_ACC_HOR_MAX", 5.0),
    Parameter("MPC_JERK_AUTO", 4.0, meaning="jerk"),
    Parameter("MPC_Z_P", 1.0, meaning="height P"),
    Parameter("MPC_Z_V_AUTO_UP", 3.0, meaning="climb speed"),
    Parameter("MPC_Z_V_AUTO_DN", 1.5, meaning="descent speed"),
    Parameter("MPC_ACC_UP_MAX", 4.0, meaning="vertical acceleration"),
    Parameter("MPC_ACC_DOWN_MAX", 3.0),
    Parameter("MPC_TKO_SPEED", 1.5),
    Parameter("MPC_TKO_RAMP_T", 3.0),
    Parameter("MPC_LAND_SPEED", 0.7, meaning="landing speed"),
    Parameter("MPC_LAND_ALT1", 10.0),
    Parameter("MPC_LAND_ALT2", 5.0, meaning="height of slow landing"),
    Parameter("MPC_YAW_MODE", 0.0, INT32, meaning="heading"),
    Parameter("MPC_YAWRAUTO_MAX", 60.0, meaning="yaw rate"),
    Parameter("MPC_YAWRAUTO_ACC", 20.0),
    Parameter("NAV_ACC_RAD", 2.0, meaning="acceptance radius"),
    Parameter("NAV_MC_ALT_RAD", 0.8),
    Parameter("COM_SPOOLUP_TIME", 1.0, meaning="spool-up"),
    Parameter("RTL_RETURN_ALT", 30.0, meaning="return height"),
    Parameter("RTL_DESCEND_ALT", 10.0, meaning="height after a return"),
    Parameter("RTL_MIN_DIST", 10.0),
    Parameter("RTL_CONE_ANG", 45.0, INT32, meaning="return cone"),
    Parameter("RTL_LAND_DELAY", 0.0, meaning="wait before landing"),
    Parameter("RTL_TYPE", 0.0, INT32),
    Parameter("MPC_XY_VEL_P_ACC", 1.8, meaning="velocity P"),
    Parameter("MPC_XY_VEL_I_ACC", 0.4, meaning="velocity I"),
    Parameter("MPC_XY_VEL_D_ACC", 0.2, meaning="velocity D"),
    Parameter("MPC_Z_VEL_P_ACC", 4.0),
    Parameter("MPC_Z_VEL_I_ACC", 2.0),
    Parameter("MPC_Z_VEL_MAX_UP", 3.0),
    Parameter("MPC_Z_VEL_MAX_DN", 1.5),
    Parameter("MPC_TILTMAX_AIR", 45.0, meaning="lean"),
    Parameter("MPC_THR_HOVER", 0.5),
    Parameter("MPC_USE_HTE", 1.0, INT32),
    Parameter("HTE_HT_NOISE", 0.0036),
    Parameter("MC_ROLL_P", 4.0),
    Parameter("MIS_YAW_ERR", 12.0),
    Parameter("COM_DISARM_LAND", 2.0, meaning="disarming"),
    Parameter("MPC_LAND_ALT3", 1.0),
    Parameter("MPC_LAND_CRWL", 0.3),
    Parameter("MPC_THR_MIN", 0.12),
    Parameter("LNDMC_TRIG_TIME", 1.0),
    Parameter("LNDMC_Z_VEL_MAX", 0.25),
    Parameter("SIH_DISTSNSR_OVR", -1.0),
)
_WHOLE = (
    "CBRK_FLIGHTTERM", "COM_ACT_FAIL_ACT", "COM_ARM_ODID", "COM_DLL_EXCEPT", "COM_DL_LOSS_T", "COM_FLTT_LOW_ACT",
    "COM_FLT_TIME_MAX", "COM_GNSSLOSS_ACT", "COM_IMB_PROP_ACT", "COM_PARACHUTE", "COM_POS_FS_ACT", "COM_POS_LOW_ACT",
    "COM_RCL_EXCEPT", "COM_TRAFF_AVOID", "COM_WIND_MAX_ACT", "NAV_TRAFF_AVOID", "SYS_HAS_NUM_GNSS",
)  # fmt: skip
FURTHER = (
    Parameter("MAV_SYS_ID", 1.0, INT32, meaning="system id"),
    Parameter("SYS_AUTOSTART", 4001.0, INT32),
    Parameter("GF_ACTION", 2.0, INT32, meaning="fence switch"),
    Parameter("GF_MAX_HOR_DIST", 0.0),
    Parameter("GF_MAX_VER_DIST", 0.0),
    Parameter("MIS_DIST_1WP", 10_000.0),
    Parameter("MIS_TAKEOFF_ALT", 2.5),
    Parameter("MIS_TKO_LAND_REQ", 0.0, INT32),
    Parameter("COM_DISARM_PRFLT", 10.0),
    Parameter("COM_RC_IN_MODE", 1.0, INT32),
    Parameter("NAV_DLL_ACT", 0.0, INT32),
    *(Parameter(name, None, INT32) for name in _WHOLE),
)

POSITIVE = (
    "MPC_XY_CRUISE", "MPC_XY_VEL_MAX", "MPC_XY_TRAJ_P", "MPC_XY_ERR_MAX", "MPC_XY_P", "MPC_ACC_HOR", "MPC_JERK_AUTO",
    "MPC_Z_V_AUTO_UP", "MPC_Z_V_AUTO_DN", "MPC_ACC_UP_MAX", "MPC_ACC_DOWN_MAX", "MPC_TKO_SPEED", "MPC_LAND_SPEED",
    "MPC_LAND_CRWL", "MPC_XY_VEL_P_ACC", "MPC_YAWRAUTO_MAX", "MPC_YAWRAUTO_ACC", "NAV_ACC_RAD", "NAV_MC_ALT_RAD",
    "MC_ROLL_P", "MPC_Z_VEL_MAX_UP", "MPC_Z_VEL_MAX_DN", "MPC_THR_HOVER",
)  # fmt: skip
_INPUTS = (
    "ROLL", "PITCH", "THROTTLE", "YAW", "FLTMODE", "RETURN_SW", "LOITER_SW", "OFFB_SW", "KILL_SW", "ARM_SW", "GEAR_SW",
    "TRANS_SW", "FLAPS", "AUX1", "AUX2", "AUX3", "PARAM1", "PARAM2", "PARAM3",
)  # fmt: skip
PARAMETER_TABLE = ParameterTable(
    affecting=AFFECTING,
    further=FURTHER,
    set_up=(
        Parameter("CAL_GYRO0_ID", 1_310_988.0, INT32),
        Parameter("CAL_ACC0_ID", 1_310_988.0, INT32),
        Parameter("CAL_MAG0_ID", 197_388.0, INT32),
        Parameter("CAL_MAG1_ID", 197_644.0, INT32),
        Parameter("CAL_MAG2_ID", 0.0, INT32),
        Parameter("SYS_AUTOCONFIG", 0.0, INT32),
        *(Parameter(f"RC_MAP_{name}", 0.0, INT32) for name in _INPUTS),
        *(Parameter(f"COM_FLTMODE{n}", -1.0, INT32) for n in range(1, 7)),
        Parameter("BAT1_N_CELLS", 4.0, INT32),
        Parameter("BAT1_V_EMPTY", 3.6),
        Parameter("BAT1_V_CHARGED", 4.05),
        Parameter("COM_RC_LOSS_T", 0.5),
        Parameter("COM_LOW_BAT_ACT", 3.0, INT32),
        Parameter("NAV_RCL_ACT", 2.0, INT32),
    ),
    positive=POSITIVE,
    surely_there=(("MAV_SYS_ID",), ("SYS_AUTOSTART",)),
    packs_integers=True,
    limits_speed="MPC_XY_VEL_MAX",
)
