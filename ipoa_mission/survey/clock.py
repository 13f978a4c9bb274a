from typing import NamedTuple

from ipoa_mission.geometry import Points, Vector


class Clock(NamedTuple):
    pace: Vector  # by direction counterclockwise from east (d,) [s/m]; size 1: any
    corner: Points  # by angle from 0 to 180 degrees and shorter leg (angles, lengths) [s]
    shortest: float  # the first length [m]
    ratio: float  # natural logarithm of the ratio of successive lengths
