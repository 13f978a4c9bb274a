"""The circle that a vehicle flies for a circle of a mission."""

from typing import NamedTuple


class FlownCircle(NamedTuple):
    """A flown circle: its `radius` [m] and the angle that the vehicle lags `behind` at its end [rad].

    The vehicle then `runs_on` straight until it stops [m]. `sense`: 1 clockwise, -1 counterclockwise, 0 as the item
    says.
    """

    radius: float
    behind: float
    runs_on: float
    sense: float = 0.0
