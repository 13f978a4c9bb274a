"""Explain why there is no path.

In plan view, obstacles as high as the airspace, grown by their required distance, leave start and goal in one piece or
not. The gap that opens first is the widest.
"""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import shapely

from ipoa_mission.errors import BadInput, MissionError
from ipoa_mission.geometry import Vector, union_of
from ipoa_mission.planning.lattice import Lattice, lay
from ipoa_mission.planning.path_problem import place_names
from ipoa_mission.planning.problem import PreparedProblem
from ipoa_mission.planning.proof import Check, Proof
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


ROUNDING, GRADIENT_STEP, LEAST_FLIGHT = 1e-6, 1e-4, 0.1  # [m]
LATTICE_FINENESS = 3.0
COARSEST_STEP = 1.5  # lattices with longer steps, in clearances, may miss thin walls


class NoPath(MissionError):
    """No path keeps the limits, or none was found."""


class NotFound(NoPath):
    """Another seed may find a path."""


def refuse_places(problem: PreparedProblem) -> None:
    """Raise for a place at which the vehicle may not be.

    Raises:
        BadInput: the goal is at the start, without via points.
        NoPath: the place, with the limit and shortfall.
    """
    task, limits, airspace = problem.task, problem.limits, problem.task.airspace
    stops = task.places
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
    """Raise if walls through all heights leave no gap that is wide enough.

    Raises:
        NoPath: the widest gap, or the obstacles around an end.
    """
    for a, b in pairwise(problem.task.places):
        if (barrier := closure(problem, a, b)) is not None:
            where = f"at east {barrier.place[0]:.1f}, north {barrier.place[1]:.1f} m"
            if barrier.needed == 0:
                more = len(barrier.names) - 3
                few = ", ".join(barrier.names[:3]) + (f" and {more} more" if more > 0 else "")
                raise NoPath(f"every way is walled off: by {few}, {where}", code="walled-off")
            raise _too_narrow(barrier.names, where, barrier.width, barrier.needed)


def not_found(proof: Proof) -> NotFound:
    hint = "try another --seed, more planning.control_points, or more iterations of the optimizer"
    return NotFound(f"no safe path was found; the best one is {proof.words()}", hint=hint)


def blockage(problem: PreparedProblem) -> NoPath | None:
    """Return the error for the widest route; None if it is open or uncertain."""
    lattice = lay(problem, LATTICE_FINENESS)
    for a, b in pairwise(problem.task.places):
        slack, gate = _widest(lattice, _entrance(lattice, a), _entrance(lattice, b))
        coarse = lattice.spacing[:2].max() > COARSEST_STEP * problem.limits.obstacle_distance
        if slack >= (-np.linalg.norm(lattice.spacing) / 2 if coarse else 0.0):
            continue
        if (why := _closed(problem, lattice.places[gate])) is not None:
            return why
    return None


def _entrance(lattice: Lattice, place: Vector) -> int:
    shape = np.array(lattice.slack.shape)
    nearest = np.round((place - lattice.corner) / lattice.spacing).astype(int)
    beside = nearest + np.indices((3, 3, 3)).reshape(3, -1).T - 1
    nodes = np.ravel_multi_index(tuple(np.clip(beside, 0, shape - 1).T), lattice.slack.shape)
    return int(nodes[np.argmax(lattice.slack.ravel()[nodes])])


def _widest(lattice: Lattice, start: int, goal: int) -> tuple[float, int]:
    """Return the greatest slack that joins start and goal, and its node."""
    slack = lattice.slack.ravel()
    levels = np.unique(slack[np.isfinite(slack)])
    low, high = 0, len(levels)
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (middle, high) if _joined(lattice, levels[middle], start, goal) else (low, middle)
    gates = np.nonzero(slack == levels[low])[0]  # under a level roof: the smallest detour
    ends, spots = lattice.places[[start, goal]], lattice.places[gates]
    detour = np.linalg.norm(spots - ends[0], axis=1) + np.linalg.norm(spots - ends[1], axis=1)
    return float(levels[low]), int(gates[np.argmin(detour)])


def _joined(lattice: Lattice, level: float, start: int, goal: int) -> bool:
    from scipy.ndimage import label  # slow to import, and rarely needed

    parts, _ = label(lattice.slack >= level, structure=np.ones((3, 3, 3)))
    parts = parts.ravel()
    return bool(parts[start] > 0 and parts[start] == parts[goal])


@dataclass(frozen=True, eq=False)
class _Wall:
    name: str
    distance: float
    required: float
    away: Vector
    body: Obstacle | None = None


def _closed(problem: PreparedProblem, gate: Vector) -> NoPath | None:
    walls = sorted(_walls(problem, gate), key=lambda wall: wall.distance - wall.required)
    east, north, up = gate
    where = f"at east {east:.1f}, north {north:.1f}, up {up:.1f} m"
    first = walls[0]
    if first.distance < 0:
        return NoPath(
            f"every way is walled off: even where it is easiest to pass, {first.name} closes it, {where}",
            code="walled-off",
        )
    opposite = [wall for wall in walls[1:] if wall.away @ first.away < -0.5]
    if not opposite:
        return NoPath(
            f"the widest way comes within {first.distance:.2f} m of {first.name} {where}, "
            f"at least {first.required:.2f} m required",
            code="gap-too-narrow",
        )
    width, needed = _gap(first, opposite[0], gate), first.required + opposite[0].required
    if width > needed:
        return None
    return _too_narrow(tuple(sorted((first.name, opposite[0].name))), where, width, needed)


def _too_narrow(names: tuple[str, ...], where: str, width: float, needed: float) -> NoPath:
    return NoPath(
        f"no gap is wide enough: the widest is {width:.2f} m between {' and '.join(names)} {where}, "
        f"at least {needed:.2f} m required",
        hint="reduce safety_distance or the vehicle's radius",
        code="gap-too-narrow",
    )


def _walls(problem: PreparedProblem, gate: Vector) -> list[_Wall]:
    limits, airspace, spot = problem.limits, problem.task.airspace, gate[None, :]
    height = float(gate[2] - airspace.ground(spot)[0])
    upwards = np.array([0.0, 0.0, 1.0])
    walls = [_Wall("the ground", height, float(limits.required_height(spot)[0]), upwards)]
    if np.isfinite(limits.ceiling_above_ground):
        walls.append(_Wall("the greatest height allowed", limits.ceiling_above_ground - height, 0.0, -upwards))
    for side, sign, edges in (("lower", 1.0, airspace.bounds.lower), ("upper", -1.0, airspace.bounds.upper)):
        for axis, edge in enumerate(edges):
            name = (("west", "south", "lower"), ("east", "north", "upper"))[side == "upper"][axis]
            walls.append(_Wall(f"the {name} bound", sign * (gate[axis] - edge), 0.0, sign * np.eye(3)[axis]))
    for body, _, distance in airspace.near(spot, 4 * limits.obstacle_distance + 10.0):
        walls.append(_Wall(body.name, float(distance[0]), limits.obstacle_distance, _away(body, gate), body))
    return walls


def _away(body: Obstacle, place: Vector) -> Vector:
    steps = GRADIENT_STEP * np.vstack([np.eye(3), -np.eye(3)])
    distance = body.distance(place + steps)
    slope = distance[:3] - distance[3:]
    return np.asarray(slope / max(float(np.linalg.norm(slope)), 1e-300))


def _gap(a: _Wall, b: _Wall, place: Vector) -> float:
    """Return the width between two walls, by alternating projection."""
    if a.body is None or b.body is None:
        return a.distance + b.distance
    for _ in range(50):
        other, place = place, place - a.body.distance(place[None])[0] * _away(a.body, place)
        other, place = place, place - b.body.distance(place[None])[0] * _away(b.body, place)
    return float(np.linalg.norm(place - other))
