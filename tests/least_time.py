"""The least time along a curve, limited by speed, acceleration and jerk: a referee of routes.

Time-optimal path parametrisation in two passes (Bobrow et al.). Jerk counts only at both ends.
"""

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy.interpolate import CubicSpline

from ipoa_mission.errors import BadInput
from ipoa_mission.geometry import Points, Vector, arc_lengths, leg_lengths


class PathLimits(NamedTuple):
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


def least_time(points: Points, limits: PathLimits) -> Bound:
    """Return the least time along the cubic spline through points, from rest to rest.

    Raises:
        BadInput: fewer than two different points, or a limit that is not positive.
    """
    for name in ("speed", "climb", "descent", "accel", "jerk"):
        if not getattr(limits, name) > 0:
            raise BadInput(f"expected more than 0, not {getattr(limits, name):g}", place=name)
    points = np.asarray(points, float)
    points = points[np.concatenate([[True], leg_lengths(points) > 1e-9])]
    if len(points) < 2:
        raise BadInput("expected at least two different points", place="curve")
    lengths, tangents, curvature = _sampled(points)
    top = _speed_limits(tangents, curvature, limits)
    top = np.minimum(top, np.minimum(_from_rest(lengths, limits), _from_rest(lengths[-1] - lengths, limits)))
    squares = top**2
    steps = np.diff(lengths)
    for n in range(len(steps)):
        squares[n + 1] = min(squares[n + 1], _after(squares[n], curvature[n], curvature[n + 1], steps[n], limits))
    for n in range(len(steps) - 1, -1, -1):
        squares[n] = min(squares[n], _after(squares[n + 1], curvature[n + 1], curvature[n], steps[n], limits))
    speeds = np.sqrt(squares)
    # Constant acceleration between places; at both ends jerk alone.
    times = 2 * steps / (speeds[:-1] + speeds[1:])
    times[[0, -1]] = np.maximum(times[[0, -1]], np.cbrt(6 * steps[[0, -1]] / limits.jerk))
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
    curve = CubicSpline(chords, points)
    first, second = curve(at, 1), curve(at, 2)
    rate = np.linalg.norm(first, axis=1)
    curvature = np.linalg.norm(np.cross(first, second), axis=1) / rate**3
    lengths = np.concatenate([[0.0], np.cumsum(np.diff(at) * (rate[:-1] + rate[1:]) / 2)])
    return lengths, first / rate[:, None], curvature


def _speed_limits(tangents: Points, curvature: Vector, limits: PathLimits) -> Vector:
    horizontal = np.hypot(tangents[:, 0], tangents[:, 1])
    rise = tangents[:, 2]
    vertical = np.where(rise > 0, limits.climb, limits.descent)
    with np.errstate(divide="ignore", over="ignore"):
        by_speed = limits.speed / horizontal
        by_rise = vertical / np.abs(rise)
        by_bend = np.sqrt(limits.accel_across / curvature)
    return np.asarray(np.minimum(np.minimum(by_speed, by_rise), by_bend))


def _after(square: float, bend: float, next_bend: float, step: float, limits: PathLimits) -> float:
    """Return the square of the greatest speed one step on; the smaller curvature of its ends counts."""
    used = min(bend, next_bend) * square / limits.accel_across
    along = limits.accel * math.sqrt(max(1.0 - used**2, 0.0))
    return square + 2 * along * step


def _from_rest(lengths: Vector, limits: PathLimits) -> Vector:
    accel, jerk = limits.accel, limits.jerk
    if not np.isfinite(jerk):
        return np.sqrt(2 * accel * lengths)
    ramp = accel / jerk
    ramp_way, ramp_speed = jerk * ramp**3 / 6, jerk * ramp**2 / 2
    short = np.cbrt(6 * lengths / jerk) ** 2 * jerk / 2
    beyond = np.maximum(lengths - ramp_way, 0.0)
    return np.where(lengths < ramp_way, short, np.sqrt(ramp_speed**2 + 2 * accel * beyond))
