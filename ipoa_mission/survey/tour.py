from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ipoa_mission.geometry import Points, Vector, polyline_length


@dataclass(frozen=True, eq=False)
class Swath:
    """A straight line with the sensor on, east and north (2,) [m]."""

    begin: Points
    end: Points

    @property
    def ends(self) -> Points:
        return np.array([self.begin, self.end])

    @property
    def length(self) -> float:
        return float(np.linalg.norm(self.end - self.begin))

    @property
    def ahead(self) -> Vector:
        return np.asarray((self.end - self.begin) / max(self.length, 1e-9))

    def at(self, distance: float) -> Points:
        return np.asarray(self.begin + distance * self.ahead)


@dataclass(frozen=True, eq=False)
class Tour:
    """Lines in flight order; `transits[n]` (k, 2), k >= 2, leads from line n to the next."""

    swaths: tuple[Swath, ...]
    transits: tuple[Points, ...]

    @property
    def path(self) -> Points:
        """Return all corners (n, 2), without repeats."""
        if not self.swaths:
            return np.empty((0, 2))
        pieces = [self.swaths[0].ends]
        for transit, swath in zip(self.transits, self.swaths[1:], strict=True):
            pieces += [transit, swath.ends]
        return without_repeats(np.concatenate(pieces))

    @property
    def length(self) -> float:
        return polyline_length(self.path)

    def part(self, first: int, last: int) -> "Tour":
        return Tour(self.swaths[first:last], self.transits[first : last - 1])

    def moved(self, move: Callable[[Points], Points]) -> "Tour":
        return Tour(tuple(Swath(*move(s.ends)) for s in self.swaths), tuple(map(move, self.transits)))


@dataclass(frozen=True, eq=False)
class Sortie:
    """The lines of one flight; `start` is the index of its place, or None for home."""

    tour: Tour
    start: int | None = None


def without_repeats(path: Points) -> Points:
    return np.asarray(path[np.concatenate([[True], (np.diff(path, axis=0) != 0.0).any(axis=1)])])
