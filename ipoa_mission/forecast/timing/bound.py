"""Compute the least time along a curve, limited by speed, acceleration and jerk.

The curve is a not-a-knot cubic spline (de Boor); importing SciPy's takes longer than the rest of an estimate.
Time-optimal path parametrisation in two passes (Bobrow et al.). Jerk counts only at both ends.
"""

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ipoa_mission.errors import BadInput
from ipoa_mission.geometry import Matrix, Points, Vector, arc_lengths, leg_lengths


class Kinematics(NamedTuple):
    """Speeds horizontal, up and down [m/s], acceleration along and across the path (an ellipse) and jerk."""

    speed: float
    climb: float
    descent: float
    accel: float
    jerk: float = np.inf
    across: float | None = None

    @property
    def accel_across(self) -> float:
        return self.accel if self.across is None else self.across


@dataclass(frozen=True)
class Bound:
    seconds: float
    lengths: Vector
    speeds: Vector


def least_time(points: Points, kinematics: Kinematics) -> Bound:
    """Return the least time along the cubic spline through points, from rest to rest.

    Raises:
        BadInput: fewer than two different points, or a limit that is not positive.
    """
    for name in ("speed", "climb", "descent", "accel", "jerk"):
        if not getattr(kinematics, name) > 0:
            raise BadInput(f"expected more than 0, not {getattr(kinematics, name):g}", place=name)
    points = np.asarray(points, float)
    points = points[np.concatenate([[True], leg_lengths(points) > 1e-9])]
    if len(points) < 2:
        raise BadInput("expected at least two different points", place="curve")
    lengths, tangents, curvature = _sampled(points)
    top = _speed_limits(tangents, curvature, kinematics)
    top = np.minimum(top, np.minimum(_from_rest(lengths, kinematics), _from_rest(lengths[-1] - lengths, kinematics)))
    squares = top**2
    steps = np.diff(lengths)
    for n in range(len(steps)):
        squares[n + 1] = min(squares[n + 1], _after(squares[n], curvature[n], curvature[n + 1], steps[n], kinematics))
    for n in range(len(steps) - 1, -1, -1):
        squares[n] = min(squares[n], _after(squares[n + 1], curvature[n + 1], curvature[n], steps[n], kinematics))
    speeds = np.sqrt(squares)
    # Constant acceleration between places; at both ends jerk alone.
    times = 2 * steps / (speeds[:-1] + speeds[1:])
    times[[0, -1]] = np.maximum(times[[0, -1]], np.cbrt(6 * steps[[0, -1]] / kinematics.jerk))
    return Bound(float(times.sum()), lengths, speeds)


def _sampled(points: Points) -> tuple[Vector, Points, Vector]:
    """Return lengths (m,), unit tangents (m, 3) and curvatures (m,) [1/m]."""
    chords = arc_lengths(points)
    count = min(max(int(np.ceil(chords[-1] / 0.25)), 40), 40_000) + 1  # [m]
    even = np.linspace(0.0, 1.0, count)
    near = even[1] * np.linspace(0.0, 1.0, 12)[1:-1] ** 3
    at = chords[-1] * np.sort(np.concatenate([even, near, 1.0 - near]))
    if len(points) == 2:
        unit = (points[1] - points[0]) / chords[-1]
        return at, np.tile(unit, (len(at), 1)), np.zeros(len(at))
    first, second = derivatives(chords, points, at)
    rate = np.linalg.norm(first, axis=1)
    curvature = np.linalg.norm(np.cross(first, second), axis=1) / rate**3
    lengths = np.concatenate([[0.0], np.cumsum(np.diff(at) * (rate[:-1] + rate[1:]) / 2)])
    return lengths, first / rate[:, None], curvature


def _speed_limits(tangents: Points, curvature: Vector, kinematics: Kinematics) -> Vector:
    horizontal = np.hypot(tangents[:, 0], tangents[:, 1])
    rise = tangents[:, 2]
    vertical = np.where(rise > 0, kinematics.climb, kinematics.descent)
    with np.errstate(divide="ignore", over="ignore"):
        by_speed = kinematics.speed / horizontal
        by_rise = vertical / np.abs(rise)
        by_bend = np.sqrt(kinematics.accel_across / curvature)
    return np.asarray(np.minimum(np.minimum(by_speed, by_rise), by_bend))


def _after(square: float, bend: float, next_bend: float, step: float, kinematics: Kinematics) -> float:
    """Return the square of the greatest speed one step on; the smaller curvature of its ends counts."""
    used = min(bend, next_bend) * square / kinematics.accel_across
    along = kinematics.accel * math.sqrt(max(1.0 - used**2, 0.0))
    return square + 2 * along * step


def _from_rest(lengths: Vector, kinematics: Kinematics) -> Vector:
    accel, jerk = kinematics.accel, kinematics.jerk
    if not np.isfinite(jerk):
        return np.sqrt(2 * accel * lengths)
    ramp = accel / jerk
    ramp_way, ramp_speed = jerk * ramp**3 / 6, jerk * ramp**2 / 2
    short = np.cbrt(6 * lengths / jerk) ** 2 * jerk / 2
    beyond = np.maximum(lengths - ramp_way, 0.0)
    return np.where(lengths < ramp_way, short, np.sqrt(ramp_speed**2 + 2 * accel * beyond))


def derivatives(knots: Vector, points: Matrix, at: Vector) -> tuple[Matrix, Matrix]:
    """Return both derivatives (m, d) at `at` (m,) of the spline of `points` (n, d), n > 2; `knots` (n,) increase."""
    h, _, slope, square, cube = _pieces(knots, points, at)
    return slope + (2 * square + 3 * cube * h) * h, 2 * square + 6 * cube * h


def values(knots: Vector, points: Matrix, at: Vector) -> Matrix:
    h, point, slope, square, cube = _pieces(knots, points, at)
    return point + (slope + (square + cube * h) * h) * h


def _pieces(knots: Vector, points: Matrix, at: Vector) -> tuple[Matrix, Matrix, Matrix, Matrix, Matrix]:
    """Return h (m, 1), and the coefficients of 1, h, h^2, h^3 (m, d)."""
    steps = np.diff(knots)
    chords = np.diff(points, axis=0) / steps[:, None]
    slopes = _slopes(knots, steps, chords)
    piece = np.clip(np.searchsorted(knots, at, side="right") - 1, 0, len(steps) - 1)
    step = steps[piece][:, None]
    bend = (slopes[piece] + slopes[piece + 1] - 2 * chords[piece]) / step
    square = (chords[piece] - slopes[piece]) / step - bend
    return (at - knots[piece])[:, None], points[piece], slopes[piece], square, bend / step


def _slopes(knots: Vector, steps: Vector, chords: Matrix) -> Matrix:
    n = len(knots)
    below = np.zeros(n)
    middle = np.ones(n)
    above = np.zeros(n)
    right = np.zeros((n, chords.shape[1]))
    below[1:-1] = steps[1:]
    middle[1:-1] = 2 * (steps[:-1] + steps[1:])
    above[1:-1] = steps[:-1]
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
