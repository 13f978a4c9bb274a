"""The multirotors that the models fly: what drag they have, how quickly they answer, how well they know their height.

No mission and no autopilot parameter tells these, and every airframe has its own; the values here are those of the
two simulators' quadrotors, read from the recorded flights (see docs/flight-time.md). Below about 8 m/s drag hardly
matters; near the speed where it meets the greatest lean it decides.
"""

from dataclasses import dataclass

GRAVITY = 9.80665  # [m/s^2]


@dataclass(frozen=True)
class HeightJumps:
    """A height estimate that jumps away by `least` m and on average `more` m beyond that, and soon comes back.

    It stays away `lasts` s on average and then rests for `rest` s on average.
    """

    least: float
    more: float
    lasts: float
    rest: float


@dataclass(frozen=True)
class Body:
    """Drag per mass along the leaning body: (linear + quadratic v) v [1/s, 1/m]; `lag` [s] of rotors and rate loop.

    `wander` [m] is by how much the place estimate strays from the path even where the vehicle keeps up.
    """

    linear_drag: float
    quadratic_drag: float
    lag: float
    wander: float = 0.0
    jumps: HeightJumps | None = None


#: ArduPilot's built-in quadrotor: at 30 degrees of lean its drag allows 10.0 m/s level.
ARDUPILOT_SIMULATOR = Body(linear_drag=0.30, quadratic_drag=0.0306, lag=0.02)
#: PX4's SIH quadrotor (1 kg, drag 1 N s/m): at 45 degrees of lean its drag allows 9.8 m/s level.
PX4_SIMULATOR = Body(1.0, 0.0, lag=0.06, wander=0.08, jumps=HeightJumps(least=1.0, more=0.31, lasts=0.38, rest=1.6))
