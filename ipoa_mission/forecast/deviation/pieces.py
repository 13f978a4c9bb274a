"""The predicted path cut into what the tube is laid round: short straight pieces, each with its time and its bend."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ipoa_mission.forecast.timing.track import Track
from ipoa_mission.geometry import Points, Vector, arc_lengths

LOOK_EVERY_S = 0.1  # between the looks at how a path bends [s]
SMOOTHED_LOOKS = 5  # looks over which an acceleration is averaged
BEND_REACH_S = 2.0  # a bend widens the tube for so long before and after it [s]
SHORTEST_PIECE = 0.05  # pieces that are shorter are joined to the next [m]


@dataclass(frozen=True, eq=False)
class Pieces(Track):
    """A track and, of each piece between two of its points, the lateral acceleration `across`, (n-1,) [m/s^2]."""

    across: Vector

    def part(self, begin: float, end: float) -> "Pieces":
        """The pieces that are flown between two times [s]; at least one."""
        first = max(int(np.searchsorted(self.times, begin, side="right")) - 1, 0)
        last = min(int(np.searchsorted(self.times, end, side="left")), len(self.times) - 1)
        first = min(first, len(self.times) - 2)
        last = max(last, first + 1)
        flown = slice(first, last + 1)
        return Pieces(self.times[flown], self.points[flown], self.speeds[flown], self.across[first:last])


def pieces_of(track: Track) -> Pieces:
    """The pieces of a predicted path; one at least."""
    kept = _apart(track.points)
    kept = kept if len(kept) > 1 else np.zeros(2, dtype=int)
    times, looks_and_bends = track.times[kept], _bends(track)
    across = np.interp((times[:-1] + times[1:]) / 2, *looks_and_bends)
    return Pieces(times, track.points[kept], track.speeds[kept], across)


def _apart(points: Points) -> NDArray[np.intp]:
    """Numbers of points that are so far from the one kept before that a piece between them is worth having."""
    reached = np.floor(arc_lengths(points) / SHORTEST_PIECE)
    is_kept = np.concatenate([[True], np.diff(reached) > 0.0])
    is_kept[-1] = True
    return np.flatnonzero(is_kept)


def _bends(track: Track) -> tuple[Vector, Vector]:
    """Times, and the greatest lateral acceleration round each of them [m/s^2]."""
    begin, end = float(track.times[0]), float(track.times[-1])
    assessments = np.arange(begin, max(end, begin + SMOOTHED_LOOKS * LOOK_EVERY_S) + LOOK_EVERY_S, LOOK_EVERY_S)
    level = track.at(assessments)[:, :2]
    mean = np.full(SMOOTHED_LOOKS, 1 / SMOOTHED_LOOKS)
    speeds = [np.gradient(axis, LOOK_EVERY_S) for axis in level.T]
    gains = [np.convolve(np.gradient(speed, LOOK_EVERY_S), mean, "same") for speed in speeds]
    cross = np.abs(speeds[0] * gains[1] - speeds[1] * gains[0])
    across = cross / np.maximum(np.hypot(*speeds), 0.5)
    return assessments, _greatest_near(across, round(BEND_REACH_S / LOOK_EVERY_S))


def _greatest_near(values: Vector, reach: int) -> Vector:
    """The greatest of each value (n,), none of them negative, and `reach` more on either side of it."""
    greatest, seen, asked = np.pad(values, reach), 1, 2 * reach + 1
    while seen < asked:  # of twice as many each time
        more = min(seen, asked - seen)
        greatest, seen = np.maximum(greatest[:-more], greatest[more:]), seen + more
    return greatest
