from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_array, csr_array, eye_array, kron

from ipoa_mission.geometry import Vector
from ipoa_mission.planning.problem import Matrix


@dataclass(frozen=True, eq=False)
class Spread:
    """The basis `ways` (coordinates, free), its transpose `turned`, and the map from the full to the reduced band."""

    ways: csr_array
    turned: csr_array
    reach: int
    cells: csr_array

    def reduced(self, gradient: Vector, band: Matrix) -> tuple[Vector, Matrix]:
        summed = self.cells @ band.ravel()
        return np.asarray(self.turned @ gradient), np.asarray(summed).reshape(self.reach + 1, -1)


def spread_of(ways: Matrix, band: int) -> Spread:
    """Return the reduction for moves (n, f), with Hessian band width `band`.

    The Hessian H becomes ways^T H ways; each pair of entries counts once, off the diagonal both ways.
    """
    spread = csr_array(kron(csr_array(ways), eye_array(3)))
    size, free = spread.shape
    below, column = np.divmod(np.arange((band + 1) * size), size)
    inside = below + column < size  # row j + k, column j
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
