from dataclasses import dataclass
from functools import cached_property
from typing import TypeAlias

import numpy as np
import shapely

from ipoa_mission.errors import InvalidRing
from ipoa_mission.geometry import Plane, Vector

Ring: TypeAlias = tuple[tuple[float, float], ...]  # corners (east, north) [m], not closed
QUARTER_SEGMENTS = 4


def rings_of(shape: shapely.Polygon) -> tuple[Ring, tuple[Ring, ...]]:
    outer, *holes = (
        tuple((float(east), float(north)) for east, north in shapely.get_coordinates(ring)[:-1])
        for ring in (shape.exterior, *shape.interiors)
    )
    return outer, tuple(holes)


def circle(x: float, y: float, radius: float) -> Plane:
    corners = 32
    turn = np.arange(corners) * 2 * np.pi / corners
    return np.column_stack([x + radius * np.cos(turn), y + radius * np.sin(turn)])


@dataclass(frozen=True)
class Polygon:
    outer: Ring
    holes: tuple[Ring, ...] = ()

    def __post_init__(self) -> None:
        for ring in (self.outer, *self.holes):
            if len(ring) < 3:
                raise InvalidRing(f"expected at least 3 corners, not {len(ring)}", place="a polygon")
        if not (shape := self.shape).is_valid:
            words = f"expected rings that do not cross, not one with {shapely.is_valid_reason(shape)}"
            raise InvalidRing(words, place="a polygon")

    @cached_property
    def shape(self) -> shapely.Polygon:
        return shapely.Polygon(self.outer, self.holes)

    def buffered(self, by: float) -> shapely.Geometry:
        """Grow by `by` [m]; a shrunk shape may be pieces or nothing."""
        return shapely.buffer(self.shape, by, quad_segs=QUARTER_SEGMENTS)

    @cached_property
    def edges(self) -> tuple[Plane, Plane]:
        """Return begins and ends, (m, 2) each."""
        rings = (self.outer, *self.holes)
        starts = np.array([corner for ring in rings for corner in ring], float)
        ends = np.array([corner for ring in rings for corner in (*ring[1:], ring[0])], float)
        is_long = ((ends - starts) ** 2).sum(axis=1) > 0
        return starts[is_long], ends[is_long]

    @cached_property
    def convex(self) -> bool:
        starts, ends = self.edges
        before = ends - starts
        after = np.roll(before, -1, axis=0)
        turns = before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0]
        return not self.holes and bool((turns >= 0).all() or (turns <= 0).all())

    def distance(self, points: Plane) -> Vector:
        """Return signed distances of points (n, 2), (n,) [m]: negative inside."""
        from ipoa_mission.world._polygon import distances

        return np.asarray(distances(*self.edges, np.ascontiguousarray(points, dtype=np.float64)))

    def balance_parameters(self, a: Vector, b: Vector) -> Vector:
        """Return the parameters of the leg a-b where it may be farthest outside."""
        from ipoa_mission.world._polygon import balance

        return np.asarray(balance(*self.edges, np.zeros((0, 3)), a, b, False))
