"""A steady wind, as it is given: a speed, the direction that it comes from, and how it grows with height."""

import math
from dataclasses import dataclass


@dataclass(frozen=True)
class Wind:
    """A steady wind; it blows everywhere and at all times alike.

    Below the `gradient_height` it follows a power law: speed (height / gradient height)^`exponent`.

    Attributes:
        speed: how strong it is [m/s].
        from_deg: where it blows from, clockwise: 0 north, 90 east [degrees].
        exponent: of the power law.
        gradient_height: up to where it grows [m above home].

    Example:
        >>> west = Wind(6.0, from_deg=270.0)
        >>> round(west.east, 3), round(abs(west.north), 3)
        (6.0, 0.0)
        >>> Wind(6.0, 270.0, exponent=0.5, gradient_height=20.0).at(5.0)
        3.0
    """

    speed: float = 0.0
    from_deg: float = 0.0
    exponent: float = 0.0
    gradient_height: float = 0.0

    def at(self, height: float) -> float:
        """Its speed at a height over home [m/s]."""
        if height >= self.gradient_height or self.gradient_height <= 0:
            return self.speed
        return self.speed * math.pow(max(height, 0.0) / self.gradient_height, self.exponent)

    @classmethod
    def towards_north_east(cls, north: float, east: float) -> "Wind":
        """One that blows towards there [m/s]."""
        return cls(math.hypot(north, east), math.degrees(math.atan2(-east, -north)) % 360.0)

    def towards(self, height: float) -> tuple[float, float]:
        """What it blows towards the east and the north at a height over home [m/s]."""
        share = self.at(height) / self.speed if self.speed else 0.0
        return self.east * share, self.north * share

    @property
    def east(self) -> float:
        """The part that blows towards the east [m/s]."""
        return -self.speed * math.sin(math.radians(self.from_deg))

    @property
    def north(self) -> float:
        """The part that blows towards the north [m/s]."""
        return -self.speed * math.cos(math.radians(self.from_deg))

    def along(self, east: float, north: float) -> float:
        """The part that blows along a level direction.

        Args:
            east: of a vector of any length in that direction.
            north: of the same.

        Returns:
            Its speed [m/s], negative against it; 0 for no direction.
        """
        length = math.hypot(east, north)
        return (self.east * east + self.north * north) / length if length > 0 else 0.0


CALM = Wind()
