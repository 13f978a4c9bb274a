"""The power of one vehicle as its batteries measured it, by airspeed and climb: what `learn` finds."""

from dataclasses import dataclass

import numpy as np

from ipoa_mission.geometry import Vector


@dataclass(frozen=True)
class PowerCurve:
    """What a vehicle draws: hover + square v^2 + cube v^3 + climb w, or + descent w where it comes down at w [W].

    v is the airspeed, seen up to `fastest` [m/s]. The square holds what a lean costs and what the flow through the
    rotors gives back, the cube what drags; a real vehicle's square may be negative, its cube is not.
    """

    hover_w: float
    square_w: float = 0.0
    cube_w: float = 0.0
    climb_w: float = 0.0
    descent_w: float = 0.0
    fastest: float = np.inf

    def level(self, airspeed: Vector) -> Vector:
        """In level flight at airspeeds (n,) [W]; faster than was seen never less than there."""
        seen = np.minimum(airspeed, self.fastest)
        known = self._level(seen)
        return np.asarray(np.where(airspeed > seen, np.maximum(self._level(airspeed), known), known))

    def _level(self, airspeed: Vector) -> Vector:
        return np.asarray(self.hover_w + (self.square_w + self.cube_w * airspeed) * airspeed**2)

    def power(self, airspeed: Vector, climb: Vector) -> Vector:
        """At airspeeds and rates of climb (n,) [m/s], in W; never negative."""
        upright = self.climb_w * np.maximum(climb, 0.0) + self.descent_w * np.maximum(-climb, 0.0)
        return np.asarray(np.maximum(self.level(airspeed) + upright, 0.0))

    def beyond(self, airspeed: Vector) -> Vector:
        """How many times as much it may draw where it is faster than was seen (n,): as if all of it were drag."""
        level = self.level(airspeed)
        return np.asarray(self._level(np.minimum(airspeed, self.fastest)) * _cubed(airspeed, self.fastest) / level)


def _cubed(airspeed: Vector, fastest: float) -> Vector:
    return np.asarray(np.maximum(airspeed / fastest, 1.0) ** 3)
