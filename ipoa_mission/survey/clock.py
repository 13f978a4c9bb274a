"""The times of a vehicle as the kernels take them."""

from typing import NamedTuple

from ipoa_mission.geometry import Points, Vector


class Clock(NamedTuple):
    """Seconds per meter by direction, and the cost of corners.

    Attributes:
        pace: by direction, counterclockwise from east, evenly spaced (d,) [s/m]; size 1 for all directions.
        corner: by angle from 0 to 180 degrees, and by the shorter of its two legs (angles, lengths) [s].
        shortest: the first of these lengths [m].
        ratio: natural logarithm of the ratio of successive lengths.
    """

    pace: Vector
    corner: Points
    shortest: float
    ratio: float
