"""A leg along a cubic Hermite curve, as fast as its bends and its end allow: ArduPilot's spline waypoint."""

import math

from ipoa_mission.simulator.scurve import Triple

BRAKING = 0.5  # share of the acceleration that is planned with along the track; the rest is left for corrections


def most_along(direction: Triple, flat: float, up: float, down: float) -> float:
    """The most that may be had along a unit direction, so that its horizontal and vertical parts keep their limits."""
    across, rise = math.hypot(direction[0], direction[1]), direction[2]
    most = flat / across if across > 1e-9 else math.inf
    if abs(rise) > 1e-9:
        most = min(most, (up if rise > 0.0 else down) / abs(rise))
    return most if math.isfinite(most) else 0.0


class SplineLeg:
    """Cubic through two places with given tangents; `share` runs from 0 to 1 along it, unevenly in time."""

    def __init__(
        self,
        origin: Triple,
        destination: Triple,
        leaving: Triple,
        arriving: Triple,
        speeds: Triple,  # horizontal, up, down
        acceleration: float,
        vertical_acceleration: float,
    ):
        self.origin, self.destination = origin, destination
        self.speeds = speeds
        self._accelerations = (acceleration, vertical_acceleration, vertical_acceleration)
        tangents = math.hypot(*leaving) + math.hypot(*arriving)
        room = 4.0 * math.dist(origin, destination)
        scale = room / tangents if tangents > room else 1.0
        self.leaving: Triple = (leaving[0] * scale, leaving[1] * scale, leaving[2] * scale)
        self.arriving: Triple = (arriving[0] * scale, arriving[1] * scale, arriving[2] * scale)
        self._cubic = tuple(
            (2.0 * (p - q) + u + v, 3.0 * (q - p) - 2.0 * u - v, u, p)
            for p, q, u, v in zip(origin, destination, self.leaving, self.arriving, strict=True)
        )
        self.share = 0.0
        self.spare_s = 0.0
        self.end_speed = math.inf  # until something slower is known to follow
        self.start_speed = self._allowed(0.0)[1] if tangents > 0.0 and math.hypot(*leaving) > 0.0 else 0.0
        self.end_speed = self._allowed(1.0)[1] if math.hypot(*arriving) > 0.0 else 0.0

    @property
    def finished(self) -> bool:
        """Whether the destination has been passed."""
        return self.share >= 1.0

    def place(self) -> Triple:
        """Where the curve is now."""
        t = min(self.share, 1.0)
        x, y, z = (((a * t + b) * t + c) * t + d for a, b, c, d in self._cubic)
        return x, y, z

    def _allowed(self, t: float) -> tuple[Triple, float, float, float]:
        """Direction, the highest speed, the acceleration along the track, and |dp/dshare| at a share."""
        (ux, uy, uz), (wx, wy, wz) = (
            ((3.0 * a * t + 2.0 * b) * t + c for a, b, c, _ in self._cubic),
            (6.0 * a * t + 2.0 * b for a, b, _, _ in self._cubic),
        )
        pace = math.sqrt(ux * ux + uy * uy + uz * uz)
        if pace < 1e-6:
            bend = math.sqrt(wx * wx + wy * wy + wz * wz)
            if bend < 1e-9:
                return (0.0, 0.0, 0.0), 0.0, 0.0, 0.0
            direction = (wx / bend, wy / bend, wz / bend)
            braking = BRAKING * most_along(direction, *self._accelerations)
            return direction, most_along(direction, *self.speeds), braking, 0.0
        direction = (ux / pace, uy / pace, uz / pace)
        inline = wx * direction[0] + wy * direction[1] + wz * direction[2]
        nx, ny, nz = wx - inline * direction[0], wy - inline * direction[1], wz - inline * direction[2]
        bend = math.sqrt(nx * nx + ny * ny + nz * nz)
        speed = most_along(direction, *self.speeds)
        if bend > 1e-6:  # v^2 bend / pace^2 is the acceleration across the track
            across = BRAKING * most_along((nx / bend, ny / bend, nz / bend), *self._accelerations)
            speed = min(speed, pace * math.sqrt(across / bend))
        gain = BRAKING * most_along(direction, *self._accelerations)
        return direction, speed, gain, pace

    def advance(self, speed: float, dt: float) -> tuple[Triple, float]:
        """Let `dt` pass, coming at `speed`; returns the direction and the speed reached."""
        direction, most, gain, pace = self._allowed(self.share)
        left = math.dist(self.place(), self.destination)
        most = min(most, math.sqrt(2.0 * gain * left + self.end_speed**2))
        speed = min(max(most, speed - gain * dt), speed + gain * dt)
        way = speed * dt
        if pace < 1e-6:
            bend = math.sqrt(sum((2.0 * b) ** 2 for _, b, _, _ in self._cubic))
            step = math.sqrt(2.0 * way / bend) if bend > 0.0 else 1.0
        else:
            step = way / pace
        if self.share + step >= 1.0:
            self.spare_s = dt * (1.0 - (1.0 - self.share) / step) if step > 0.0 else 0.0
        self.share += step
        return direction, speed
