"""The circle that ArduCopter flies for NAV_LOITER_TURNS.

Read in 4.8.0-dev (AC_Circle, shape_pos_vel_accel_xy) and flown. In a steady turn at rate w the point is at an angle t
from the target's velocity. It is tan t = w / k with k = jerk / acceleration.
"""

import math

from ipoa_mission.autopilot.circle import FlownCircle
from ipoa_mission.vehicles.arducopter.limits import CENTIMETRE, CopterLimits

CIRCLE_SHARE = 0.5  # of the acceleration limit
ITERATIONS = 60


def circle_spin(limits: CopterLimits, radius: float, speed: float) -> float:
    """Return the point's turn rate [rad/s]."""
    fastest = min(speed, math.sqrt(CIRCLE_SHARE * limits.accel * radius))
    return min(limits.circle_rate, fastest / radius)


def flown_circle(limits: CopterLimits, radius: float, speed: float, turn: float) -> FlownCircle:
    """`radius` > 0 [m], level speed limit [m/s], `turn` [rad]."""
    spin, accel, gain = circle_spin(limits, radius, speed), limits.accel, limits.shaping_jerk / limits.accel
    aside = math.atan(spin / gain)
    linear, flown, ahead = accel / gain**2, radius, 0.0
    for _ in range(ITERATIONS):
        pace = spin * flown
        asked, closing = min(pace / math.cos(aside), speed), pace * math.cos(aside)
        law = asked + closing
        if law > accel / gain:
            law = (asked + math.sqrt(asked * asked + 4.0 * closing * accel / gain)) / 2.0
        ahead = law / gain if law <= accel / gain else linear / 2.0 + law * law / (2.0 * accel)
        inward = ahead * math.sin(aside)
        flown = (flown + inward + math.sqrt(max(radius**2 - (ahead * math.cos(aside)) ** 2, CENTIMETRE))) / 2.0
    behind = math.atan2(ahead * math.cos(aside), flown - ahead * math.sin(aside))
    settled = math.acos(min(speed * math.cos(aside) ** 2 / (spin * radius), 1.0))
    if behind - aside < settled:
        back = _fallen_back(behind - aside, settled, max(abs(turn) - behind, 0.0))
        flown, behind = radius * math.cos(back) / math.cos(aside), aside + back
    pace, near = spin * flown, accel / limits.p_position**2
    runs_on = pace / limits.p_position if pace <= near else near / 2.0 + pace**2 / (2.0 * accel)
    return FlownCircle(flown, behind, runs_on, limits.circle_sense)


def _fallen_back(begin: float, settled: float, turn: float) -> float:
    """Return the angle from velocity to point after a turn at the speed limit."""
    return settled * math.tanh(settled * turn / 2.0 + math.atanh(begin / settled))
