from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ipoa_mission.geodesy import EARTH_RADIUS
from ipoa_mission.geometry import Matrix, Points, Samples, Vector, arc_lengths

THINNING_TOLERANCE = 0.02  # [m]


def interpolate(at: Vector, positions: Vector, points: Matrix) -> Matrix:
    """Return the points (k, d) at `at` (k,), linear between points (n, d) at increasing `positions` (n,)."""
    return np.column_stack([np.interp(at, positions, axis) for axis in points.T])


@dataclass(frozen=True, eq=False)
class Track:
    """Times (n,) from arming [s], points (n, 3) east, north, up [m], ground speeds (n,) [m/s]."""

    times: Vector
    points: Points
    speeds: Vector

    @classmethod
    def of(cls, samples: Samples, times: Vector | None = None) -> "Track":
        """Copy samples, so that they can be freed."""
        times = samples[:, 0] if times is None else times
        return cls(times.copy(), samples[:, 1:4].copy(), np.linalg.norm(samples[:, 4:7], axis=1))

    @classmethod
    def joined(cls, parts: Sequence[Samples]) -> "Track":
        samples = np.concatenate(parts)
        return cls.of(samples[np.concatenate([[True], np.diff(samples[:, 0]) > 1e-9])])

    def without_repeated_times(self) -> "Track":
        is_last = np.append(np.diff(self.times) > 0, True)
        return Track(self.times[is_last], self.points[is_last], self.speeds[is_last])

    def at(self, times: Vector) -> Points:
        return interpolate(times, self.times, self.points)

    def nearest(self, time: float) -> int:
        return int(np.argmin(np.abs(self.times - time)))

    def between(self, begin: float, end: float) -> "Track":
        span = slice(np.searchsorted(self.times, begin, "left"), np.searchsorted(self.times, end, "right"))
        return Track(self.times[span], self.points[span], self.speeds[span])

    def local(self) -> "Track":
        """Convert `up` from a round Earth to home's tangent plane."""
        sunk = self.points.copy()
        sunk[:, 2] -= (sunk[:, 0] ** 2 + sunk[:, 1] ** 2) / (2 * EARTH_RADIUS)
        return Track(self.times, sunk, self.speeds)


def thinned(path: Points, tolerance: float = THINNING_TOLERANCE) -> Points:
    """Thin the path to within about `tolerance` [m]."""
    if len(path) < 3:
        return path
    import shapely  # imported only where a world is used

    traveled = arc_lengths(path[:, :2])
    is_kept = np.zeros(len(path), dtype=bool)
    is_kept[0] = True
    batch_size = 20_000  # points, limited by memory
    for first in range(0, len(path) - 1, batch_size):
        batch = slice(first, first + batch_size + 1)
        numbers = np.arange(len(path))[batch]
        top_view = path[batch, :2]
        side_view = np.column_stack([traveled[batch], path[batch, 2]])
        for view in (top_view, side_view):
            numbered = shapely.linestrings(np.column_stack([view, numbers]))
            few = shapely.simplify(numbered, tolerance, preserve_topology=False)  # checked by `_folded`
            is_kept[shapely.get_coordinates(few, include_z=True)[:, 2].astype(int)] = True
        is_kept[batch] |= _folded(path[batch], np.flatnonzero(is_kept[batch]), 1.5 * tolerance)
    return np.asarray(path[is_kept])


def _folded(path: Points, kept: NDArray[np.intp], most: float) -> NDArray[np.bool_]:
    """Return the points between two kept ones whose leg folds beyond `most` [m]."""
    gap = np.clip(np.searchsorted(kept, np.arange(len(path)), "right") - 1, 0, len(kept) - 2)
    begins, steps = path[kept], np.diff(path[kept], axis=0)
    lengths = np.maximum((steps**2).sum(axis=1), 1e-12)
    offset = path - begins[gap]
    share = np.clip((offset * steps[gap]).sum(axis=1) / lengths[gap], 0.0, 1.0)
    offset -= share[:, None] * steps[gap]
    far = np.zeros(len(steps), dtype=bool)
    far[gap[np.linalg.norm(offset, axis=1) > most]] = True
    return np.asarray(far[gap])


@dataclass(frozen=True, eq=False)
class Pieces(Track):
    """Short straight pieces, with the lateral acceleration `lateral_accel` of each, (n-1,) [m/s^2].

    `excess`: deviation by noise beyond the vehicle's law, to a side, below and above (n-1, 3) [m].
    """

    lateral_accel: Vector
    excess: Points

    def part(self, begin: float, end: float) -> "Pieces":
        first = max(int(np.searchsorted(self.times, begin, side="right")) - 1, 0)
        last = min(int(np.searchsorted(self.times, end, side="left")), len(self.times) - 1)
        first = min(first, len(self.times) - 2)
        last = max(last, first + 1)
        flown = slice(first, last + 1)
        each = slice(first, last)
        return Pieces(
            self.times[flown], self.points[flown], self.speeds[flown], self.lateral_accel[each], self.excess[each]
        )


def pieces_of(track: Track, excess: Points | None = None) -> Pieces:
    shortest = 0.05  # [m]
    is_kept = np.concatenate([[True], np.diff(np.floor(arc_lengths(track.points) / shortest)) > 0.0])
    is_kept[-1] = True
    kept = np.flatnonzero(is_kept) if is_kept.sum() > 1 else np.zeros(2, dtype=int)
    times = track.times[kept]
    middles = (times[:-1] + times[1:]) / 2
    lateral_accel = np.interp(middles, *_lateral_accels(track))
    wider = np.zeros((len(middles), 3))
    if excess is not None:
        wider = interpolate(middles, track.times, excess)
    return Pieces(times, track.points[kept], track.speeds[kept], lateral_accel, wider)


def _lateral_accels(track: Track) -> tuple[Vector, Vector]:
    begin = float(track.times[0])
    end = float(track.times[-1])
    step_s = 0.1
    smoothed = 5
    reach_s = 2.0
    times = np.arange(begin, max(end, begin + smoothed * step_s) + step_s, step_s)
    horizontal = track.at(times)[:, :2]
    mean = np.full(smoothed, 1 / smoothed)
    speeds = [np.gradient(axis, step_s) for axis in horizontal.T]
    accels = [np.convolve(np.gradient(speed, step_s), mean, "same") for speed in speeds]
    lateral = np.abs(speeds[0] * accels[1] - speeds[1] * accels[0]) / np.maximum(np.hypot(*speeds), 0.5)
    reach = round(reach_s / step_s)
    near = np.lib.stride_tricks.sliding_window_view(np.pad(lateral, reach), 2 * reach + 1)
    return times, near.max(axis=1)
