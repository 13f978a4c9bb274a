"""The not-a-knot cubic spline (de Boor); importing SciPy's takes longer than the rest of an estimate."""

import numpy as np

from ipoa_mission.geometry import Points, Vector


def derivatives(knots: Vector, points: Points, at: Vector) -> tuple[Points, Points]:
    """Return first and second derivative, each (m, d), at `at` (m,), of the spline of `points` (n, d).

    `knots` (n,) must increase, n > 2.

    >>> first, second = derivatives(np.array([0.0, 1.0, 3.0]), np.array([[0.0], [1.0], [9.0]]), np.array([2.0]))
    >>> float(first[0, 0]), float(second[0, 0])
    (4.0, 2.0)
    """
    h, _, slope, square, cube = _pieces(knots, points, at)
    return slope + (2 * square + 3 * cube * h) * h, 2 * square + 6 * cube * h


def values(knots: Vector, points: Points, at: Vector) -> Points:
    h, point, slope, square, cube = _pieces(knots, points, at)
    return point + (slope + (square + cube * h) * h) * h


def _pieces(knots: Vector, points: Points, at: Vector) -> tuple[Points, Points, Points, Points, Points]:
    """Return h (m, 1), and the coefficients of 1, h, h^2, h^3 (m, d)."""
    steps = np.diff(knots)
    chords = np.diff(points, axis=0) / steps[:, None]
    slopes = _slopes(knots, steps, chords)
    piece = np.clip(np.searchsorted(knots, at, side="right") - 1, 0, len(steps) - 1)
    step = steps[piece][:, None]
    bend = (slopes[piece] + slopes[piece + 1] - 2 * chords[piece]) / step
    square = (chords[piece] - slopes[piece]) / step - bend
    return (at - knots[piece])[:, None], points[piece], slopes[piece], square, bend / step


def _slopes(knots: Vector, steps: Vector, chords: Points) -> Points:
    n = len(knots)
    below, middle, above = np.zeros(n), np.ones(n), np.zeros(n)
    right = np.zeros((n, chords.shape[1]))
    below[1:-1], middle[1:-1], above[1:-1] = steps[1:], 2 * (steps[:-1] + steps[1:]), steps[:-1]
    right[1:-1] = 3 * (steps[1:, None] * chords[:-1] + steps[:-1, None] * chords[1:])
    if n == 3:  # a parabola
        above[0] = below[-1] = 1.0
        right[0], right[-1] = 2 * chords[0], 2 * chords[-1]
    else:
        begin, end = knots[2] - knots[0], knots[-1] - knots[-3]
        middle[0], above[0] = steps[1], begin
        right[0] = ((steps[0] + 2 * begin) * steps[1] * chords[0] + steps[0] ** 2 * chords[1]) / begin
        middle[-1], below[-1] = steps[-2], end
        right[-1] = (steps[-1] ** 2 * chords[-2] + (2 * end + steps[-1]) * steps[-2] * chords[-1]) / end
    return np.column_stack([_solve(below.tolist(), middle.tolist(), above.tolist(), axis.tolist()) for axis in right.T])


def _solve(below: list[float], middle: list[float], above: list[float], right: list[float]) -> list[float]:
    n = len(right)
    for i in range(1, n):
        factor = below[i] / middle[i - 1]
        middle[i] -= factor * above[i - 1]
        right[i] -= factor * right[i - 1]
    right[-1] /= middle[-1]
    for i in range(n - 2, -1, -1):
        right[i] = (right[i] - above[i] * right[i + 1]) / middle[i]
    return right
