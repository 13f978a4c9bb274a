"""The circle that ArduCopter flies for NAV_LOITER_TURNS: it pursues a point that runs along the circle asked for.

So it flies inside of that circle, and behind. Read in 4.8.0-dev (AC_Circle, shape_pos_vel_accel_xy) and flown. In a
steady turn at a rate w the target sees the point ahead at an angle t from its own way, tan t = w / k with k = jerk /
acceleration, as far as its square-root law asks for. The speed limit also cuts what that law asks for: then the target
is slower than the point and falls back slowly, over some turns.
"""

import math

from ipoa_mission.vehicles.arducopter.limits import CENTIMETRE, CopterLimits
from ipoa_mission.vehicles.circle import FlownCircle

CIRCLE_SHARE = 0.5  # of the acceleration limit that a circle uses
ROUNDS = 60  # in which the radius settles


def circle_spin(limits: CopterLimits, radius: float, speed: float) -> float:
    """The rate of turn of the point, up to a level speed [rad/s]."""
    fastest = min(speed, math.sqrt(CIRCLE_SHARE * limits.accel * radius))
    return min(limits.circle_rate, fastest / radius)


def flown_circle(limits: CopterLimits, radius: float, speed: float, turn: float) -> FlownCircle:
    """The circle for one of a `radius` > 0 m, at up to a level speed [m/s], after a turn [rad]."""
    spin, accel, gain = circle_spin(limits, radius, speed), limits.accel, limits.shaping_jerk / limits.accel
    aside = math.atan(spin / gain)
    linear, flown, ahead = accel / gain**2, radius, 0.0
    for _ in range(ROUNDS):
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
    """The angle between the sight of the point and its way, after a turn, where the speed limit cuts the pursuit.

    The target falls back while the point moves faster along the line of sight, until both are equal.
    """
    return settled * math.tanh(settled * turn / 2.0 + math.atanh(begin / settled))
