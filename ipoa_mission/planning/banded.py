"""Compiled solver of linear equations with a symmetric banded matrix.

Importing SciPy takes longer than all equations of a plan; the bits are LAPACK's for narrow bands.
"""

# mypy: disable-error-code="no-untyped-def,misc"

import math

from ipoa_mission.compiled import njit


@njit(cache=True, error_model="numpy")
def solve_banded(band, right):
    """Solve H x = `right` (n,) by Cholesky; return x and 1, or 0 if H is not positive definite.

    `band` (k + 1, n) is the lower band of H: `band[i - j, j]` is its element i, j.
    """
    reach = band.shape[0] - 1
    n = band.shape[1]
    low = band.T.copy()
    x = right.copy()
    for j in range(n):
        if not low[j, 0] > 0.0:
            return x, 0
        low[j, 0] = math.sqrt(low[j, 0])
        share = 1.0 / low[j, 0]
        below = min(reach, n - 1 - j)
        for i in range(1, below + 1):
            low[j, i] *= share
        for k in range(1, below + 1):
            for i in range(k, below + 1):
                low[j + k, i - k] -= low[j, k] * low[j, i]
    for j in range(n):
        x[j] /= low[j, 0]
        for i in range(1, min(reach, n - 1 - j) + 1):
            x[j + i] -= x[j] * low[j, i]
    for j in range(n - 1, -1, -1):
        total = 0.0
        for i in range(1, min(reach, n - 1 - j) + 1):
            total += low[j, i] * x[j + i]
        x[j] = (x[j] - total) / low[j, 0]
    return x, 1
