"""A path with its times, predicted or flown."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ipoa_mission.geometry import Points, Vector, arc_lengths
from ipoa_mission.world.ground import EARTH_RADIUS

BATCH_SIZE = 20_000  # points, limited by memory
TIME_TOLERANCE_S = 1e-9  # [s]
MIN_SQUARED_LENGTH = 1e-12  # [m^2]
BOTH_VIEWS_FACTOR = 1.5  # of the tolerance of one view
THINNING_TOLERANCE = 0.02  # [m]


@dataclass(frozen=True, eq=False)
class Track:
    """Times (n,) from arming [s], points (n, 3) east, north, up [m], ground speeds (n,) [m/s]."""

    times: Vector
    points: Points
    speeds: Vector

    @classmethod
    def of(cls, samples: Points, times: Vector | None = None) -> "Track":
        """Make a track of samples (n, 7) of time, place and velocity; copy all, so that they can be freed."""
        own = samples[:, 0] if times is None else times
        return cls(own.copy(), samples[:, 1:4].copy(), np.linalg.norm(samples[:, 4:7], axis=1))

    @classmethod
    def joined(cls, tracks: "Sequence[Track]") -> "Track":
        times = np.concatenate([one.times for one in tracks])
        later = np.concatenate([[True], np.diff(times) > TIME_TOLERANCE_S])
        points, speeds = (np.concatenate([getattr(one, name) for one in tracks]) for name in ("points", "speeds"))
        return cls(times[later], points[later], speeds[later])

    def at(self, times: Vector) -> Points:
        return np.column_stack([np.interp(times, self.times, axis) for axis in self.points.T])

    def nearest(self, time: float) -> int:
        return int(np.argmin(np.abs(self.times - time)))

    def between(self, begin: float, end: float) -> "Track":
        first, last = np.searchsorted(self.times, begin, "left"), np.searchsorted(self.times, end, "right")
        taken = slice(first, last)
        return Track(self.times[taken], self.points[taken], self.speeds[taken])

    def local(self) -> "Track":
        """Convert `up` from a round Earth to home's tangent plane."""
        sunk = self.points.copy()
        sunk[:, 2] -= (sunk[:, 0] ** 2 + sunk[:, 1] ** 2) / (2 * EARTH_RADIUS)
        return Track(self.times, sunk, self.speeds)


def thinned(path: Points, stray: float = THINNING_TOLERANCE) -> Points:
    """Thin the path (n, 3) to within about `stray` [m]."""
    if len(path) < 3:
        return path
    import shapely  # imported only where a world is used

    traveled = arc_lengths(path[:, :2])
    is_kept = np.zeros(len(path), dtype=bool)
    is_kept[0] = True
    for first in range(0, len(path) - 1, BATCH_SIZE):
        some = slice(first, first + BATCH_SIZE + 1)
        numbers = np.arange(len(path))[some]
        top_view, side_view = path[some, :2], np.column_stack([traveled[some], path[some, 2]])
        for view in (top_view, side_view):
            numbered = shapely.linestrings(np.column_stack([view, numbers]))
            few = shapely.simplify(numbered, stray, preserve_topology=False)  # checked by `_folded`
            is_kept[shapely.get_coordinates(few, include_z=True)[:, 2].astype(int)] = True
        is_kept[some] |= _folded(path[some], np.flatnonzero(is_kept[some]), BOTH_VIEWS_FACTOR * stray)
    return np.asarray(path[is_kept])


def _folded(path: Points, kept: NDArray[np.intp], most: float) -> NDArray[np.bool_]:
    """Return the points between two kept ones whose leg folds beyond `most` [m]."""
    gap = np.clip(np.searchsorted(kept, np.arange(len(path)), "right") - 1, 0, len(kept) - 2)
    begins, ways = path[kept], np.diff(path[kept], axis=0)
    lengths = np.maximum((ways**2).sum(axis=1), MIN_SQUARED_LENGTH)
    offset = path - begins[gap]
    share = np.clip((offset * ways[gap]).sum(axis=1) / lengths[gap], 0.0, 1.0)
    offset -= share[:, None] * ways[gap]
    far = np.zeros(len(ways), dtype=bool)
    far[gap[np.linalg.norm(offset, axis=1) > most]] = True
    return np.asarray(far[gap])
