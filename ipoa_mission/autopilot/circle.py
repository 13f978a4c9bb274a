from typing import NamedTuple


class FlownCircle(NamedTuple):
    """`radius` [m], the lag `behind` at the end [rad], the way it `runs_on` until it stops [m].

    `sense`: 1 clockwise, -1 counterclockwise, 0 as in the item.
    """

    radius: float
    behind: float
    runs_on: float
    sense: float = 0.0
