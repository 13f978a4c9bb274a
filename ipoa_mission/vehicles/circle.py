"""How a circle comes out that a mission asks for."""

from typing import NamedTuple


class FlownCircle(NamedTuple):
    """A circle as it is flown: its `radius` [m]; by what angle the vehicle is `behind` as it ends [rad].

    From there it `runs_on` straight before it stops [m]. `sense` is 1 for clockwise, -1 for counterclockwise, and 0
    where the item says which.
    """

    radius: float
    behind: float
    runs_on: float
    sense: float = 0.0
