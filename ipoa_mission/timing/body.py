"""The multirotor that ArduCopter's model flies: what drag it has, how quickly it answers.

No mission and no autopilot parameter tells these, and every airframe has its own; the values here are those of its
simulator's quadrotor, read from the recorded flights (see docs/flight-time.md). Below about 8 m/s drag hardly
matters; near the speed where it meets the greatest lean it decides.
"""

import math
from dataclasses import dataclass

GRAVITY = 9.80665  # [m/s^2]


@dataclass(frozen=True)
class Body:
    """Drag per mass along the leaning body: (linear + quadratic v) v [1/s, 1/m]; `lag` [s] of rotors and rate loop."""

    linear_drag: float
    quadratic_drag: float
    lag: float

    def top_speed(self, lean: float) -> float:
        """The level speed [m/s] at which drag meets what a lean [rad] gives in calm air.

        It solves (linear + q v) v = g tan(lean). Of the level speed v the leaning body meets v cos(lean), so q is the
        quadratic drag times that.
        """
        pull, q = GRAVITY * math.tan(lean), self.quadratic_drag * math.cos(lean)
        if self.linear_drag <= 0 and q <= 0:
            return math.inf
        return 2 * pull / (self.linear_drag + math.sqrt(self.linear_drag**2 + 4 * q * pull))


#: ArduPilot's built-in quadrotor: at 30 degrees of lean its drag allows 10.0 m/s level.
ARDUPILOT_SIMULATOR = Body(linear_drag=0.30, quadratic_drag=0.0306, lag=0.02)
