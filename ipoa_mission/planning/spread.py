"""Steps that leave places to pass where they are: how what is free spreads over all control points, sparsely."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array, diags_array, eye_array, kron

from ipoa_mission.geometry import Vector
from ipoa_mission.planning.problem import Matrix


@dataclass(frozen=True, eq=False)
class Spread:
    """The ways (coordinates, free), the same turned round, and where in a sparse matrix each cell of a band stands."""

    ways: csr_array
    turned: csr_array
    reach: int
    cells: NDArray[np.intp]
    columns: NDArray[np.int32]
    starts: NDArray[np.int32]

    def reduced(self, gradient: Vector, band: Matrix) -> tuple[Vector, Matrix]:
        """Gradient and lower band of the Hessian by what is free, from those by all coordinates."""
        halves = band.copy()
        halves[0] /= 2.0  # the Hessian is this triangle and its transpose
        size, free = self.ways.shape
        lower = csr_array((halves.ravel()[self.cells], self.columns, self.starts), shape=(size, size))
        half = (self.turned @ lower @ self.ways).tocoo()
        beside, first = np.abs(half.row - half.col), np.minimum(half.row, half.col)
        twice = np.where(beside == 0, 2.0, 1.0)
        summed = np.bincount(beside * free + first, twice * half.data, minlength=(self.reach + 1) * free)
        return np.asarray(self.turned @ gradient), summed.reshape(self.reach + 1, free).astype(float)


def spread_of(ways: Matrix, band: int) -> Spread:
    """How control points move (n, f) where coordinates farther apart than `band` share no term."""
    spread = csr_array(kron(csr_array(ways), eye_array(3)))
    size = spread.shape[0]
    near = diags_array(np.ones(2 * band + 1), offsets=np.arange(-band, band + 1), shape=(size, size))
    pairs = (abs(spread).T @ near @ abs(spread)).tocoo()
    row, below = np.mgrid[:size, -band:1]
    column = row + below
    inside = column >= 0
    cells = (-below * size + column)[inside]  # of band[k, j], the Hessian's row j + k and column j
    starts = np.concatenate([[0], np.cumsum(inside.sum(axis=1))]).astype(np.int32)
    reach = int(np.max(pairs.row - pairs.col, initial=0))
    return Spread(spread, csr_array(spread.T), reach, cells, column[inside].astype(np.int32), starts)
