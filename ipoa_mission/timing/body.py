"""The multirotor that the models fly: what drag it has and how quickly it answers.

No mission and no autopilot parameter tells these, and every airframe has its own; the values here are those of the
two simulators' quadrotors, found from the recorded flights (see docs/flight-time.md). Below about 8 m/s they hardly
matter; near the speed where drag meets the greatest lean they decide.
"""

from dataclasses import dataclass


@dataclass(frozen=True)
class Body:
    """Drag per mass along the leaning body: (linear + quadratic v) v [1/s, 1/m]; `lag` [s] of rotors and rate loop."""

    linear_drag: float
    quadratic_drag: float
    lag: float


#: ArduPilot's built-in quadrotor: at 30 degrees of lean its drag allows 10.0 m/s level.
GRAVITY = 9.80665  # [m/s^2]

ARDUPILOT_SIMULATOR = Body(linear_drag=0.30, quadratic_drag=0.0306, lag=0.02)
