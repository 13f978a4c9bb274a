"""How well PX4's filter knows the vehicle's motion: the velocity that it believes wanders about the true one.

On each axis a second-order Gauss-Markov process, white noise through two lags of tau seconds, whose correlation over
t seconds is (1 + t/tau) exp(-t/tau). The controller keeps the velocity that is believed, so the vehicle drifts off its
target until the position error outweighs it, and the target waits.

Measured on 20 flights of PX4 1.17: reported velocity against the change of reported place. Level 0.25 m/s east and 0.16
north, vertical 0.13; correlations after 1, 2, 3, 5 s: 0.87, 0.68, 0.47, 0.09 level and 0.86, 0.73, 0.61, 0.38 vertical.
"""

import math
import random

from ipoa_mission.simulator.body import Triple

#: Standard deviation [m/s] and tau [s]: level, vertical.
LEVEL = (0.21, 1.6)
VERTICAL = (0.13, 2.0)


class MotionEstimate:
    """The error on each axis, and the noise that it follows."""

    def __init__(self, chance: random.Random) -> None:
        self._axes = [_Wander(chance, *axis) for axis in (LEVEL, LEVEL, VERTICAL)]

    def of(self, motion: Triple, dt: float) -> Triple:
        """What is believed of a motion, `dt` after the last one [m/s]."""
        x, y, z = (v + axis.advance(dt) for v, axis in zip(motion, self._axes, strict=True))
        return x, y, z


class _Wander:
    def __init__(self, chance: random.Random, deviation: float, tau: float) -> None:
        self._chance, self._tau = chance, tau
        self._input = math.sqrt(2.0) * deviation  # of which the second lag leaves `deviation`
        self._first = self._second = 0.0

    def advance(self, dt: float) -> float:
        keep = math.exp(-dt / self._tau)
        self._first = keep * self._first + self._chance.gauss(0.0, self._input * math.sqrt(1.0 - keep * keep))
        self._second = keep * self._second + (1.0 - keep) * self._first
        return self._second
