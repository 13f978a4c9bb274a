from collections.abc import Callable
from typing import Any, TypeAlias

import numpy as np

from ipoa_mission.studio.vocabulary import LngLat
from ipoa_mission.world.frame import Geodetic, LocalFrame

DIGITS, DEGREES = 2, 7  # decimals of meters and of degrees
#: [east, north] or [latitude, longitude]
Move: TypeAlias = Callable[[float, float], tuple[float, float]]


def local_of(frame: LocalFrame, place: LngLat) -> list[float]:
    """Return east and north, to the centimeter [m]."""
    east, north = frame.local(Geodetic(place[1], place[0], frame.home.altitude))[:2].round(DIGITS).tolist()
    return [east + 0.0, north + 0.0]  # never -0.0


def moves_of(old: LocalFrame, new: LocalFrame, step: Any) -> tuple[Move, Move]:
    """Return how [east, north] and [latitude, longitude] move by `step` (2,) [m] into another frame."""

    def local(east: float, north: float) -> tuple[float, float]:
        moved = np.array([float(east) + step[0], float(north) + step[1], 0.0])
        if new is not old:
            there = old.geodetic(moved)
            moved = new.local(Geodetic(there.latitude_deg, there.longitude_deg, new.home.altitude))
        return round(float(moved[0]), DIGITS), round(float(moved[1]), DIGITS)

    def geodetic(latitude: float, longitude: float) -> tuple[float, float]:
        east, north, _ = old.local(Geodetic(float(latitude), float(longitude), old.home.altitude))
        there = old.geodetic(np.array([east + step[0], north + step[1], 0.0]))
        return round(there.latitude_deg, DEGREES), round(there.longitude_deg, DEGREES)

    return local, geodetic
