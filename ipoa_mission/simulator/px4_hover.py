"""The thrust that PX4 believes to hover by: a Kalman filter of one state, which takes drag in a climb for weight.

State r: believed over true hover thrust. A thrust of T m/s^2 is expected to accelerate upwards by T/r - g; what is
measured instead corrects r. The filter forgets over sqrt(R) / (noise g / r^2) seconds, some twenty. After a climb r is
too great; then thrust lies below what PX4 thinks it needs to hover, and its anti-windup takes the shortfall for a limit
and holds the level integrator back: the first legs after a take-off are flown slower.
"""

from ipoa_mission.autopilots.vehicle import Parameters
from ipoa_mission.simulator.body import GRAVITY

ACCELERATION_VARIANCE = 1.0  # R: the least that the filter allows itself [m^2/s^4]


class HoverThrust:
    """`ratio`: r."""

    def __init__(self, parameters: Parameters, most_thrust: float) -> None:
        hover = GRAVITY / most_thrust  # as a share of full thrust
        self.ratio = parameters.get("MPC_THR_HOVER", 0.5) / hover
        self._variance = (parameters.get("HTE_HT_ERR_INIT", 0.1) / hover) ** 2
        self._noise = parameters.get("HTE_HT_NOISE", 0.0036) / hover  # [1/s]
        self._calm = parameters.get("HTE_VZ_THR", 2.0)  # above this climb rate it trusts less what it measures

    def learn(self, thrust: float, acceleration: float, climb: float, dt: float) -> None:
        """From a vertical thrust and the vertical acceleration that came of it [m/s^2], at a climb rate [m/s]."""
        self._variance += (self._noise * dt) ** 2
        slope = -thrust / self.ratio**2
        noise = ACCELERATION_VARIANCE * max(abs(climb) / self._calm, 1.0) ** 2
        gain = self._variance * slope / (noise + slope * slope * self._variance)
        self.ratio += gain * (acceleration - (thrust / self.ratio - GRAVITY))
        self.ratio = min(max(self.ratio, 0.2), 1.8)
        self._variance *= 1.0 - gain * slope
