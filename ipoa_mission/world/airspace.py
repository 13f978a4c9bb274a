"""Exact clearances of points and legs to ground, obstacles and bounds."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import shapely
from numpy.typing import NDArray

from ipoa_mission.errors import BadInput
from ipoa_mission.geometry import Place, Plane, Points, Vector, as_place, leg_lengths
from ipoa_mission.ground import Ground
from ipoa_mission.world.obstacles import Obstacle, straightened
from ipoa_mission.world.obstacles.obstacle import Column, Part, distance_of
from ipoa_mission.world.polygon import Polygon
from ipoa_mission.world.terrain import Terrain


@dataclass(frozen=True)
class Clearance:
    """`distance` [m], negative inside, to `what`, at `place` on leg number `leg`."""

    distance: float
    place: Place
    what: str
    leg: int = 0

    def __str__(self) -> str:
        east, north, up = self.place
        return f"{self.distance:.3f} m to {self.what} at east {east:.2f}, north {north:.2f}, up {up:.2f} m"

    def minus(self, deviation: float) -> "Clearance":
        return replace(self, distance=self.distance - deviation)


ROUNDING = 1e-6  # [m]
NOTHING_NEAR = Clearance(float("inf"), (float("nan"),) * 3, "nothing")


@dataclass(frozen=True)
class Bounds:
    """The allowed volume: a box, and within it the footprint of a flight area if any.

    Attributes:
        lower: its least east, north and up [m].
        upper: its greatest [m].
        footprint: the flight area.

    Raises:
        BadInput: `lower` is not below `upper`, or not finite.

    Example:
        >>> import numpy as np
        >>> Bounds((0.0, -50.0, 0.0), (100.0, 50.0, 60.0)).margin(np.array([[5.0, 0.0, 30.0]]))
        array([5.])
    """

    lower: tuple[float, float, float]
    upper: tuple[float, float, float]
    footprint: Polygon | None = None

    def __post_init__(self) -> None:
        is_finite = np.isfinite([*self.lower, *self.upper])
        if len(is_finite) != 6 or not is_finite.all() or not np.less(self.lower, self.upper).all():
            raise BadInput(f"expected a finite lower below upper, not {self.lower} and {self.upper}", place="bounds")

    @property
    def area(self) -> shapely.Polygon:
        return self.footprint.shape if self.footprint else shapely.box(*self.lower[:2], *self.upper[:2])

    def margin(self, points: Points) -> Vector:
        """Return distances of points (n, 3) to the nearest limit, (n,) [m]: negative outside."""
        inside = self.box_margin(points)
        if self.footprint is not None:
            inside = np.minimum(inside, -self.footprint.distance(points[:, :2]))
        return np.asarray(inside)

    def box_margin(self, points: Points) -> Vector:
        return np.asarray(np.hstack([points - np.asarray(self.lower), np.asarray(self.upper) - points]).min(axis=1))

    def legs_margin(self, points: Points) -> Vector:
        """Return lower bounds of the margins of legs between points (n, 3), (n-1,) [m]; exact of the box."""
        margins = self.box_margin(points)
        inside = np.minimum(margins[:-1], margins[1:])
        if self.footprint is None:
            return inside
        middle = self.margin((points[:-1] + points[1:]) / 2)
        lines = shapely.linestrings(np.stack([points[:-1, :2], points[1:, :2]], axis=1))
        to_edge = shapely.distance(lines, self.footprint.shape.boundary)
        inside = np.minimum(to_edge, inside) - ROUNDING
        return np.where((middle > 0) & (to_edge > 0), inside, middle - leg_lengths(points) / 2)

    def leg_margin(self, a: Vector, b: Vector) -> Clearance:
        """Return the least margin of the leg `a` to `b` [m], and its place."""
        fractions = np.array([0.0, 1.0])
        b = straightened(a, b)
        if self.footprint is not None:
            line = shapely.LineString([a[:2], b[:2]])
            edge = self.footprint.shape.boundary
            nearest = shapely.get_point(shapely.shortest_line(line, edge), 0)
            inner = np.append(
                self.footprint.balance_parameters(a[:2], b[:2]),
                shapely.line_locate_point(line, nearest, normalized=True),
            )
            fractions = np.append(fractions, inner[(inner > 0) & (inner < 1)])
        points = a + fractions[:, None] * (b - a)
        margins = self.margin(points)
        least = int(np.argmin(margins))
        return Clearance(float(margins[least]), as_place(points[least]), self.nearest_limit(points[least]))

    def nearest_limit(self, point: Vector) -> str:
        sides = np.concatenate([point - np.asarray(self.lower), np.asarray(self.upper) - point])
        names = ("west", "south", "lower", "east", "north", "upper")
        if self.footprint is not None and -self.footprint.distance(point[None, :2])[0] < sides.min():
            return "the edge of the flight area"
        return f"the {names[int(np.argmin(sides))]} bound"


@dataclass(frozen=True, eq=False)
class Airspace:
    """The world of a planner: east, north and up of home [m].

    Attributes:
        bounds: the allowed volume.
        terrain: the ground.
        obstacles: bodies on or above it.

    Example:
        >>> import numpy as np
        >>> from ipoa_mission import Airspace, Bounds, Flat, Sphere
        >>> ball = Sphere("ball", (50.0, 0.0, 30.0), 10.0)
        >>> airspace = Airspace(Bounds((0.0, -50.0, 0.0), (100.0, 50.0, 60.0)), Flat(), (ball,))
        >>> airspace.clearance(np.array([[30.0, 0.0, 30.0], [30.0, 0.0, 4.0]]))
        array([10.,  4.])
        >>> print(airspace.leg_clearance(np.array([0.0, 15.0, 30.0]), np.array([100.0, 15.0, 30.0])))
        5.000 m to ball at east 50.00, north 15.00, up 30.00 m
    """

    bounds: Bounds
    terrain: Terrain
    obstacles: tuple[Obstacle, ...] = ()

    @cached_property
    def ground(self) -> Ground:
        return Ground(self.terrain)

    def clearance(self, points: Points) -> Vector:
        """Return the distance to an obstacle, or the height above ground if less, (n,) [m]."""
        return np.minimum(self.obstacle_distance(points), points[:, 2] - self.ground(points))

    def obstacle_distance(self, points: Points) -> Vector:
        """Return distances (n,) [m], infinite without obstacles."""
        least = np.full(len(points), np.inf)
        if not self.obstacles:
            return least
        if len(points) <= 8:  # quicker without an index
            return self._distance_of_few(points)
        spots = shapely.points(points[:, :2])
        for body, which in _grouped(self._index.query_nearest(spots, all_matches=False)):
            least[which] = self.obstacles[body].distance(points[which])
        for body, which in _grouped(self._index.query(spots, "dwithin", np.maximum(least, 0.0))):
            least[which] = np.minimum(least[which], self.obstacles[body].distance(points[which]))
        return least

    def beside_leg(self, a: Vector, b: Vector, distance: float) -> NDArray[np.intp]:
        """Return the obstacles whose circles are within `distance` [m] of the leg `a` to `b`, (k,)."""
        middles, radii = self._circles
        step = b[:2] - a[:2]
        away = middles - a[:2]
        share = np.clip(away @ step / max(float(step @ step), 1e-12), 0.0, 1.0)
        away -= share[:, None] * step
        return np.flatnonzero((away**2).sum(axis=1) <= (radii + max(distance, 0.0)) ** 2)

    def _distance_of_few(self, points: Points) -> Vector:
        middles, radii = self._circles
        least = np.full(len(points), np.inf)
        floors = np.linalg.norm(middles - points[:, None, :2], axis=2) - radii - ROUNDING
        lowest = floors.min(axis=0)
        for body in np.argsort(lowest, kind="stable"):
            if lowest[body] > least.max():
                break
            least = np.minimum(least, self.obstacles[body].distance(points))
        return least

    def leg_clearance(self, a: Vector, b: Vector) -> Clearance:
        """Return the least clearance of the leg `a` to `b` [m]."""
        return self.polyline_clearance(np.array([a, b]))

    def polyline_clearance(self, points: Points) -> Clearance:
        return min(self.terrain_clearance(points), self.obstacle_clearance(points), key=lambda c: c.distance)

    def terrain_clearance(self, points: Points, within: float = np.inf) -> Clearance:
        """Return the least height above ground of the legs between `points`; `within`: see `obstacle_clearance`."""
        return _clearance(points, "terrain", *self.terrain.least_height(points, within))

    def height_reached(self, points: Points) -> Clearance:
        return _clearance(points, "the ground", *self.terrain.greatest_height(points))

    def near(self, points: Points, reach: float) -> Iterator[tuple[Obstacle, NDArray[np.intp], Vector]]:
        """Yield obstacles within `reach` [m] of `points`, with indices and distances (k,) [m]."""
        if not self.obstacles:
            return
        for body, which in _grouped(self._index.query(shapely.points(points[:, :2]), "dwithin", reach)):
            distance = self.obstacles[body].distance(points[which])
            if (close := distance <= reach).any():
                yield self.obstacles[body], which[close], distance[close]

    def beside(self, lines: NDArray[np.object_], reach: Vector) -> NDArray[np.intp]:
        """Return indices of `lines` and of boxes within `reach` (k,) [m], (2, n)."""
        if not self.obstacles:
            return np.zeros((2, 0), dtype=np.intp)
        spots = shapely.length(lines) == 0  # GEOS finds nothing near a line without length
        asked = lines.copy()
        asked[spots] = shapely.get_point(lines[spots], 0)
        return np.asarray(self._index.query(asked, "dwithin", reach))

    def legs_clearance(self, starts: Points, ends: Points, within: float) -> tuple[Vector, NDArray[np.intp]]:
        """Bound distances (n,) [m] of legs `starts` to `ends` to obstacles `within`; exact if level or upright."""
        least = np.full(len(starts), np.inf)
        which = np.full(len(starts), -1)
        if not self.obstacles:
            return least, which
        legs, bodies, bounds = self._beside_legs(starts, ends, within)
        order = np.lexsort((bodies, bounds, legs))
        near, first = np.unique(legs[order], return_index=True)
        nearest = order[first]
        is_within = bounds[nearest] <= within
        least[near[is_within]] = bounds[nearest[is_within]]
        which[near[is_within]] = bodies[nearest[is_within]]
        return least, which

    def obstacle_clearance(self, points: Points, within: float = np.inf) -> Clearance:
        """Return the least distance between `points` to an obstacle; beyond `within` [m] it is a lower bound."""
        if not self.obstacles:
            return NOTHING_NEAR
        starts = points[:-1]
        ends = points[1:]
        known = within if np.isfinite(within) else float(self.obstacle_distance(points).min())
        reach = max(known, 0.0) + ROUNDING  # inside an obstacle, bounds are not depths
        legs, bodies, bounds = self._beside_legs(starts, ends, reach)
        least = NOTHING_NEAR
        for n in np.lexsort((legs, bodies, bounds)):
            if bounds[n] > min(max(least.distance, 0.0), reach):
                break
            body = self.obstacles[bodies[n]]
            distance, where = body.leg_clearance(starts[legs[n]], ends[legs[n]])
            if distance < least.distance:
                least = _clearance(points, body.name, distance, int(legs[n]), where)
        return least

    def _beside_legs(
        self, starts: Points, ends: Points, reach: float
    ) -> tuple[NDArray[np.intp], NDArray[np.intp], Vector]:
        """Return pairs of leg and obstacle that may be within `reach` [m], and bounds of their distances, (n,) each.

        The bound of a pair that meets is 0 or less.
        """
        shapes, radii, base, top = self._columns
        if len(starts) <= 3:  # quicker without an index
            near = [self.beside_leg(a, b, reach) for a, b in zip(starts, ends, strict=True)]
            legs, bodies = np.repeat(np.arange(len(near)), list(map(len, near))), np.concatenate(near)
        else:
            west_south = np.minimum(starts, ends)[:, :2] - reach
            east_north = np.maximum(starts, ends)[:, :2] + reach
            legs, bodies = self._index.query(shapely.box(*west_south.T, *east_north.T))
        low = np.minimum(starts[:, 2], ends[:, 2])
        high = np.maximum(starts[:, 2], ends[:, 2])
        above = np.maximum(low[legs] - top[bodies], base[bodies] - high[legs])
        is_level = above <= reach
        legs, bodies, above = legs[is_level], bodies[is_level], above[is_level]
        lines = shapely.linestrings(np.stack([starts[:, :2], ends[:, :2]], axis=1))
        bounds = distance_of(shapely.distance(lines[legs], shapes[bodies]) - radii[bodies], above)
        for body in np.unique(bodies[np.isnan(bounds)]):
            of_body = bodies == body
            bounds[of_body] = self.obstacles[body].leg_distances(starts[legs[of_body]], ends[legs[of_body]])
        return legs, bodies, bounds

    def bounds_margin(self, points: Points, within: float = np.inf) -> Clearance:
        """Return the least margin of the legs between `points`; beyond `within` [m] it is not the least."""
        box = replace(self.bounds, footprint=None)
        margins = self.bounds.box_margin(points)
        spot = int(np.argmin(margins))
        limit = box.nearest_limit(points[spot])
        least = Clearance(float(margins[spot]), as_place(points[spot]), limit, max(spot - 1, 0))
        if self.bounds.footprint is None:
            return least
        floor = self.bounds.legs_margin(points)
        for leg in np.argsort(floor, kind="stable"):
            if floor[leg] > min(least.distance, within):
                break
            margin = self.bounds.leg_margin(points[leg], points[leg + 1])
            if (margin.distance, leg) < (least.distance, least.leg):
                least = replace(margin, leg=int(leg))
        return least

    @cached_property
    def _circles(self) -> tuple[Plane, Vector]:
        """Return middles (k, 2) and radii (k,) of circles that contain the obstacles, seen from above."""
        corners = np.array([obstacle.bounds[:, :2] for obstacle in self.obstacles]).reshape(-1, 2, 2)
        radii = np.linalg.norm(corners[:, 1] - corners[:, 0], axis=1) / 2
        for n, obstacle in enumerate(self.obstacles):
            if isinstance(obstacle, Part):
                radii[n] = obstacle.grid_row().plan_radius
        return corners.mean(axis=1), radii

    @cached_property
    def _columns(self) -> tuple[NDArray[np.object_], Vector, Vector, Vector]:
        """Return shapes, radii, bases and tops of the obstacles' columns, (k,) each; without one, None and NaN."""
        columns = [body.column or Column(None, np.nan, *body.bounds[:, 2]) for body in self.obstacles]
        shapes, *numbers = zip(*columns, strict=True)
        radii, base, top = np.array(numbers, dtype=np.float64)
        return np.array(shapes, dtype=object), radii, base, top

    @cached_property
    def _index(self) -> shapely.STRtree:
        boxes = np.array([obstacle.bounds[:, :2].ravel() for obstacle in self.obstacles])
        return shapely.STRtree(shapely.box(*boxes.T))


def _clearance(points: Points, what: str, distance: float, leg: int, fraction: float) -> Clearance:
    a, b = points[leg], points[leg + 1]
    return Clearance(distance, as_place(a + fraction * (b - a)), what, leg)


def _grouped(pairs: NDArray[np.intp]) -> Iterator[tuple[int, NDArray[np.intp]]]:
    queries, bodies = pairs
    order = np.argsort(bodies, kind="stable")
    numbers, first = np.unique(bodies[order], return_index=True)
    yield from zip(numbers.tolist(), np.split(queries[order], first[1:]), strict=False)
