"""Steps that leave places to pass where they are: how what is free spreads over all control points, sparsely."""

from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_array, csr_array, eye_array, kron

from ipoa_mission.geometry import Vector
from ipoa_mission.planning.problem import Matrix


@dataclass(frozen=True, eq=False)
class Spread:
    """The ways (coordinates, free), the same turned round, and the band by what is free as a sum of cells of the other.

    `reach` is how many lower diagonals that band has, (reach + 1, free); `cells` (its cells, the other's) are the sums.
    """

    ways: csr_array
    turned: csr_array
    reach: int
    cells: csr_array

    def reduced(self, gradient: Vector, band: Matrix) -> tuple[Vector, Matrix]:
        """Gradient and lower band of the Hessian by what is free, from those by all coordinates."""
        summed = self.cells @ band.ravel()
        return np.asarray(self.turned @ gradient), np.asarray(summed).reshape(self.reach + 1, -1)


def spread_of(ways: Matrix, band: int) -> Spread:
    """How control points move (n, f) where coordinates farther apart than `band` share no term.

    The Hessian H of all coordinates becomes ways^T H ways, and a cell of H adds to those cells of it that the rows of
    `ways` at its own row and column name: each pair of entries once, of a cell beside the diagonal both ways round.
    """
    spread = csr_array(kron(csr_array(ways), eye_array(3)))
    size, free = spread.shape
    below, column = np.divmod(np.arange((band + 1) * size), size)
    inside = below + column < size  # of band[k, j], the Hessian's row j + k and column j
    cell, below, column = np.arange(len(below))[inside], below[inside], column[inside]
    many = np.diff(spread.indptr)
    pairs = many[column + below] * many[column]
    number = np.arange(pairs.sum()) - np.repeat(np.cumsum(pairs) - pairs, pairs)
    cell, below, column = (np.repeat(one, pairs) for one in (cell, below, column))
    one = spread.indptr[column + below] + number // many[column]
    other = spread.indptr[column] + number % many[column]
    a, b = spread.indices[one].astype(np.intp), spread.indices[other].astype(np.intp)
    weight = np.where(a == b, 2.0, 1.0) * np.where(below == 0, 0.5, 1.0) * spread.data[one] * spread.data[other]
    beside, first = np.abs(a - b), np.minimum(a, b)
    reach = int(beside.max(initial=0))
    cells = coo_array((weight, (beside * free + first, cell)), ((reach + 1) * free, (band + 1) * size))
    return Spread(spread, csr_array(spread.T), reach, csr_array(cells))
