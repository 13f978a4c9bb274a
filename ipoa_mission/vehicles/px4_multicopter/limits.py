"""PX4's motion limits, return height and land detector, by its parameters (docs/lab/flight-time.md)."""

import math
from typing import Annotated, NamedTuple, TypeVar

from ipoa_mission.autopilot.parameters import Parameters, parameters_of_fields
from ipoa_mission.autopilot.version import Version
from ipoa_mission.geometry import GRAVITY, Vector
from ipoa_mission.vehicles.px4_multicopter.parameter_table import MEASURED, PARAMETER_TABLE, SINCE_SPLIT, SPLITS_AXES

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
        names = ("RTL_RETURN_ALT", "RTL_MIN_DIST", "NAV_ACC_RAD", "RTL_CONE_ANG")
        return cls(*(parameters.get(name, PARAMETER_TABLE.moving[name]) for name in names))

    def height(self, above: float, distance: float) -> float:
        """Return the return height above the goal [m] at a level `distance` [m].

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
    most_speed: Annotated[float, "MPC_XY_VEL_MAX"]
    corner_gain: Annotated[float, "MPC_XY_TRAJ_P"]
    most_lag: Annotated[float, "MPC_XY_ERR_MAX"]
    accel: Annotated[float, "MPC_ACC_HOR"]
    jerk: Annotated[float, "MPC_JERK_AUTO"]
    climb: float
    descent: float
    most_climb: Annotated[float, "MPC_Z_VEL_MAX_UP"]
    most_descent: float
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
    lean: float
    lean_lag: float  # time constant
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
    most_touchdown: float
    low_thrust: float  # over hover thrust
    has_range_finder: bool
    splits_axes: bool  # the vertical setpoint waits separately, and no passed item is flown back to
    most_height_error: Annotated[float, "MPC_Z_ERR_MAX"]

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
    splits = (version or MEASURED[-1]).series >= SPLITS_AXES
    p = {**PARAMETER_TABLE.moving, **(SINCE_SPLIT if splits else {}), **parameters}
    PARAMETER_TABLE.expect_positive(p)
    climb = min(p["MPC_Z_V_AUTO_UP"], p["MPC_Z_VEL_MAX_UP"])
    descent = min(p["MPC_Z_V_AUTO_DN"], p["MPC_Z_VEL_MAX_DN"])
    least_thrust = p["MPC_THR_MIN"] / p["MPC_THR_HOVER"]
    learns = p["MPC_USE_HTE"] > 0 and p["HTE_HT_NOISE"] > 0
    return Px4Limits(
        **{field: p[name] for field, name in FIELDS.items()},
        climb=climb,
        descent=descent,
        most_descent=max(p["MPC_Z_VEL_MAX_DN"], 1.2 * descent),
        hover_learning=p["MPC_THR_HOVER"] / (p["HTE_HT_NOISE"] * GRAVITY) if learns else math.inf,
        lean=math.radians(min(p["MPC_TILTMAX_AIR"], 80.0)),
        lean_lag=1 / p["MC_ROLL_P"],
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
        most_touchdown=min(p["LNDMC_Z_VEL_MAX"], min(p["MPC_LAND_SPEED"], p["MPC_LAND_CRWL"]) / 1.2),
        low_thrust=least_thrust + RELAXED_THRUST * (1.0 - least_thrust),
        has_range_finder=abs(p["SIH_DISTSNSR_OVR"]) < NO_RANGE_FINDER,
        splits_axes=splits,
    )
