"""PX4's parameters, and the motion limits, return height and land detector that they set.

Defaults of sensors, radio, modes, battery and failsafes are as in SITL. Limits: docs/lab/flight-time.md.
"""

import math
from typing import Annotated, NamedTuple, TypeVar

from ipoa_mission.autopilot.parameters import INT32, Parameter, Parameters, ParameterTable, parameters_of_fields
from ipoa_mission.autopilot.version import Version
from ipoa_mission.geometry import GRAVITY, Vector

#: Since then the vertical setpoint has its own speed (1ae8f2383f), and a passed waypoint is not flown back to
#: (d0004403a3).
DECOUPLED_SINCE = (1, 18)
MEASURED = (Version(1, 17), Version(1, 18, 0, "beta"))  # docs/lab/flown.md, px4-1.18.md
DECOUPLED_DEFAULTS: Parameters = {"NAV_ACC_RAD": 10.0}  # c05cc47b75

#: PX4 1.17's for a multicopter (SI units, degrees); `rc.mc_defaults` has precedence over its reference.
AFFECTING = (
    Parameter("MPC_XY_CRUISE", 5.0, meaning="cruise speed", positive=True),
    Parameter("MPC_XY_VEL_MAX", 12.0, positive=True),
    Parameter("MPC_XY_TRAJ_P", 0.5, positive=True),
    Parameter("MPC_XY_ERR_MAX", 2.0, positive=True),
    Parameter("MPC_Z_ERR_MAX", 1.0),
    Parameter("MPC_XY_P", 0.95, meaning="position P", positive=True),
    Parameter("MPC_ACC_HOR", 3.0, meaning="acceleration", positive=True),
    Parameter("MPC_ACC_HOR_MAX", 5.0),
    Parameter("MPC_JERK_AUTO", 4.0, meaning="jerk", positive=True),
    Parameter("MPC_Z_P", 1.0, meaning="height P"),
    Parameter("MPC_Z_V_AUTO_UP", 3.0, meaning="climb speed", positive=True),
    Parameter("MPC_Z_V_AUTO_DN", 1.5, meaning="descent speed", positive=True),
    Parameter("MPC_ACC_UP_MAX", 4.0, meaning="vertical acceleration", positive=True),
    Parameter("MPC_ACC_DOWN_MAX", 3.0, positive=True),
    Parameter("MPC_TKO_SPEED", 1.5, positive=True),
    Parameter("MPC_TKO_RAMP_T", 3.0),
    Parameter("MPC_LAND_SPEED", 0.7, meaning="landing speed", positive=True),
    Parameter("MPC_LAND_ALT1", 10.0),
    Parameter("MPC_LAND_ALT2", 5.0, meaning="height of slow landing"),
    Parameter("MPC_YAW_MODE", 0.0, INT32, meaning="heading"),
    Parameter("MPC_YAWRAUTO_MAX", 60.0, meaning="yaw rate", positive=True),
    Parameter("MPC_YAWRAUTO_ACC", 20.0, positive=True),
    Parameter("NAV_ACC_RAD", 2.0, meaning="acceptance radius", positive=True),
    Parameter("NAV_MC_ALT_RAD", 0.8, positive=True),
    Parameter("COM_SPOOLUP_TIME", 1.0, meaning="spool-up"),
    Parameter("RTL_RETURN_ALT", 30.0, meaning="return height"),
    Parameter("RTL_DESCEND_ALT", 10.0, meaning="height after a return"),
    Parameter("RTL_MIN_DIST", 10.0),
    Parameter("RTL_CONE_ANG", 45.0, INT32, meaning="return cone"),
    Parameter("RTL_LAND_DELAY", 0.0, meaning="wait before landing"),
    Parameter("RTL_TYPE", 0.0, INT32),
    Parameter("MPC_XY_VEL_P_ACC", 1.8, meaning="velocity P", positive=True),
    Parameter("MPC_XY_VEL_I_ACC", 0.4, meaning="velocity I"),
    Parameter("MPC_XY_VEL_D_ACC", 0.2, meaning="velocity D"),
    Parameter("MPC_Z_VEL_P_ACC", 4.0),
    Parameter("MPC_Z_VEL_I_ACC", 2.0),
    Parameter("MPC_Z_VEL_MAX_UP", 3.0, positive=True),
    Parameter("MPC_Z_VEL_MAX_DN", 1.5, positive=True),
    Parameter("MPC_TILTMAX_AIR", 45.0, meaning="tilt", positive=True),
    Parameter("MPC_THR_HOVER", 0.5, positive=True),
    Parameter("MPC_USE_HTE", 1.0, INT32),
    Parameter("HTE_HT_NOISE", 0.0036),
    Parameter("MC_ROLL_P", 6.5, positive=True),
    Parameter("MIS_YAW_ERR", 12.0),
    Parameter("COM_DISARM_LAND", 2.0, meaning="disarming"),
    Parameter("MPC_LAND_ALT3", 1.0),
    Parameter("MPC_LAND_CRWL", 0.3, positive=True),
    Parameter("MPC_THR_MIN", 0.12),
    Parameter("LNDMC_TRIG_TIME", 1.0),
    Parameter("LNDMC_Z_VEL_MAX", 0.25),
    Parameter("SIH_DISTSNSR_OVR", -1.0),
)
#: Of failsafes; only their type is known.
_TYPED = (
    "CBRK_FLIGHTTERM", "COM_ACT_FAIL_ACT", "COM_ARM_CHK_ESCS", "COM_ARM_ODID", "COM_DLL_EXCEPT", "COM_DL_LOSS_T",
    "COM_FLTT_LOW_ACT", "COM_FLT_TIME_MAX", "COM_GNSSLOSS_ACT", "COM_IMB_PROP_ACT", "COM_PARACHUTE", "COM_POS_FS_ACT",
    "COM_POS_LOW_ACT", "COM_RCL_EXCEPT", "COM_TRAFF_AVOID", "COM_WIND_MAX_ACT", "FD_ACT_EN", "NAV_TRAFF_AVOID",
    "SYS_HAS_NUM_GNSS",
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
    *(Parameter(name, None, INT32) for name in _TYPED),
)

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
    surely_there=(("MAV_SYS_ID",), ("SYS_AUTOSTART",)),
    packs_integers=True,
    limits_speed="MPC_XY_VEL_MAX",
)

RANGE_LAG_S = 0.14  # of the height over the ground by a range finder [s]
NO_RANGE_FINDER = 10_000.0  # SIH_DISTSNSR_OVR of a vehicle without one [m]
RELAXED_THRUST = 0.6  # low thrust, from least to hover thrust, if that is learned
BRAKES_LATE = 0.6  # from the order of LAND or hold to braking, as flown [s]
LEAST_HOLD = 0.1  # at which PX4 is to stop [s]
STAGES = 3  # contact, maybe landed, landed

TURN_FIRST = 4.0  # MPC_YAW_MODE: yaw first

Speed = TypeVar("Speed", float, Vector)


class Px4Return(NamedTuple):
    altitude: float  # RTL_RETURN_ALT [m]
    least_distance: float  # RTL_MIN_DIST
    radius: float  # NAV_ACC_RAD
    cone_deg: float  # RTL_CONE_ANG

    @classmethod
    def of(cls, parameters: Parameters) -> "Px4Return":
        """Return the law of complete `parameters`."""
        return cls(*(parameters[name] for name in ("RTL_RETURN_ALT", "RTL_MIN_DIST", "NAV_ACC_RAD", "RTL_CONE_ANG")))

    def height(self, above: float, distance: float) -> float:
        """Return the return height above the goal [m] at a horizontal `distance` [m].

        It is RTL_RETURN_ALT. Within RTL_MIN_DIST RTL_CONE_ANG lowers it, to two NAV_ACC_RAD; within NAV_ACC_RAD to
        twice the distance. It never descends for that.
        """
        if self.cone_deg <= 0.0:
            return max(above, self.altitude)
        if distance <= self.radius:
            return max(above, min(2.0 * distance, self.altitude))
        top = self.altitude
        if distance <= self.least_distance:
            top = distance / math.tan(math.radians(min(max(self.cone_deg, 1.0), 89.0)))
        return max(above, min(max(top, 2.0 * self.radius), self.altitude))


class Px4Limits(NamedTuple):
    """Motion limits in m, s, rad; gains in 1/s."""

    cruise: Annotated[float, "MPC_XY_CRUISE"]
    max_speed: Annotated[float, "MPC_XY_VEL_MAX"]
    corner_gain: Annotated[float, "MPC_XY_TRAJ_P"]
    max_lag: Annotated[float, "MPC_XY_ERR_MAX"]
    accel: Annotated[float, "MPC_ACC_HOR"]
    jerk: Annotated[float, "MPC_JERK_AUTO"]
    climb: float
    descent: float
    max_climb: Annotated[float, "MPC_Z_VEL_MAX_UP"]
    max_descent: float
    accel_up: Annotated[float, "MPC_ACC_UP_MAX"]
    accel_down: Annotated[float, "MPC_ACC_DOWN_MAX"]
    radius: Annotated[float, "NAV_ACC_RAD"]
    height_radius: Annotated[float, "NAV_MC_ALT_RAD"]
    p_position: Annotated[float, "MPC_XY_P"]
    p_velocity: Annotated[float, "MPC_XY_VEL_P_ACC"]
    i_velocity: Annotated[float, "MPC_XY_VEL_I_ACC"]
    d_velocity: Annotated[float, "MPC_XY_VEL_D_ACC"]
    p_height: Annotated[float, "MPC_Z_P"]
    p_climb: Annotated[float, "MPC_Z_VEL_P_ACC"]
    i_climb: Annotated[float, "MPC_Z_VEL_I_ACC"]
    hover_learning: float  # time constant
    max_tilt: float
    tilt_lag: float  # time constant
    spool_up: Annotated[float, "COM_SPOOLUP_TIME"]
    takeoff_speed: float
    takeoff_ramp: float
    land_speed: float
    land_high: float
    land_low: Annotated[float, "MPC_LAND_ALT2"]
    sinks_from: Annotated[float, "MPC_Z_VEL_MAX_DN"]  # LAND slows down from it, perhaps above its descent rate
    crawl_below: Annotated[float, "MPC_LAND_ALT3"]
    crawl_speed: Annotated[float, "MPC_LAND_CRWL"]
    yaw_rate: float
    yaw_accel: float
    yaw_error: float
    turns_first: bool
    returning: Px4Return
    land_delay: Annotated[float, "RTL_LAND_DELAY"]
    land_delay_height: Annotated[float, "RTL_DESCEND_ALT"]
    disarm_delay: float
    land_detector_s: Annotated[float, "LNDMC_TRIG_TIME"]  # of all STAGES; of each if the range finder lost the ground
    max_touchdown: float
    low_thrust: float  # over hover thrust
    has_range_finder: bool
    decoupled_axes: bool  # the vertical setpoint waits separately, and no passed item is flown back to
    max_height_error: Annotated[float, "MPC_Z_ERR_MAX"]

    def stopping_time(self, speed: Speed) -> Speed:
        """Return how long `speed` [m/s] takes to the stopping point of LAND and hold [s] (preproject_stop_point)."""
        return speed / (2.0 * self.accel) + BRAKES_LATE


FIELDS = parameters_of_fields(Px4Limits)


def px4_limits(parameters: Parameters, version: Version | None = None) -> Px4Limits:
    """Return the limits of these parameters and a version's defaults.

    Descents use up to 1.2 times the trajectory's speed (FlightTaskAuto). A Kalman filter learns hover thrust with
    process noise HTE_HT_NOISE. Its measurement noise is 1 m/s^2, so its time constant is hover / (noise g).

    Raises:
        BadInput: a parameter that must be positive is not.
    """
    decoupled = (version or MEASURED[-1]).series >= DECOUPLED_SINCE
    p = {**PARAMETER_TABLE.moving, **(DECOUPLED_DEFAULTS if decoupled else {}), **parameters}
    if decoupled:  # 1.18 has neither (62f5f5267e, 0d66981dcc)
        p |= {name: PARAMETER_TABLE.moving[name] for name in ("LNDMC_TRIG_TIME", "MPC_USE_HTE")}
    PARAMETER_TABLE.expect_positive(p)
    climb = min(p["MPC_Z_V_AUTO_UP"], p["MPC_Z_VEL_MAX_UP"])
    descent = min(p["MPC_Z_V_AUTO_DN"], p["MPC_Z_VEL_MAX_DN"])
    least_thrust = p["MPC_THR_MIN"] / p["MPC_THR_HOVER"]
    learns = p["MPC_USE_HTE"] > 0 and p["HTE_HT_NOISE"] > 0
    return Px4Limits(
        **{field: p[name] for field, name in FIELDS.items()},
        climb=climb,
        descent=descent,
        max_descent=max(p["MPC_Z_VEL_MAX_DN"], 1.2 * descent),
        hover_learning=p["MPC_THR_HOVER"] / (p["HTE_HT_NOISE"] * GRAVITY) if learns else math.inf,
        max_tilt=math.radians(min(p["MPC_TILTMAX_AIR"], 80.0)),
        tilt_lag=1 / p["MC_ROLL_P"],
        takeoff_speed=min(p["MPC_TKO_SPEED"], p["MPC_Z_VEL_MAX_UP"]),
        takeoff_ramp=max(p["MPC_TKO_RAMP_T"], 0.1),
        land_speed=min(p["MPC_LAND_SPEED"], p["MPC_Z_VEL_MAX_DN"]),
        land_high=max(p["MPC_LAND_ALT1"], p["MPC_LAND_ALT2"]),
        yaw_rate=math.radians(p["MPC_YAWRAUTO_MAX"]),
        yaw_accel=math.radians(p["MPC_YAWRAUTO_ACC"]),
        yaw_error=math.radians(p["MIS_YAW_ERR"]),
        turns_first=p["MPC_YAW_MODE"] == TURN_FIRST,
        returning=Px4Return.of(p),
        disarm_delay=max(p["COM_DISARM_LAND"], 0.0),
        max_touchdown=min(p["LNDMC_Z_VEL_MAX"], min(p["MPC_LAND_SPEED"], p["MPC_LAND_CRWL"]) / 1.2),
        low_thrust=least_thrust + RELAXED_THRUST * (1.0 - least_thrust),
        has_range_finder=abs(p["SIH_DISTSNSR_OVR"]) < NO_RANGE_FINDER,
        decoupled_axes=decoupled,
    )
