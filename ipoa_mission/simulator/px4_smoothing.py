"""PX4's speed profiles: each axis goes to a wanted speed by three stretches of constant jerk, in step with the others.

A profile starts with acceleration a0, rises (or falls) to a peak p, stays there, and fades to nothing:
(p - a0)/J, T2 and p/J seconds. It is planned anew at each control step, so only its beginning is ever flown.
"""

import math


class Axis:
    """Place, speed and acceleration along one axis, and the profile that is being flown."""

    __slots__ = ("acceleration", "accelerations", "jerk", "place", "sign", "speed", "stretches")

    def __init__(self, jerk: float, acceleration: float) -> None:
        self.jerk, self.accelerations = jerk, acceleration
        self.begin(0.0, 0.0)

    def begin(self, place: float, speed: float, acceleration: float = 0.0) -> None:
        """Start from here."""
        self.place, self.speed, self.acceleration = place, speed, acceleration
        self.sign = 0.0
        self.stretches = (0.0, 0.0, 0.0)

    def advance(self, dt: float) -> None:
        """Move along the planned profile."""
        jerks = (self.sign * self.jerk, 0.0, -self.sign * self.jerk)
        for jerk, lasts in zip(jerks, self.stretches, strict=True):
            if dt <= 0.0:
                return
            self._move(jerk, min(dt, lasts))
            dt -= lasts
        if dt > 0.0:
            self.acceleration = 0.0
            self._move(0.0, dt)

    def _move(self, jerk: float, t: float) -> None:
        a, v = self.acceleration, self.speed
        self.place += (v + (0.5 * a + jerk * t / 6.0) * t) * t
        self.speed = v + (a + 0.5 * jerk * t) * t
        self.acceleration = a + jerk * t

    def aim(self, speed: float) -> float:
        """Plan the quickest profile to a speed; returns how long it takes."""
        fading = self.speed + 0.5 * self.acceleration * abs(self.acceleration) / self.jerk  # if a is taken off
        self.sign = math.copysign(1.0, speed - fading) if speed != fading else math.copysign(1.0, self.acceleration)
        a0, gain = self.sign * self.acceleration, self.sign * (speed - self.speed)
        peak = math.sqrt(max(self.jerk * gain + 0.5 * a0 * a0, 0.0))
        peak = max(min(peak, self.accelerations), a0, 0.0)
        rest = gain - (2.0 * peak * peak - a0 * a0) / (2.0 * self.jerk)
        flat = max(rest / peak, 0.0) if peak > 1e-6 else 0.0
        self.stretches = ((peak - a0) / self.jerk, flat, peak / self.jerk)
        return sum(self.stretches)

    def stretch(self, speed: float, total: float) -> None:
        """Plan to the same speed with a lower peak, so that it takes `total` seconds."""
        a0, gain = self.sign * self.acceleration, self.sign * (speed - self.speed)
        time = total + a0 / self.jerk
        room = time * time - 4.0 * (gain + 0.5 * a0 * a0 / self.jerk) / self.jerk
        rise = 0.0
        if room >= 0.0:
            peak = 0.5 * self.jerk * (time - math.sqrt(room))
            rise = max((min(peak, self.accelerations) - a0) / self.jerk, 0.0)
        fall = max(a0 / self.jerk + rise, 0.0)
        self.stretches = (rise, max(total - rise - fall, 0.0), fall)


def aim_together(axes: tuple[Axis, Axis, Axis], speeds: tuple[float, float, float]) -> None:
    """Plan all axes to their speeds, the quicker ones stretched to the slowest."""
    times = [axis.aim(speed) for axis, speed in zip(axes, speeds, strict=True)]
    longest = max(times)
    for axis, speed, time in zip(axes, speeds, times, strict=True):
        if time < longest:
            axis.stretch(speed, longest)
