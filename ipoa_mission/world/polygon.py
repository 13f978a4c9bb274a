"""A polygon with holes in the east, north plane, and exact distances to it.

All that is asked of it along a straight line is answered by candidates: along a line the squared distance to every
vertex and to every edge's line is a quadratic, so the extremes lie at parameters that can be written down.
"""

from dataclasses import dataclass
from functools import cached_property
from itertools import combinations
from typing import TypeAlias

import numpy as np
import shapely
from numpy.typing import NDArray

from ipoa_mission.errors import InvalidRing
from ipoa_mission.geometry import Vector

Ring: TypeAlias = tuple[tuple[float, float], ...]  # corners (east, north) [m], in either sense, not closed
Plane: TypeAlias = NDArray[np.float64]  # (n, 2) east, north [m]
FEW_EDGES = 6
CORNERS = 4  # of the polygon round a corner that is rounded, for a quarter turn
NARROW = 1e-8  # spans are not halved any further [m]
CIRCLE = 32  # corners of a drawn circle


def rings_of(shape: shapely.Polygon) -> tuple[Ring, tuple[Ring, ...]]:
    """The outer ring and the holes of a valid polygon of shapely."""
    outer, *holes = (
        tuple((float(east), float(north)) for east, north in shapely.get_coordinates(ring)[:-1])
        for ring in (shape.exterior, *shape.interiors)
    )
    return outer, tuple(holes)


def circle(x: float, y: float, radius: float) -> Plane:
    """A drawn circle round (x, y) as a ring, (32, 2)."""
    turn = np.arange(CIRCLE) * 2 * np.pi / CIRCLE
    return np.column_stack([x + radius * np.cos(turn), y + radius * np.sin(turn)])


@dataclass(frozen=True)
class Polygon:
    """The area inside `outer` and outside every ring of `holes`."""

    outer: Ring
    holes: tuple[Ring, ...] = ()

    def __post_init__(self) -> None:
        for ring in (self.outer, *self.holes):
            if len(ring) < 3:
                raise InvalidRing(f"expected at least 3 corners, not {len(ring)}", place="a polygon")
        if not (shape := self.shape).is_valid:
            words = f"expected rings that do not cross, not one with {shapely.is_valid_reason(shape)}"
            raise InvalidRing(words, place="a polygon")

    @property
    def shape(self) -> shapely.Polygon:
        """The same polygon as shapely knows it."""
        return shapely.Polygon(self.outer, self.holes)

    def buffered(self, by: float) -> shapely.Geometry:
        """Its shape, larger by so much [m]; less than 0: smaller, and perhaps in pieces, or nothing."""
        return shapely.buffer(self.shape, by, quad_segs=CORNERS)

    @property
    def starts(self) -> Plane:
        """The corner at which each edge begins, (m, 2)."""
        return self._edges[0]

    @property
    def ends(self) -> Plane:
        """The corner at which each edge ends, (m, 2)."""
        return self._edges[1]

    @cached_property
    def _edges(self) -> tuple[Plane, Plane]:
        """Both ends of each edge; a corner that is given twice in a row is one corner."""
        rings = (self.outer, *self.holes)
        starts = np.array([corner for ring in rings for corner in ring], float)
        ends = np.array([corner for ring in rings for corner in (*ring[1:], ring[0])], float)
        real = ((ends - starts) ** 2).sum(axis=1) > 0
        return starts[real], ends[real]

    @cached_property
    def convex(self) -> bool:
        """Whether it has no holes and turns the same way at every corner."""
        along = self.ends - self.starts
        turns = _cross(along, np.roll(along, -1, axis=0))
        return not self.holes and bool((turns >= 0).all() or (turns <= 0).all())

    def distance(self, points: Plane) -> Vector:
        """Signed distance of points (n, 2) to the outline, (n,): negative inside."""
        nearest = self.edge_distances(points).min(axis=1)
        return np.asarray(np.where(self.contains(points), -nearest, nearest))

    def contains(self, points: Plane) -> NDArray[np.bool_]:
        """Whether each point (n, 2) is inside, by the even-odd rule, (n,)."""
        (e0, n0), (run, rise), _ = self._lines
        east, north = points[:, :1], points[:, 1:2]
        spans = (n0 > north) != (self.ends[:, 1] > north)
        slope = run / np.where(rise == 0, 1.0, rise)
        return np.asarray(np.count_nonzero(spans & (east < e0 + (north - n0) * slope), axis=1) % 2 == 1)

    def edge_distances(self, points: Plane) -> NDArray[np.float64]:
        """Distance of each point (n, 2) to each edge, (n, m)."""
        (east, north), (along_e, along_n), squares = self._lines
        away_e, away_n = points[:, :1] - east, points[:, 1:2] - north
        share = np.minimum(np.maximum((away_e * along_e + away_n * along_n) / squares, 0.0), 1.0)
        away_e -= share * along_e
        away_n -= share * along_n
        return np.asarray(np.sqrt(away_e * away_e + away_n * away_n))

    @cached_property
    def _lines(self) -> tuple[Plane, Plane, Vector]:
        """Where each edge begins (2, m), its way from there (2, m), and the square of its length (m,)."""
        along = (self.ends - self.starts).T.copy()
        return self.starts.T.copy(), along, (along**2).sum(axis=0)

    def break_parameters(self, a: Vector, b: Vector) -> Vector:
        """Where the line a + t (b - a) in the plane passes abreast of a corner or crosses an edge's line; any order."""
        step, along, away = b - a, self.ends - self.starts, self.starts - a
        square = float(step @ step)
        feet: Vector = away @ step / square if square > 0 else np.zeros(0)
        cross = _cross(step, along)
        crossings = (_cross(away, along) / np.where(cross == 0, 1.0, cross))[cross != 0]
        slope = along @ step
        abreast = [
            np.einsum("mk,mk->m", corner - a, along)[slope != 0] / slope[slope != 0]
            for corner in (self.starts, self.ends)
        ]
        return np.concatenate([feet, crossings, *abreast])

    def balance_parameters(self, a: Vector, b: Vector, others: NDArray[np.float64], inside: bool) -> Vector:
        """Where on the leg a-b in the plane, inside (or else outside), the outline may be farthest; any order.

        There two squared distances are equal: to corners, to edges, or to the walls given in `others` (k, 3) as
        coefficients of 1, t, t^2. Spans of the leg in which one of few edges must be nearest are solved at once,
        longer ones are halved, and those that cannot hold the greatest distance are dropped.
        """
        parameters, spans = [np.array([0.0, 1.0])], [(0.0, 1.0)]
        length, greatest = float(np.linalg.norm(b - a)), 0.0
        while spans:
            low, high = spans.pop()
            middle, reach = (low + high) / 2, (high - low) * length
            spot = (a + middle * (b - a))[None, :]
            away = self.edge_distances(spot)[0]
            walls = np.sqrt(np.maximum(others @ [1.0, middle, middle**2], 0.0))
            here = min(away.min(), walls.min(initial=np.inf))
            wanted = bool(self.contains(spot)[0]) == inside
            if wanted and here > greatest:
                greatest = here
                parameters.append(np.array([middle]))
            if reach < NARROW or away.min() + reach / 2 < greatest or (not wanted and reach / 2 < away.min()):
                continue
            near = away <= away.min() + reach
            if near.sum() <= FEW_EDGES:
                parameters.append(_equal(np.vstack([self._squares(a, b, near), others])))
            else:
                spans += [(low, middle), (middle, high)]
        return np.concatenate(parameters)

    def _squares(self, a: Vector, b: Vector, edges: NDArray[np.bool_]) -> NDArray[np.float64]:
        """Squared distances along the line to the lines and corners of some edges: coefficients of 1, t, t^2."""
        step, along = b - a, (self.ends - self.starts)[edges]
        normal = np.column_stack([-along[:, 1], along[:, 0]]) / np.linalg.norm(along, axis=1)[:, None]
        offset, drift = np.einsum("mk,mk->m", a - self.starts[edges], normal), normal @ step
        corners = a - np.unique(np.vstack([self.starts[edges], self.ends[edges]]), axis=0)
        lines = np.column_stack([offset**2, 2 * offset * drift, drift**2])
        points = np.column_stack([(corners**2).sum(axis=1), 2 * corners @ step, np.full(len(corners), step @ step)])
        return np.vstack([lines, points])


def quadratic_roots(c0: Vector, c1: Vector, c2: Vector) -> Vector:
    """Real parts of all roots of c0 + c1 t + c2 t^2, any order; those of degenerate equations are left out."""
    flat = np.asarray(c2 == 0)
    root = np.sqrt(np.maximum(c1**2 - 4 * c2 * c0, 0.0))
    q = -0.5 * (c1 + np.copysign(root, c1))
    both: Vector = np.concatenate([q[~flat] / c2[~flat], c0[q != 0] / q[q != 0]])
    return both[np.isfinite(both)]


def _equal(squares: NDArray[np.float64]) -> Vector:
    """Parameters at which any two of these quadratics (k, 3) are equal."""
    pairs = np.array(list(combinations(range(len(squares)), 2)), dtype=int).reshape(-1, 2)
    differences = squares[pairs[:, 0]] - squares[pairs[:, 1]]
    return quadratic_roots(*differences.T)


def _cross(u: NDArray[np.float64], v: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.asarray(u[..., 0] * v[..., 1] - u[..., 1] * v[..., 0])
