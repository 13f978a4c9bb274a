"""How sure it is that an ending keeps what is required: clear, perhaps not, or not."""

from enum import StrEnum

import numpy as np
from numpy.typing import NDArray

from ipoa_mission.geometry import Vector

LIKELY = 0.5  # from this share of the times on at which the vehicle may be there, it is taken to come nearer
SPREADS = 1.645  # nine in ten of a normal distribution lie within so many standard deviations of its mean


class Grade(StrEnum):
    """Of one ending at one time.

    `CLEAR`: whatever of its spread the flight does, it keeps what is required. `MAY`: some of that comes nearer, being
    beside its way by the tube, or early or late. `WOULD`: the predicted way itself does, at half or more of the times
    at which the vehicle may be there. `UNKNOWN`: nobody knows where it leads.
    """

    CLEAR = "clear"
    MAY = "perhaps not clear"
    WOULD = "not clear"
    UNKNOWN = "unknown"


def clear_at_any_time(times: Vector, clear: NDArray[np.bool_], doubts: Vector) -> NDArray[np.bool_]:
    """Whether each (n,) is clear however early or late the vehicle is, by `doubts` at most: none that soon is not."""
    unclear = times[~clear]
    after = np.searchsorted(unclear, times - doubts, side="left")
    return np.asarray(after == np.searchsorted(unclear, times + doubts, side="right"))


def share_nearer(times: Vector, doubts: Vector, evenly: Vector, nearer: NDArray[np.bool_]) -> Vector:
    """At which share of the times at which the vehicle may be there it comes nearer, at each of `times` (n,).

    It is early or late by `doubts` (n,) in nine cases of ten, and never by more; `nearer` (m,) is so at times that are
    `evenly` spaced, (m,).

    >>> share_nearer(np.array([5.0, 20.0]), np.full(2, 2.0), np.arange(0.0, 30.0), np.arange(30) < 5).round(2)
    array([0.33, 0.  ])
    """
    off = (evenly[None, :] - times[:, None]) / doubts[:, None]
    weights = np.where(np.abs(off) <= 1.0, np.exp(-((SPREADS * off) ** 2) / 2.0), 0.0)
    return np.asarray((weights * nearer).sum(axis=1) / np.maximum(weights.sum(axis=1), 1e-12))


def graded(clear: NDArray[np.bool_], shares: Vector) -> list[Grade]:
    """What follows of both, (n,)."""
    return [
        Grade.CLEAR if one else Grade.WOULD if share >= LIKELY else Grade.MAY
        for one, share in zip(clear, shares, strict=True)
    ]
