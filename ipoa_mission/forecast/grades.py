"""Grade how surely a contingency keeps the required distance: clear, perhaps not, or not."""

from enum import StrEnum

import numpy as np
from numpy.typing import NDArray

from ipoa_mission.geometry import Vector

WOULD_SHARE = 0.5  # share of the possible times with a shortfall, from which the grade is `WOULD`
DEVIATIONS_OF_90 = 1.645  # nine in ten of a normal distribution are within this many standard deviations of its mean


class Grade(StrEnum):
    """The grade of a contingency at one time.

    `CLEAR`: each possible flight keeps the required distance. `MAY`: some do not, by their deviation or timing.
    `WOULD`: the predicted path does not, at half or more of the times at which the vehicle may be there. `UNKNOWN`: the
    path is unknown.
    """

    CLEAR = "clear"
    MAY = "perhaps not clear"
    WOULD = "not clear"
    UNKNOWN = "unknown"


def clear_at_any_time(times: Vector, clear: NDArray[np.bool_], tolerances: Vector) -> NDArray[np.bool_]:
    """Return whether each time (n,) is clear with the vehicle early or late by up to `tolerances` [s]."""
    unclear = times[~clear]
    after = np.searchsorted(unclear, times - tolerances, side="left")
    return np.asarray(after == np.searchsorted(unclear, times + tolerances, side="right"))


def share_nearer(times: Vector, tolerances: Vector, evenly: Vector, nearer: NDArray[np.bool_]) -> Vector:
    """Return the share of possible times with a shortfall, at each of `times` (n,).

    The vehicle is early or late by `tolerances` (n,) in nine cases of ten, and never by more. `nearer` (m,) is the
    shortfall at `evenly` spaced times (m,).

    >>> share_nearer(np.array([5.0, 20.0]), np.full(2, 2.0), np.arange(0.0, 30.0), np.arange(30) < 5).round(2)
    array([0.33, 0.  ])
    """
    off = (evenly[None, :] - times[:, None]) / tolerances[:, None]
    weights = np.where(np.abs(off) <= 1.0, np.exp(-((DEVIATIONS_OF_90 * off) ** 2) / 2.0), 0.0)
    return np.asarray((weights * nearer).sum(axis=1) / np.maximum(weights.sum(axis=1), 1e-12))


def graded(clear: NDArray[np.bool_], shares: Vector) -> list[Grade]:
    return [
        Grade.CLEAR if one else Grade.WOULD if share >= WOULD_SHARE else Grade.MAY
        for one, share in zip(clear, shares, strict=True)
    ]
