"""Explain why there is no path: in plan view, walls as high as the airspace separate start and goal."""

from collections.abc import Iterator
from itertools import pairwise
from typing import NamedTuple

import numpy as np
import shapely

from ipoa_mission.errors import BadInput, MissionError
from ipoa_mission.geometry import Points, Vector, union_of
from ipoa_mission.planning.path_problem import place_names
from ipoa_mission.planning.problem import PreparedProblem
from ipoa_mission.planning.proof import Check, Proof
from ipoa_mission.world.obstacles import Obstacle
from ipoa_mission.world.terrain import Grid

COARSE_SEGMENTS = 2  # of a quarter circle, inside the true one
QUARTER_SEGMENTS = 16
CIRCLE_ERROR = 1 - np.cos(np.pi / 4 / QUARTER_SEGMENTS)
SHARE_TOLERANCE = 1e-5  # of the required distance
DISTANCE_TOLERANCE = 1e-2  # [m]
ROUNDING = 1e-6  # [m]
LEAST_FLIGHT = 0.1  # [m]


class Closure(NamedTuple):
    """Two `names` that leave `width` of `needed` [m] at `place` (east, north); without any gap, all around."""

    names: tuple[str, ...]
    place: tuple[float, float]
    width: float
    needed: float


def find_closures(problem: PreparedProblem, places: Points) -> Iterator[Closure | None]:
    """Yield the closure between each two successive places (n, 3); None if open or uncertain."""
    view = _View(problem)
    return (view.closure(*ends) for ends in pairwise(places))


class _View:
    def __init__(self, problem: PreparedProblem) -> None:
        self.area = problem.task.airspace.bounds.area
        self._known: dict[tuple[float, int], list[shapely.Geometry]] = {}
        shapes, radii, required, names = [], [], [], []
        for body in problem.task.airspace.obstacles:
            column = body.column
            if column is None:
                continue
            lowest, highest = _heights(problem, body)
            spare = max(column.base - lowest, highest - column.top, 0.0)
            if spare < problem.limits.obstacle_distance:
                shapes.append(column.shape)
                radii.append(column.radius)
                required.append(float(np.sqrt(problem.limits.obstacle_distance**2 - spare**2)))
                names.append(body.name)
        self.names = names
        self.shapes = np.array(shapes)
        self.radii = np.array(radii)
        self.required = np.array(required)

    def closure(self, start: Vector, goal: Vector) -> Closure | None:
        self.ends = shapely.points([start[:2], goal[:2]])
        if not len(self.shapes) or self.piece(1.0, COARSE_SEGMENTS) is not None or self.piece(1.0) is not None:
            return None
        if self.piece(0.0) is None:
            return self.walled_in()
        low, high = 0.0, 1.0
        while high - low > SHARE_TOLERANCE:
            middle = (low + high) / 2
            low, high = (low, middle) if self.piece(middle) is None else (middle, high)
        return self.gap(low)

    def piece(self, share: float, sides: int = QUARTER_SEGMENTS) -> shapely.Geometry | None:
        for piece in self._pieces(share, sides):
            if shapely.dwithin(piece, self.ends, DISTANCE_TOLERANCE / 10).all():
                return piece
        return None

    def walled_in(self) -> Closure | None:
        """Return the obstacles around the end in the smaller piece; None if it is open."""
        pieces = [p for p in self._pieces(0.0, QUARTER_SEGMENTS) if shapely.intersects(p, self.ends).any()]
        if len(pieces) < 2:
            return None
        cell = min(pieces, key=lambda piece: piece.area)
        other = self.ends[int(shapely.intersects(cell, self.ends[0]))]
        near = shapely.distance(self.shapes, cell) <= self.radii + DISTANCE_TOLERANCE
        place = shapely.get_coordinates(shapely.shortest_line(cell, other))[0]
        return Closure(tuple(np.array(self.names)[near]), (float(place[0]), float(place[1])), 0.0, 0.0)

    def gap(self, share: float) -> Closure | None:
        """Return the pair that closes at a share of the distance; the area's edge is a shape too."""
        piece = self.piece(share)
        names = [*self.names, "the edge of the area"]
        shapes = np.append(self.shapes, self.area.exterior)
        radii = np.append(self.radii, 0.0)
        required = np.append(self.required, 0.0)
        reach = 2 * float((radii + required).max()) + DISTANCE_TOLERANCE
        pairs = shapely.STRtree(shapes).query(shapes, "dwithin", reach)
        first, second = pairs[:, pairs[0] < pairs[1]]
        lines = shapely.shortest_line(shapes[first], shapes[second])
        lengths = shapely.length(lines)
        needed = required[first] + required[second]
        width = lengths - (radii[first] + radii[second])
        missing = np.abs(width - share * needed)
        for k in np.argsort(missing):
            if missing[k] > DISTANCE_TOLERANCE + CIRCLE_ERROR * needed[k]:
                break
            body = first[k]
            begin, end = shapely.get_coordinates(lines[k])
            from_begin = radii[body] + width[k] * required[body] / needed[k]
            east, north = begin + from_begin / max(float(lengths[k]), DISTANCE_TOLERANCE) * (end - begin)
            if shapely.dwithin(piece, shapely.Point(east, north), DISTANCE_TOLERANCE):
                pair = tuple(sorted((names[body], names[second[k]])))
                return Closure(pair, (float(east), float(north)), float(width[k]), float(needed[k]))
        return None

    def _pieces(self, share: float, sides: int) -> list[shapely.Geometry]:
        if (share, sides) not in self._known:
            grown = shapely.buffer(self.shapes, self.radii + share * self.required, quad_segs=sides)
            self._known[share, sides] = list(shapely.get_parts(self.area.difference(union_of(grown))))
        return self._known[share, sides]


def _heights(problem: PreparedProblem, body: Obstacle) -> tuple[float, float]:
    """Return the lowest and highest flight allowed next to a body [m]."""
    airspace = problem.task.airspace
    limits = problem.limits
    grid = problem.grid
    step = 1 / grid.ground.per_meter
    reach = np.array([-limits.obstacle_distance, limits.obstacle_distance])
    corners = body.bounds[:, :2] + reach[:, None]
    first, last = np.floor((corners - (grid.ground.east, grid.ground.north)) / step).astype(int)
    rows, columns = grid.heights.shape
    west, south = np.clip(first, 0, (columns - 2, rows - 2))
    east, north = np.clip(last + 2, 2, (columns, rows))
    near = grid.heights[south:north, west:east]
    unsure = 0.0 if isinstance(airspace.terrain, Grid) else airspace.terrain.steepness * step
    lowest = max(airspace.bounds.lower[2], float(near.min()) - unsure)
    return lowest, min(airspace.bounds.upper[2], float(near.max()) + unsure + limits.ceiling_above_ground)


class NoPath(MissionError, code="no-path"):
    """No path keeps the limits, or none was found."""


class NotFound(NoPath, code="not-found"):
    """Another seed may find a path."""


def refuse_places(problem: PreparedProblem) -> None:
    """Raise for a place at which the vehicle may not be.

    Raises:
        BadInput: the goal is at the start, without via points.
        NoPath: the place, with the limit and shortfall.
    """
    limits = problem.limits
    airspace = problem.task.airspace
    stops = problem.task.places
    if np.linalg.norm(np.diff(stops, axis=0), axis=1).max() < LEAST_FLIGHT:
        message = "expected a place other than the start, or via points on the way"
        raise BadInput(message, code="goal-at-start", place="goal")
    for name, stop in zip(place_names(stops), stops, strict=True):
        spot = np.array([stop, stop])
        height = airspace.terrain_clearance(spot)
        checks = [
            Check("obstacles", airspace.obstacle_clearance(spot), limits.obstacle_distance),
            Check("bounds", airspace.bounds_margin(spot), 0.0),
            Check("ground", height, 0.0),
            Check("ceiling", height, limits.ceiling_above_ground, at_most=True),
        ]
        worst = min(checks, key=lambda check: check.slack)
        if worst.slack < -ROUNDING:
            words = f"nothing can fly there: {worst.words()}"
            hint = f"move {name} or what is in its way"
            raise NoPath(words, hint=hint, code="place-blocked", known=worst.about, place=name)


def refuse_closed(problem: PreparedProblem) -> None:
    """Raise NoPath, with the widest gap or the obstacles around an end, if walls through all heights close the way."""
    for barrier in find_closures(problem, problem.task.places):
        if barrier is None:
            continue
        east, north = barrier.place
        where = f"at east {east:.1f}, north {north:.1f} m"
        if barrier.needed == 0:
            more = len(barrier.names) - 3
            few = ", ".join(barrier.names[:3]) + (f" and {more} more" if more > 0 else "")
            raise NoPath(f"every way is walled off: by {few}, {where}", code="walled-off")
        raise NoPath(
            f"no gap is wide enough: the widest is {barrier.width:.2f} m between {' and '.join(barrier.names)} "
            f"{where}, at least {barrier.needed:.2f} m required",
            hint="reduce safety_distance or the vehicle's radius",
            code="gap-too-narrow",
        )


def not_found(proof: Proof) -> NotFound:
    hint = "try another --seed, a smaller safety_distance, more planning.control_points, or more iterations"
    return NotFound(f"no safe path was found; the best one is {proof.words()}", hint=hint)
