"""ArduCopter's braking path in LAND and BRAKE, and its pursuit of a circle's moving point.

Read in 4.8.0-dev (AC_PosControl::input_vel_accel_NE_m, shape_vel_accel_xy, ModeLand, ModeBrake) and flown. LAND starts
with the path's speed and acceleration, BRAKE with the vehicle's speed.
"""

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ipoa_mission.autopilot.guidance_profile import FlownCircle
from ipoa_mission.errors import BadInput
from ipoa_mission.vehicles.arducopter.dynamics.motion import STEP
from ipoa_mission.vehicles.arducopter.dynamics.shaping import size, sqrt_controller
from ipoa_mission.vehicles.arducopter.limits import CENTIMETER, CopterLimits


def braking_displacement(velocity: NDArray[Any], accel: NDArray[Any], most_accel: float, jerk: float) -> NDArray[Any]:
    """Return the displacement to rest [m] of velocities and accelerations, complex (n,) each."""
    at_rest_s = 12.0
    gain = jerk / most_accel
    displacement = np.zeros_like(velocity)
    for n in range(len(velocity)):
        v, a = velocity[n], accel[n]
        for _ in range(int(at_rest_s / STEP)):
            speed = size(v)
            change = -v * (min(sqrt_controller(speed, jerk, gain), most_accel) / max(speed, 1e-9)) - a
            share = min(jerk * STEP / max(size(change), 1e-12), 1.0)
            a += change * share
            displacement[n] += v * STEP
            v += a * STEP
            if gain * speed <= most_accel and share == 1.0:  # from now on it decays exponentially
                displacement[n] += v / gain
                break
    return displacement


def circle_spin(limits: CopterLimits, radius: float, speed: float) -> float:
    """Return the point's turn rate [rad/s], with half of the acceleration limit; raise BadInput if it is 0."""
    if limits.circle_rate == 0.0:
        raise BadInput("expected another rate than 0, with which a circle has no end", place="CIRCLE_RATE")
    fastest = min(speed, math.sqrt(0.5 * limits.accel * radius))
    return min(limits.circle_rate, fastest / radius)


def flown_circle(limits: CopterLimits, radius: float, speed: float, turn: float) -> FlownCircle:
    """Return the circle on which the vehicle lags behind a point of `radius` > 0 [m], by fixed-point iteration.

    Horizontal speed limit [m/s], `turn` [rad].
    """
    spin = circle_spin(limits, radius, speed)
    accel = limits.accel
    gain = limits.shaping_jerk / limits.accel
    aside = math.atan(spin / gain)
    linear = accel / gain**2
    flown = radius
    ahead = 0.0
    for _ in range(60):
        pace = spin * flown
        setpoint = min(pace / math.cos(aside), speed)
        closing = pace * math.cos(aside)
        commanded = setpoint + closing
        if commanded > accel / gain:
            commanded = (setpoint + math.sqrt(setpoint * setpoint + 4.0 * closing * accel / gain)) / 2.0
        ahead = commanded / gain if commanded <= accel / gain else linear / 2.0 + commanded * commanded / (2.0 * accel)
        inward = ahead * math.sin(aside)
        flown = (flown + inward + math.sqrt(max(radius**2 - (ahead * math.cos(aside)) ** 2, CENTIMETER))) / 2.0
    behind = math.atan2(ahead * math.cos(aside), flown - ahead * math.sin(aside))
    settled = math.acos(min(speed * math.cos(aside) ** 2 / (spin * radius), 1.0))
    if behind - aside < settled:
        # the angle from velocity to point after a turn at the speed limit
        left = max(abs(turn) - behind, 0.0)
        back = settled * math.tanh(settled * left / 2.0 + math.atanh((behind - aside) / settled))
        flown = radius * math.cos(back) / math.cos(aside)
        behind = aside + back
    return FlownCircle(flown, behind, float(limits.stopping_distance(spin * flown)), limits.circle_sense)
