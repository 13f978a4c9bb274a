"""ArduCopter straight up and straight down: take-off and the descent of LAND and RTL, which no S-curve shapes.

Both follow its velocity shaping: the wanted climb rate is reached with acceleration and jerk limits, and towards a
height it is the square-root law sqrt(2 (a/2) (d - d0/2)), linear within d0 = (a/2)/k^2, with k = jerk/(2 a).
"""

import math
from collections.abc import Callable
from functools import lru_cache

from ipoa_mission.autopilots.ardupilot import CopterLimits

STEP = 0.02  # [s]
POSITION_GAIN = 1.0  # of the descent towards LAND_ALT_LOW: PSC_POSZ_P's default [1/s]

Climb = tuple[tuple[float, float, float], ...]  # time from its begin [s], height [m], climb rate [m/s]


@lru_cache(maxsize=256)
def take_off(limits: CopterLimits, height: float, target: float) -> Climb:
    """Climb from `height` to `target`; done when nine tenths are climbed and the wanted rate is below a tenth."""
    near = height + 0.9 * (target - height)

    def wanted(h: float) -> float:
        return min(_towards(target - h, limits.accel_z / 2, limits.jerk_z / (2 * limits.accel_z)), limits.climb)

    return _shaped(limits, height, wanted, lambda h, rate: h >= near and rate < 0.1 * limits.climb)


@lru_cache(maxsize=256)
def descend(limits: CopterLimits, height: float, floor: float) -> Climb:
    """Come down from `height` to `floor`: fast down to LAND_ALT_LOW, then at LAND_SPEED."""

    def wanted(h: float) -> float:
        rate = _towards(limits.land_low - h, limits.accel_z, POSITION_GAIN)
        return min(max(rate, -max(limits.land_speed_high, limits.land_speed)), -limits.land_speed)

    return _shaped(limits, height, wanted, lambda h, rate: h <= floor)


def _shaped(
    limits: CopterLimits,
    height: float,
    wanted: Callable[[float], float],
    done: Callable[[float, float], bool],
) -> Climb:
    gain = limits.jerk_z / limits.accel_z
    t, rate, accel = 0.0, 0.0, 0.0
    flown = [(t, height, rate)]
    while not done(height, rate) or t == 0.0:
        target = min(max(gain * (wanted(height) - rate), -limits.accel_z), limits.accel_z)
        accel += min(max(target - accel, -limits.jerk_z * STEP), limits.jerk_z * STEP)
        rate += accel * STEP
        height += rate * STEP
        t += STEP
        flown.append((t, height, rate))
    return tuple(flown)


def _towards(error: float, accel: float, gain: float) -> float:
    """The square-root law: linear near the goal, then the speed from which `accel` can still stop in time."""
    linear = accel / (gain * gain)
    if abs(error) <= linear:
        return gain * error
    return math.copysign(math.sqrt(2 * accel * (abs(error) - linear / 2)), error)
