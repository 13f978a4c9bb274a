"""How the autopilots leave the ground and know that they are back on it: facts that both models of each share.

Read from the autopilots' land detectors and measured on their simulated flights; docs/flight-time.md says which.
"""

from collections.abc import Mapping
from dataclasses import dataclass

# --- ArduCopter -------------------------------------------------------------------------------------------------------
ARMING_DELAY_S = 2.0  # motors stand still for so long after arming, whatever the mode
LIFT_S = 0.2  # from motors at full spin until the thrust carries the vehicle
THROTTLE_DOWN_S = 0.58  # from touching down until the throttle is at its least
LAND_DETECTOR_S = 1.0  # for so long it must stay there, before the motors spool down and the vehicle disarms
CENTIMETRE = 0.01  # in which ArduCopter keeps the height of a place [m]

# --- PX4 --------------------------------------------------------------------------------------------------------------
RANGE_LAG_S = 0.14  # by which PX4's height over the ground lags behind a range finder that is sinking
RELAXED_THRUST = 0.6  # of the way from the least thrust to that of hovering: less is low, where hovering is learned
STAGES = 3  # of being sure: in contact, perhaps landed, landed


@dataclass(frozen=True)
class Px4Touchdown:
    """When PX4 takes standing for being landed: LNDMC_TRIG_TIME [s], LNDMC_Z_VEL_MAX [m/s], low thrust.

    `low_thrust` is the share of the thrust of hovering that the thrust asked for has to fall below.
    """

    trigger_s: float
    most_speed: float
    low_thrust: float

    @classmethod
    def of(cls, parameters: Mapping[str, float]) -> "Px4Touchdown":
        """By these parameters; what is not given has PX4's default."""
        least = parameters.get("MPC_THR_MIN", 0.12) / parameters.get("MPC_THR_HOVER", 0.5)
        speed = min(parameters.get("MPC_LAND_SPEED", 0.7), parameters.get("MPC_LAND_CRWL", 0.3)) / 1.2
        return cls(
            parameters.get("LNDMC_TRIG_TIME", 1.0),
            min(parameters.get("LNDMC_Z_VEL_MAX", 0.25), speed),
            least + RELAXED_THRUST * (1.0 - least),
        )

    def stage_s(self, ground_lost: bool) -> float:
        """How long each of the stages takes; three times as long where a range finder has lost the ground."""
        return self.trigger_s * (STAGES if ground_lost else 1) / STAGES
