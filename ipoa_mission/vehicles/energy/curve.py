"""A vehicle's power by airspeed and climb, fitted to its battery logs by `learn`."""

from dataclasses import dataclass

import numpy as np

from ipoa_mission.geometry import Vector


@dataclass(frozen=True)
class PowerCurve:
    """Power [W] = hover + square v^2 + cube v^3 + climb w, or + descent w while it descends at w.

    v is the airspeed, measured up to `fastest` [m/s]. The square term covers lean and translational lift and may be
    negative. The cube term covers drag and is not negative.
    """

    hover_w: float
    square_w: float = 0.0
    cube_w: float = 0.0
    climb_w: float = 0.0
    descent_w: float = 0.0
    fastest: float = np.inf

    def level(self, airspeed: Vector) -> Vector:
        """Compute level-flight power at airspeeds (n,) [W]; beyond `fastest` at least its value there."""
        seen = np.minimum(airspeed, self.fastest)
        known = self._level(seen)
        return np.asarray(np.where(airspeed > seen, np.maximum(self._level(airspeed), known), known))

    def _level(self, airspeed: Vector) -> Vector:
        return np.asarray(self.hover_w + (self.square_w + self.cube_w * airspeed) * airspeed**2)

    def power(self, airspeed: Vector, climb: Vector) -> Vector:
        """Compute power at airspeeds and climb rates (n,) [m/s], at least 0 [W]."""
        upright = self.climb_w * np.maximum(climb, 0.0) + self.descent_w * np.maximum(-climb, 0.0)
        return np.asarray(np.maximum(self.level(airspeed) + upright, 0.0))

    def beyond(self, airspeed: Vector) -> Vector:
        """Return the upper bound's factor beyond `fastest` (n,), as if all power were drag."""
        level = self.level(airspeed)
        return np.asarray(self._level(np.minimum(airspeed, self.fastest)) * _cubed(airspeed, self.fastest) / level)


def _cubed(airspeed: Vector, fastest: float) -> Vector:
    return np.asarray(np.maximum(airspeed / fastest, 1.0) ** 3)
