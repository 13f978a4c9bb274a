"""Power by airspeed and climb, fitted to battery logs."""

from dataclasses import dataclass

import numpy as np

from ipoa_mission.geometry import Vector


@dataclass(frozen=True)
class PowerCurve:
    """Power [W] = hover + square v^2 + cube v^3 + climb w, or + descent w in a descent.

    v is the airspeed, measured up to `fastest` [m/s]. The square term may be negative (translational lift), the cube
    term not (drag).
    """

    hover_w: float
    square_w: float = 0.0
    cube_w: float = 0.0
    climb_w: float = 0.0
    descent_w: float = 0.0
    fastest: float = np.inf

    def level(self, airspeed: Vector) -> Vector:
        seen = np.minimum(airspeed, self.fastest)
        known = self._level(seen)
        return np.asarray(np.where(airspeed > seen, np.maximum(self._level(airspeed), known), known))

    def _level(self, airspeed: Vector) -> Vector:
        return np.asarray(self.hover_w + (self.square_w + self.cube_w * airspeed) * airspeed**2)

    def power(self, airspeed: Vector, climb: Vector) -> Vector:
        upright = self.climb_w * np.maximum(climb, 0.0) + self.descent_w * np.maximum(-climb, 0.0)
        return np.asarray(np.maximum(self.level(airspeed) + upright, 0.0))

    def beyond(self, airspeed: Vector) -> Vector:
        """Return the upper bound's factor beyond `fastest` (n,): all power is drag."""
        level = self.level(airspeed)
        return np.asarray(self._level(np.minimum(airspeed, self.fastest)) * _cubed(airspeed, self.fastest) / level)


def _cubed(airspeed: Vector, fastest: float) -> Vector:
    return np.asarray(np.maximum(airspeed / fastest, 1.0) ** 3)
