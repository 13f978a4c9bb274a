from enum import StrEnum

import numpy as np
from numpy.typing import NDArray

from ipoa_mission.geometry import Vector

WOULD_SHARE = 0.5  # of the possible times with a shortfall
DEVIATIONS_OF_90 = 1.645  # 90 % of a normal distribution, in standard deviations


class Grade(StrEnum):
    """`CLEAR`: each possible flight keeps the required distance. `MAY`: some do not.

    `WOULD`: the predicted path does not, at half or more of the possible times. `UNKNOWN`: the path is unknown.
    """

    CLEAR = "clear"
    MAY = "perhaps not clear"
    WOULD = "not clear"
    UNKNOWN = "unknown"


def clear_at_any_time(times: Vector, clear: NDArray[np.bool_], tolerances: Vector) -> NDArray[np.bool_]:
    """Return whether each time (n,) is clear, early or late by `tolerances` [s]."""
    unclear = times[~clear]
    after = np.searchsorted(unclear, times - tolerances, side="left")
    return np.asarray(after == np.searchsorted(unclear, times + tolerances, side="right"))


def share_nearer(times: Vector, tolerances: Vector, evenly: Vector, nearer: NDArray[np.bool_]) -> Vector:
    """Return the share of possible times with a shortfall, at each of `times` (n,).

    `tolerances` (n,) contain nine cases of ten, and limit all.

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
