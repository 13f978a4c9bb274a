from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ipoa_mission.errors import BadInput
from ipoa_mission.geometry import Points, Vector
from ipoa_mission.world.obstacles.nearest import straightened, upright_distance
from ipoa_mission.world.obstacles.obstacle import PRISM, Column, GridRow, Part, expect_positive
from ipoa_mission.world.polygon import Plane, Polygon, Ring, rings_of


@dataclass(frozen=True)
class Prism(Part):
    """An extruded polygon: a building with its courtyards, or a box.

    Attributes:
        name: in messages.
        outer: corners (east, north) [m], in either direction, the first not repeated.
        holes: rings of the same kind inside it.
        base: its lowest height [m].
        top: its greatest height [m].

    Example:
        >>> import numpy as np
        >>> hall = Prism("hall", ((0.0, 0.0), (30.0, 0.0), (30.0, 20.0), (0.0, 20.0)), holes=(), base=0.0, top=12.0)
        >>> hall.distance(np.array([[15.0, 10.0, 15.0], [33.0, 10.0, 5.0]]))
        array([3., 3.])
    """

    name: str
    outer: Ring
    holes: tuple[Ring, ...]
    base: float
    top: float

    def __post_init__(self) -> None:
        expect_positive(self.name, "top - base", self.top - self.base)
        _ = self.footprint  # raises if invalid

    @cached_property
    def footprint(self) -> Polygon:
        try:
            return Polygon(self.outer, self.holes)
        except BadInput as error:
            raise error.at(self.name) from None

    @property
    def bounds(self) -> NDArray[np.float64]:
        corners = self.footprint.starts
        return np.array([[*corners.min(axis=0), self.base], [*corners.max(axis=0), self.top]])

    @property
    def convex(self) -> bool:
        return self.footprint.convex

    @property
    def column(self) -> Column:
        return Column(self.footprint.shape, 0.0, self.base, self.top)

    @property
    def parts(self) -> tuple["Prism"]:
        return (self,)

    def grown(self, aside: float, below: float, above: float) -> "Prism":
        outer, holes = rings_of(self.footprint.buffered(aside))
        return type(self)(self.name, outer, holes, self.base - below, self.top + above)

    def distance(self, points: Points) -> Vector:
        return upright_distance(self.footprint.distance(points[:, :2]), points[:, 2], self.base, self.top)

    def leg_clearance(self, a: Vector, b: Vector) -> tuple[float, float]:
        from ipoa_mission.world.obstacles._prism import nearest

        a, b = np.asarray(a, dtype=np.float64), np.asarray(straightened(a, b), dtype=np.float64)
        return nearest(self.footprint.starts, self.footprint.ends, self.base, self.top, a, b)  # type: ignore[no-any-return]

    def outline(self) -> tuple[Plane, ...]:
        return tuple(np.asarray(ring, float) for ring in (self.outer, *self.holes))

    @property
    def plan_radius(self) -> float:
        lower, upper = self.bounds
        return float(np.hypot(*(upper - lower)[:2])) / 2

    def grid_row(self) -> GridRow:
        edges = np.hstack([self.footprint.starts, self.footprint.ends])
        return GridRow(PRISM, (0.0, 0.0, 0.0, self.base, self.top), edges)


class Zone(Prism):
    """A prism of forbidden air."""

    @property
    def solid(self) -> bool:
        return False


def box(name: str, lower: tuple[float, float, float], upper: tuple[float, float, float]) -> Prism:
    (e0, n0, base), (e1, n1, top) = lower, upper
    return Prism(name, ((e0, n0), (e1, n0), (e1, n1), (e0, n1)), (), base, top)
