"""PX4's descent to the ground: fast, then slower between two heights, then at landing speed."""

from functools import lru_cache

from ipoa_mission.timing.px4_parameters import Px4Limits

STEP = 0.1  # [s]

Descent = tuple[tuple[float, float, float], ...]  # time from its begin [s], height [m], climb rate [m/s]


@lru_cache(maxsize=256)
def touch_down(limits: Px4Limits, height: float) -> Descent:
    """Come down from `height`: MPC_Z_V_AUTO_DN to MPC_LAND_ALT1, from there to MPC_LAND_ALT2 down to MPC_LAND_SPEED."""
    t, rate = 0.0, 0.0
    flown = [(t, height, rate)]
    while height > 0:
        span = max(limits.land_high - limits.land_low, 1e-6)
        share = min(max((height - limits.land_low) / span, 0.0), 1.0)
        wanted = limits.land_speed + share * (limits.descent - limits.land_speed)
        rate = max(rate - limits.accel_down * STEP, -wanted) if -rate < wanted else -wanted
        t, height = t + STEP, height + rate * STEP
        flown.append((t, height, rate))
    return tuple(flown)
