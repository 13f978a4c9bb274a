from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ipoa_mission.geometry import Points, polyline_length


@dataclass(frozen=True, eq=False)
class Swath:
    """A straight line with the sensor on, east and north (2,) [m]."""

    begin: Points
    end: Points

    @property
    def length(self) -> float:
        return float(np.linalg.norm(self.end - self.begin))


@dataclass(frozen=True, eq=False)
class Tour:
    """Lines in flight order; `ways[n]` (k, 2), k >= 2, leads from line n to the next.

    Example:
        >>> there, back = Swath(np.array([0.0, 0.0]), np.array([9.0, 0.0])), Swath(np.array([9.0, 2.0]), np.zeros(2))
        >>> tour = Tour((there, back), (np.array([[9.0, 0.0], [9.0, 2.0]]),))
        >>> len(tour.path), round(tour.length, 2)
        (4, 20.22)
    """

    swaths: tuple[Swath, ...]
    ways: tuple[Points, ...]

    @property
    def path(self) -> Points:
        """Return all corners (n, 2), without repeats."""
        if not self.swaths:
            return np.empty((0, 2))
        pieces = [np.array([self.swaths[0].begin, self.swaths[0].end])]
        for way, swath in zip(self.ways, self.swaths[1:], strict=True):
            pieces += [way, np.array([swath.begin, swath.end])]
        whole = np.concatenate(pieces)
        return np.asarray(whole[np.concatenate([[True], (np.diff(whole, axis=0) != 0.0).any(axis=1)])])

    @property
    def length(self) -> float:
        return polyline_length(self.path)

    def moved(self, move: Callable[[Points], Points]) -> "Tour":
        ends = [move(np.array([swath.begin, swath.end])) for swath in self.swaths]
        return Tour(tuple(Swath(*pair) for pair in ends), tuple(move(way) for way in self.ways))


@dataclass(frozen=True, eq=False)
class Sortie:
    """The lines of one flight; `start` is the index of its place, or None for home."""

    tour: Tour
    start: int | None = None
