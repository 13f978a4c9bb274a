"""A constant wind, as it is given: a speed, and the direction that it comes from."""

import math
from dataclasses import dataclass


@dataclass(frozen=True)
class Wind:
    """Wind of `speed` [m/s] from `from_deg` (0 north, 90 east); it blows everywhere and at all times alike.

    >>> west = Wind(6.0, from_deg=270.0)
    >>> round(west.east, 3), round(abs(west.north), 3)
    (6.0, 0.0)
    """

    speed: float = 0.0
    from_deg: float = 0.0

    @classmethod
    def towards(cls, east: float, north: float) -> "Wind":
        """The wind that blows with these components [m/s]."""
        return cls(math.hypot(east, north), math.degrees(math.atan2(-east, -north)))

    @property
    def east(self) -> float:
        """The part that blows towards the east [m/s]."""
        return -self.speed * math.sin(math.radians(self.from_deg))

    @property
    def north(self) -> float:
        """The part that blows towards the north [m/s]."""
        return -self.speed * math.cos(math.radians(self.from_deg))

    def along(self, east: float, north: float) -> float:
        """The part that blows along a direction, given by a level vector of any length [m/s]; 0 for no direction."""
        length = math.hypot(east, north)
        return (self.east * east + self.north * north) / length if length > 0 else 0.0


CALM = Wind()
