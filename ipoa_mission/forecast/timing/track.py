"""Where a vehicle is when: the path of a flight as it is predicted, or as it was flown."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ipoa_mission.geometry import Points, Vector, arc_lengths
from ipoa_mission.world.ground import EARTH_RADIUS

AT_ONCE = 20_000  # so many points are thinned at once: a line takes many times the room of its points
SAME_S = 1e-9  # samples that are not farther apart are of one moment [s]
SAME_PLACE = 1e-12  # the square of the length of a leg that has none [m^2]
BOTH = 1.5  # times as far as it may be in one view it may be in both of them
STRAY = 0.02  # how far a thinned path may be from the predicted one [m]


@dataclass(frozen=True, eq=False)
class Track:
    """A path: times (n,) from arming [s], points (n, 3) east, north, up [m], speeds (n,) over the ground [m/s]."""

    times: Vector
    points: Points
    speeds: Vector

    @classmethod
    def of(cls, samples: Points, times: Vector | None = None) -> "Track":
        """Samples (n, 7) of time, place and velocity; `times` (n,) go before theirs.

        All is copied: samples of many hours are large, and let go of.
        """
        own = samples[:, 0] if times is None else times
        return cls(own.copy(), samples[:, 1:4].copy(), np.linalg.norm(samples[:, 4:7], axis=1))

    @classmethod
    def joined(cls, tracks: "Sequence[Track]") -> "Track":
        """One after the other, a moment that is noted twice once."""
        times = np.concatenate([one.times for one in tracks])
        later = np.concatenate([[True], np.diff(times) > SAME_S])
        points, speeds = (np.concatenate([getattr(one, name) for one in tracks]) for name in ("points", "speeds"))
        return cls(times[later], points[later], speeds[later])

    def at(self, times: Vector) -> Points:
        """Where it is at times (m,) [s], (m, 3)."""
        return np.column_stack([np.interp(times, self.times, axis) for axis in self.points.T])

    def nearest(self, time: float) -> int:
        """The number of the sample that is nearest to a time [s]."""
        return int(np.argmin(np.abs(self.times - time)))

    def between(self, begin: float, end: float) -> "Track":
        """The samples from one time to another [s]."""
        first, last = np.searchsorted(self.times, begin, "left"), np.searchsorted(self.times, end, "right")
        taken = slice(first, last)
        return Track(self.times[taken], self.points[taken], self.speeds[taken])

    def local(self) -> "Track":
        """Of a path whose `up` is counted on a round Earth the same over home's tangent plane, as the world has it."""
        sunk = self.points.copy()
        sunk[:, 2] -= (sunk[:, 0] ** 2 + sunk[:, 1] ** 2) / (2 * EARTH_RADIUS)
        return Track(self.times, sunk, self.speeds)


def thinned(path: Points, stray: float = STRAY) -> Points:
    """The path (n, 3) with points left out where the legs that remain pass them within about `stray` [m]."""
    if len(path) < 3:
        return path
    import shapely  # only what looks at a world needs it

    traveled = arc_lengths(path[:, :2])
    is_kept = np.zeros(len(path), dtype=bool)
    is_kept[0] = True
    for first in range(0, len(path) - 1, AT_ONCE):
        some = slice(first, first + AT_ONCE + 1)
        numbers = np.arange(len(path))[some]
        above, aside = path[some, :2], np.column_stack([traveled[some], path[some, 2]])
        for view in (above, aside):
            numbered = shapely.linestrings(np.column_stack([view, numbers]))
            few = shapely.simplify(numbered, stray, preserve_topology=False)  # of which is seen below
            is_kept[shapely.get_coordinates(few, include_z=True)[:, 2].astype(int)] = True
        is_kept[some] |= _folded(path[some], np.flatnonzero(is_kept[some]), BOTH * stray)
    return np.asarray(path[is_kept])


def _folded(path: Points, kept: NDArray[np.intp], most: float) -> NDArray[np.bool_]:
    """What of a path (n, 3) lies between two kept points whose leg passes a point between them farther away [m].

    So does a way that climbs to and fro over itself: from above and from the side all of it is one leg.
    """
    gap = np.clip(np.searchsorted(kept, np.arange(len(path)), "right") - 1, 0, len(kept) - 2)
    begins, ways = path[kept], np.diff(path[kept], axis=0)
    lengths = np.maximum((ways**2).sum(axis=1), SAME_PLACE)
    beside = path - begins[gap]
    share = np.clip((beside * ways[gap]).sum(axis=1) / lengths[gap], 0.0, 1.0)
    beside -= share[:, None] * ways[gap]
    far = np.zeros(len(ways), dtype=bool)
    far[gap[np.linalg.norm(beside, axis=1) > most]] = True
    return np.asarray(far[gap])
