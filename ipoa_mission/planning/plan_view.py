"""Decide in plan view whether obstacles close every route.

Obstacles as high as the airspace, grown by their required distance, leave start and goal in one piece or not. The gap
that opens first is the widest.
"""

from dataclasses import dataclass

import numpy as np
import shapely

from ipoa_mission.geometry import Vector, union_of
from ipoa_mission.planning.problem import PreparedProblem
from ipoa_mission.world.obstacles import Obstacle
from ipoa_mission.world.terrain import Flat, Grid

COARSE_SEGMENTS, QUARTER_SEGMENTS = 2, 16  # of a quarter circle, inside the true one
CIRCLE_ERROR = 1 - np.cos(np.pi / 4 / QUARTER_SEGMENTS)
SHARE_TOLERANCE = 1e-5  # of the required distance
DISTANCE_TOLERANCE = 1e-2  # [m]


@dataclass(frozen=True)
class Closure:
    """A closure at `place` (east, north): two `names` that leave `width` of `needed` [m].

    Without any gap, `names` are all around.
    """

    names: tuple[str, ...]
    place: tuple[float, float]
    width: float
    needed: float


def closure(problem: PreparedProblem, start: Vector, goal: Vector) -> Closure | None:
    """Return the closure between two places, (3,) each; None if open or uncertain."""
    view = _View(problem, start, goal)
    if not len(view.shapes) or view.piece(1.0, COARSE_SEGMENTS) is not None or view.piece(1.0) is not None:
        return None
    if view.piece(0.0) is None:
        return view.walled_in()
    low, high = 0.0, 1.0
    while high - low > SHARE_TOLERANCE:
        middle = (low + high) / 2
        low, high = (low, middle) if view.piece(middle) is None else (middle, high)
    return view.gap(low)


class _View:
    def __init__(self, problem: PreparedProblem, start: Vector, goal: Vector) -> None:
        bounds = problem.task.airspace.bounds
        self.area = bounds.footprint.shape if bounds.footprint else shapely.box(*bounds.lower[:2], *bounds.upper[:2])
        self.ends = shapely.points([start[:2], goal[:2]])
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
        self.shapes, self.names = np.array(shapes), names
        self.radii, self.required = np.array(radii), np.array(required)

    def piece(self, share: float, sides: int = QUARTER_SEGMENTS) -> shapely.Geometry | None:
        """Return the piece that joins both ends at a share of the distance."""
        return next(
            (p for p in self._pieces(share, sides) if shapely.dwithin(p, self.ends, DISTANCE_TOLERANCE / 10).all()),
            None,
        )

    def walled_in(self) -> Closure | None:
        pieces = [p for p in self._pieces(0.0, QUARTER_SEGMENTS) if shapely.intersects(p, self.ends).any()]
        if len(pieces) < 2:
            return None
        cell = min(pieces, key=lambda piece: piece.area)
        other = self.ends[int(shapely.intersects(cell, self.ends[0]))]
        near = shapely.distance(self.shapes, cell) <= self.radii + DISTANCE_TOLERANCE
        place = shapely.get_coordinates(shapely.shortest_line(cell, other))[0]
        return Closure(tuple(np.array(self.names)[near]), (float(place[0]), float(place[1])), 0.0, 0.0)

    def gap(self, share: float) -> Closure | None:
        piece, side = self.piece(share), self.area.exterior
        tree = shapely.STRtree(self.shapes)
        reach = 2 * float((self.radii + self.required).max()) + DISTANCE_TOLERANCE
        first, second = tree.query(self.shapes, "dwithin", reach)
        first, second = first[first < second], second[first < second]
        lines = [
            *shapely.shortest_line(self.shapes[first], self.shapes[second]),
            *shapely.shortest_line(self.shapes, side),
        ]
        inner = np.concatenate([self.radii[first] + self.radii[second], self.radii])
        needed = np.concatenate([self.required[first] + self.required[second], self.required])
        width = shapely.length(lines) - inner
        names = [*zip(first, second, strict=True), *((k, -1) for k in range(len(self.shapes)))]
        called = [*self.names, "the edge of the area"]
        short = width - share * needed
        for k in np.argsort(np.abs(short)):
            if abs(short[k]) > DISTANCE_TOLERANCE + CIRCLE_ERROR * needed[k]:
                break
            ends = shapely.get_coordinates(lines[k])
            a, b = names[k]
            along = (self.radii[a] + width[k] * self.required[a] / needed[k]) / max(
                float(shapely.length(lines[k])), DISTANCE_TOLERANCE
            )
            east, north = ends[0] + along * (ends[1] - ends[0])
            if shapely.dwithin(piece, shapely.Point(east, north), DISTANCE_TOLERANCE):
                pair = tuple(sorted((called[a], called[b])))
                return Closure(pair, (float(east), float(north)), float(width[k]), float(needed[k]))
        return None

    def _pieces(self, share: float, sides: int) -> list[shapely.Geometry]:
        grown = shapely.buffer(self.shapes, self.radii + share * self.required, quad_segs=sides)
        return list(shapely.get_parts(self.area.difference(union_of(grown))))


def _heights(problem: PreparedProblem, body: Obstacle) -> tuple[float, float]:
    airspace, limits, grid = problem.task.airspace, problem.limits, problem.grid
    (west, south, _), (east, north, _) = body.bounds
    reach, step = limits.obstacle_distance, 1 / grid.ground.per_meter
    places = np.array([(west - reach, south - reach), (east + reach, north + reach)])
    first, last = np.floor((places - (grid.ground.east, grid.ground.north)) / step).astype(int)
    rows, columns = grid.heights.shape
    (i, j), (m, n) = np.clip(first, 0, (columns - 2, rows - 2)), np.clip(last + 2, 2, (columns, rows))
    near = grid.heights[j:n, i:m]
    unsure = 0.0 if isinstance(airspace.terrain, Flat | Grid) else airspace.terrain.steepness * step
    lowest = max(airspace.bounds.lower[2], float(near.min()) - unsure)
    return lowest, min(airspace.bounds.upper[2], float(near.max()) + unsure + limits.ceiling_above_ground)
