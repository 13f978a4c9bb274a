from dataclasses import dataclass
from functools import cached_property
from typing import TypeAlias

import numpy as np
import shapely
from numpy.typing import NDArray

from ipoa_mission.errors import InvalidRing
from ipoa_mission.geometry import Vector

Ring: TypeAlias = tuple[tuple[float, float], ...]  # corners (east, north) [m], not closed
Plane: TypeAlias = NDArray[np.float64]  # (n, 2) east, north [m]
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

    @property
    def starts(self) -> Plane:
        return self._edges[0]

    @property
    def ends(self) -> Plane:
        return self._edges[1]

    @cached_property
    def _edges(self) -> tuple[Plane, Plane]:
        rings = (self.outer, *self.holes)
        starts = np.array([corner for ring in rings for corner in ring], float)
        ends = np.array([corner for ring in rings for corner in (*ring[1:], ring[0])], float)
        real = ((ends - starts) ** 2).sum(axis=1) > 0
        return starts[real], ends[real]

    @cached_property
    def convex(self) -> bool:
        along = self.ends - self.starts
        turns = _cross(along, np.roll(along, -1, axis=0))
        return not self.holes and bool((turns >= 0).all() or (turns <= 0).all())

    def distance(self, points: Plane) -> Vector:
        """Return signed distances of points (n, 2), (n,) [m]: negative inside."""
        from ipoa_mission.world._polygon import distances

        return np.asarray(distances(self.starts, self.ends, np.ascontiguousarray(points, dtype=np.float64)))

    def break_parameters(self, a: Vector, b: Vector) -> Vector:
        """Find the line a-b abreast of a corner or across an edge."""
        step = b - a
        along = self.ends - self.starts
        away = self.starts - a
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

    def balance_parameters(self, a: Vector, b: Vector) -> Vector:
        """Return the parameters of the leg a-b where it may be farthest outside."""
        from ipoa_mission.world._polygon import balance

        return np.asarray(balance(self.starts, self.ends, np.zeros((0, 3)), a, b, False))


def _cross(u: NDArray[np.float64], v: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.asarray(u[..., 0] * v[..., 1] - u[..., 1] * v[..., 0])
