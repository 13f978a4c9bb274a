"""What the kernels know of a vehicle's times."""

from typing import NamedTuple

from ipoa_mission.geometry import Points, Vector


class Clock(NamedTuple):
    """Seconds per metre by direction, and what corners cost.

    Attributes:
        pace: from east counterclockwise, evenly (d,) [s/m]; one for all.
        corner: by angle, from none to a turn about, and by the shorter of its two legs (angles, lengths) [s].
        shortest: the first of these lengths [m].
        ratio: the natural logarithm of that of each length to the one before.
    """

    pace: Vector
    corner: Points
    shortest: float
    ratio: float
