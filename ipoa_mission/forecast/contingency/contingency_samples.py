"""Between two clear times no path moves farther than the slack of both."""

from collections.abc import Sequence
from dataclasses import dataclass, fields
from enum import IntEnum
from functools import reduce
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from ipoa_mission.forecast.timing.track import interpolate
from ipoa_mission.geometry import Matrix, Points, Vector

Paths: TypeAlias = NDArray[np.float64]  # (n, k, p, 3) [m]
Distances: TypeAlias = NDArray[np.float64]  # of legs (n, k, p - 1) [m]
ObstacleIndices: TypeAlias = NDArray[np.intp]  # nearest to legs, by index (n, k, p - 1)


@dataclass(frozen=True)
class Sampling:
    step_s: float = 1.0
    min_step_s: float = 0.05
    batch_size: int = 5_000  # limited by memory
    max_slack: float = 8.0  # greater slack is not distinguished [m]
    position_error: float = 10.0  # of the vehicle as it chooses its goal [m]
    chord_error: float = 0.02  # of the flown path to the lines between its sampled places [m]


class ReturnLeg(IntEnum):
    BRAKES = 0
    TURNS_BACK = 1
    CLIMBS = 2
    RETURNS = 3
    DESCENDS = 4


SAMPLING = Sampling()
GROUND = -2  # among the indices of obstacles; -1 is nothing


@dataclass(frozen=True, eq=False)
class StoppingPoints:
    """Places (n, 3) at `times` (n,) [s] on the way to items `seqs`; `stops`, and LAND's `farthest` ones."""

    times: Vector
    places: Points
    stops: Points
    seqs: NDArray[np.intp]
    farthest: Points

    def seqs_at(self, times: Vector) -> NDArray[np.intp]:
        return np.asarray(self.seqs[np.clip(np.searchsorted(self.times, times), 0, len(self.seqs) - 1)])

    def at(self, times: Vector) -> tuple[Points, Points]:
        return interpolate(times, self.times, self.places), interpolate(times, self.times, self.stops)


@dataclass(frozen=True, eq=False)
class ContingencySamples:
    """One contingency, ordered at each of `times` (n,) [s after arming].

    `possible` (n, k): whether a path may be flown. `near`, `which`: the thing nearest to a leg; infinite, -1 for none.
    `slack` (n,): to the required distance [m]. `excess` (n, 2): deviation beyond the law, to a side, in height [m].
    """

    times: Vector
    paths: Paths
    possible: NDArray[np.bool_]
    near: Distances
    which: ObstacleIndices
    slack: Vector
    excess: Matrix

    @property
    def clear(self) -> NDArray[np.bool_]:
        return np.asarray(self.slack >= 0.0)

    @property
    def same_as_next(self) -> NDArray[np.bool_]:
        possible, clear = self.possible, self.clear
        return np.asarray((possible[1:] == possible[:-1]).all(axis=1) & (clear[1:] == clear[:-1]))

    def gaps(self) -> Vector:
        """Return the middle of each interval that may hide a shortfall [s]."""
        places = np.moveaxis(self.paths, 2, 0)
        steps = (np.linalg.norm(np.diff(place, axis=0), axis=-1) for place in places)
        moved = np.where(self.possible[1:] | self.possible[:-1], reduce(np.maximum, steps), 0.0).max(axis=1)

        may_hide = self.clear[:-1] & (self.slack[1:] + self.slack[:-1] < moved)
        is_divided = may_hide | ~self.same_as_next | self._next_to_nearest()
        is_divided &= np.diff(self.times) > SAMPLING.min_step_s
        return np.asarray((self.times[1:] + self.times[:-1])[is_divided] / 2)

    def _next_to_nearest(self) -> NDArray[np.bool_]:
        is_beside = np.zeros(len(self.times), dtype=bool)
        for run in np.split(np.arange(len(self.times)), np.flatnonzero(~self.same_as_next) + 1):
            least = run[np.argmin(self.slack[run])]
            is_beside[max(least - 1, 0) : least + 1] = self.slack[least] < SAMPLING.max_slack
        return is_beside[:-1]

    @classmethod
    def merge(cls, parts: "Sequence[ContingencySamples]") -> "ContingencySamples":
        order = np.argsort(np.concatenate([part.times for part in parts]), kind="stable")
        merged = {f.name: np.concatenate([getattr(part, f.name) for part in parts]) for f in fields(cls)}
        return cls(**{name: values[order] for name, values in merged.items()})
