"""The multirotors that the models fly: what drag they have, how quickly they answer, how well they know where they are.

No mission and no autopilot parameter tells these, and every airframe has its own; the values here are those of the
two simulators' quadrotors, read from the recorded flights (see docs/flight-time.md). Below about 8 m/s drag hardly
matters; near the speed where it meets the greatest lean it decides.
"""

import math
from dataclasses import dataclass

GRAVITY = 9.80665  # [m/s^2]


@dataclass(frozen=True)
class Senses:
    """How well a vehicle knows where it is, as far as its guidance notices.

    A satellite height comes every `every` s with a standard deviation of `height_noise` m. The speed that is estimated
    does not quite agree with how the estimated place moves: by `drift` m/s level, along each axis, and `drift_up`
    upwards (standard deviations), for about `drift_lasts` s. One that `sees_ground`, by a range finder, crawls to it.
    """

    every: float
    height_noise: float
    drift: float
    drift_up: float
    drift_lasts: float
    sees_ground: bool


@dataclass(frozen=True)
class Body:
    """Drag per mass along the leaning body: (linear + quadratic v) v [1/s, 1/m]; `lag` [s] of rotors and rate loop.

    With `senses` a model may fly several times, each time with other noise; without, it knows everything exactly.
    """

    linear_drag: float
    quadratic_drag: float
    lag: float
    senses: Senses | None = None

    def top_speed(self, lean: float) -> float:
        """The level speed [m/s] at which drag meets what a lean [rad] gives in calm air.

        It solves (linear + q v) v = g tan(lean). Of the level speed v the leaning body meets v cos(lean), so q is the
        quadratic drag times that.
        """
        pull, q = GRAVITY * math.tan(lean), self.quadratic_drag * math.cos(lean)
        if self.linear_drag <= 0 and q <= 0:
            return math.inf
        return 2 * pull / (self.linear_drag + math.sqrt(self.linear_drag**2 + 4 * q * pull))


#: PX4's SIH quadrotor (1 kg, drag 1 N s/m): at 45 degrees of lean its drag allows 9.8 m/s level.
PX4_SIMULATOR = Body(
    linear_drag=1.0,
    quadratic_drag=0.0,
    lag=0.06,
    senses=Senses(every=0.125, height_noise=0.5, drift=0.2, drift_up=0.13, drift_lasts=4.5, sees_ground=True),
)
