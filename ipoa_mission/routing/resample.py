"""Place waypoints on a curve, and move them until the legs keep the required clearance."""

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
import shapely
from numpy.typing import NDArray

from ipoa_mission.errors import MissionError
from ipoa_mission.forecast.timing.track import thinned
from ipoa_mission.geometry import Matrix, Points, Vector, arc_lengths
from ipoa_mission.planning.path_problem import PathTask
from ipoa_mission.planning.problem import via_indices
from ipoa_mission.planning.proof import Check, doubtful_legs, prove
from ipoa_mission.planning.spline import Spline
from ipoa_mission.world.airspace import Airspace

PUSHES = 30
OVERSHOOT = 0.01  # of a moved leg [m]
SLOPE_STEP = 1e-3  # [m]
SAMPLES = 240  # of corridor waypoints
GREATEST_SPACING = 3.0  # before candidate places follow the bends [m]
CHORD_SHARE = 0.1  # of the tolerance
COMPARING_STEP = 0.5  # [m]
ON_THE_CURVE = (0.0,)
NO_PLACES = np.zeros((0, 3))


class NoRoute(MissionError, code="no-route"):
    """No choice of waypoints keeps the required clearance."""


@dataclass(frozen=True, eq=False)
class Route:
    """Waypoints (k, 3), flown in straight legs, or with `spline` in one curve (ArduPilot).

    A spline ends in a straight leg, or with `brakes_on_curve` in a curve of `braking_length`. `radius` is PX4's
    acceptance radius [m] of all waypoints, or of each (k,); 0: its parameter. The `slow` legs, from 0, are flown at
    `slow_speed` [m/s].
    """

    points: Points
    spline: bool = False
    brakes_on_curve: bool = False
    radius: Vector | float = 0.0
    slow: frozenset[int] = frozenset()
    slow_speed: float = 0.0
    slow_reason: str = ""

    @property
    def legs(self) -> int:
        return len(self.points) - 1

    @property
    def speed_changes(self) -> list[int]:
        return [leg for leg in range(self.legs) if (leg in self.slow) != (leg - 1 in self.slow)]


def push_clear(waypoints: Points, task: PathTask) -> Points:
    """Push waypoints (k, 3) aside by what their legs lack in clearance; ends and given places stay."""
    moved = waypoints.copy()
    is_free = ~(waypoints[:, None] == task.places).all(axis=2).any(axis=1)
    is_free[[0, -1]] = False
    moved_legs = set(doubtful_legs(moved, task).tolist())  # not proved since
    for _ in range(PUSHES):
        for leg in range(len(moved) - 1):
            if leg not in moved_legs:
                continue
            moved_legs.remove(leg)
            ends = moved[leg : leg + 2].copy()
            if not len(doubtful_legs(ends, task)):
                continue
            for check in prove(ends, task, spare=0.0).checks:
                if check.slack < 0 and check.limit in ("obstacles", "ground", "bounds"):
                    _push(moved[leg : leg + 2], is_free[leg : leg + 2], check, task.airspace)
            first, last = (moved[leg : leg + 2] != ends).any(axis=1)
            moved_legs |= {leg - 1, leg} if first else set()
            moved_legs |= {leg, leg + 1} if last else set()
        if not moved_legs:
            break
    return moved


def _push(ends: Points, is_free: NDArray[np.bool_], check: Check, airspace: Airspace) -> None:
    """Move the free ones of a leg's ends (2, 3) in place."""
    place = np.array(check.nearest.place)
    ahead = ends[1] - ends[0]
    share = float(np.clip((place - ends[0]) @ ahead / max(float(ahead @ ahead), 1e-12), 0, 1))
    weights = np.array([1 - share, share]) * is_free
    if not weights.any():
        return
    push = (OVERSHOOT - check.slack) * _outwards(place, check.limit, airspace)
    ends += weights[:, None] / (weights @ [1 - share, share]) * push


def _outwards(place: Vector, limit: str, airspace: Airspace) -> Vector:
    if limit == "ground":
        return np.array([0.0, 0.0, 1.0])
    distance = airspace.obstacle_distance if limit == "obstacles" else airspace.bounds.margin
    values = distance(place + SLOPE_STEP * np.vstack([np.eye(3), -np.eye(3)]))
    slope = np.asarray(values[:3] - values[3:])
    return slope / max(float(np.linalg.norm(slope)), 1e-12)


def every(curve: Spline, spacing: float, via: Points = NO_PLACES) -> Points:
    """Return waypoints at most `spacing` [m] apart, (k, 3), via points (m, 3) among them."""
    return through(curve.sample(max(2 + len(via), math.ceil(curve.length / spacing) + 1)), via)[0]


def evenly_spaced(line: Points, spacing: float, last: float, via: Points) -> Points:
    """Return waypoints at most `spacing` [m] apart, with a last leg of `last` [m]."""
    traveled = arc_lengths(line)
    before = traveled[-1] - last
    count = max(1 + len(via), math.ceil(before / spacing))
    stops = np.append(np.linspace(0.0, before, count + 1), traveled[-1])
    return through(cubic_values(traveled, line, stops), via)[0]


def corridor(
    curve: Spline, tolerance: float, asides: tuple[float, ...] = ON_THE_CURVE, via: Points = NO_PLACES
) -> tuple[Points, Vector]:
    """Return the fewest waypoints (k, 3) with legs within `tolerance` [m] of the curve, and their stations (k,).

    They are offset by `asides` [m, to the left]. Of the fewest, the least squared deviations (Imai and Iri 1986).
    """
    from ipoa_mission.routing._corridor import fewest_legs

    samples = _spots(curve, tolerance, SAMPLES // len(asides))
    traveled = arc_lengths(samples)
    samples, stops = through(samples, via)
    spots = samples[:, None, :] + np.asarray(asides)[:, None] * lefts(samples)[:, None, :]  # (n, sides, 3)
    spots[[0, *stops, -1]] = samples[[0, *stops, -1], None, :]
    n = len(samples)
    last = np.array([next((stop for stop in stops if stop > i), n - 1) for i in range(n)])
    before = fewest_legs(samples, spots, last, tolerance)
    chosen = [(n - 1, 0)]
    while chosen[-1][0] > 0:
        chosen.append(tuple(before[chosen[-1]].tolist()))
    chosen.reverse()
    return np.array([spots[spot] for spot in chosen]), traveled[[n for n, _ in chosen]]


def _spots(curve: Spline, tolerance: float, most: int) -> Points:
    if curve.length > GREATEST_SPACING * most:
        return curve.points(curve.chords(CHORD_SHARE * tolerance))
    return curve.sample(int(np.clip(math.ceil(curve.length / min(1.0, tolerance)) + 1, 20, most)))


def strays(path: Points, curve: Spline, most: float) -> bool:
    """Return whether path (n, 3) and curve are anywhere farther than `most` [m] apart, seen from above."""
    steps = shapely.get_coordinates(shapely.segmentize(shapely.LineString(path[:, :2]), COMPARING_STEP))
    samples, line = curve_samples(curve)
    return bool(is_far(steps, line, most).any() or is_far(samples, path, most).any())


def is_far(points: Points, line: Points, most: float) -> NDArray[np.bool_]:
    """Return which points (n, 2 or 3) are farther than `most` [m] from a line (k, 2 or 3), seen from above."""
    from ipoa_mission.routing._corridor import far_points

    level, legs = (np.ascontiguousarray(places[:, :2]) for places in (points, line))
    return far_points(level, legs, most).astype(bool)  # type: ignore[no-any-return]


def through(samples: Points, via: Points) -> tuple[Points, list[int]]:
    """Move the nearest sample to each via point; return samples and indices."""
    stops = via_indices(samples, via)
    samples[stops] = via
    return samples, stops


@lru_cache(maxsize=8)
def curve_samples(curve: Spline) -> tuple[Points, Points]:
    """Return places on a curve (n, 3), and a thinner line along it."""
    samples = curve.sample(2 + int(curve.length / COMPARING_STEP))
    return samples, thinned(samples)


def lefts(samples: Points) -> Points:
    """Return horizontal unit vectors to the left of the path; zero if vertical."""
    ahead = np.gradient(samples[:, :2], axis=0)
    length = np.linalg.norm(ahead, axis=1, keepdims=True)
    level = np.divide(ahead, length, out=np.zeros_like(ahead), where=length > 1e-9)
    return np.column_stack([-level[:, 1], level[:, 0], np.zeros(len(level))])


def cubic_values(knots: Vector, points: Matrix, at: Vector) -> Matrix:
    """Return the not-a-knot cubic spline (de Boor) of points (n, d), n > 2, at `at` (m,); `knots` (n,) increase.

    Importing SciPy's takes 0.4 s.
    """
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
