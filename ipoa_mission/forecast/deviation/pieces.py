"""Cut the predicted path into short straight pieces."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ipoa_mission.forecast.timing.track import Track
from ipoa_mission.geometry import Points, Vector, arc_lengths

SAMPLE_STEP_S = 0.1
SMOOTHED_SAMPLES = 5
BEND_REACH_S = 2.0  # in which a bend widens the deviation bound [s]
SHORTEST_PIECE = 0.05  # [m]


@dataclass(frozen=True, eq=False)
class Pieces(Track):
    """With the lateral acceleration `across` of each piece, (n-1,) [m/s^2]."""

    across: Vector

    def part(self, begin: float, end: float) -> "Pieces":
        first = max(int(np.searchsorted(self.times, begin, side="right")) - 1, 0)
        last = min(int(np.searchsorted(self.times, end, side="left")), len(self.times) - 1)
        first = min(first, len(self.times) - 2)
        last = max(last, first + 1)
        flown = slice(first, last + 1)
        return Pieces(self.times[flown], self.points[flown], self.speeds[flown], self.across[first:last])


def pieces_of(track: Track) -> Pieces:
    kept = _apart(track.points)
    kept = kept if len(kept) > 1 else np.zeros(2, dtype=int)
    times, times_and_bends = track.times[kept], _bends(track)
    across = np.interp((times[:-1] + times[1:]) / 2, *times_and_bends)
    return Pieces(times, track.points[kept], track.speeds[kept], across)


def _apart(points: Points) -> NDArray[np.intp]:
    reached = np.floor(arc_lengths(points) / SHORTEST_PIECE)
    is_kept = np.concatenate([[True], np.diff(reached) > 0.0])
    is_kept[-1] = True
    return np.flatnonzero(is_kept)


def _bends(track: Track) -> tuple[Vector, Vector]:
    """Return times [s] and the greatest lateral acceleration around each [m/s^2]."""
    begin, end = float(track.times[0]), float(track.times[-1])
    times = np.arange(begin, max(end, begin + SMOOTHED_SAMPLES * SAMPLE_STEP_S) + SAMPLE_STEP_S, SAMPLE_STEP_S)
    level = track.at(times)[:, :2]
    mean = np.full(SMOOTHED_SAMPLES, 1 / SMOOTHED_SAMPLES)
    speeds = [np.gradient(axis, SAMPLE_STEP_S) for axis in level.T]
    gains = [np.convolve(np.gradient(speed, SAMPLE_STEP_S), mean, "same") for speed in speeds]
    cross = np.abs(speeds[0] * gains[1] - speeds[1] * gains[0])
    across = cross / np.maximum(np.hypot(*speeds), 0.5)
    return times, _greatest_near(across, round(BEND_REACH_S / SAMPLE_STEP_S))


def _greatest_near(values: Vector, reach: int) -> Vector:
    greatest, seen, width = np.pad(values, reach), 1, 2 * reach + 1
    while seen < width:
        more = min(seen, width - seen)
        greatest, seen = np.maximum(greatest[:-more], greatest[more:]), seen + more
    return greatest
