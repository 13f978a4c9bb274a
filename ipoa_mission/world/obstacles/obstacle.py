"""Interface of obstacles; a new kind is one file with a subclass of `Obstacle`.

Compiled code (the planner's kernels, the page's script) knows only three elementary bodies. Every kind returns the
`parts` that represent it there: a sphere itself, a cone perhaps a pile of cylinders. Proofs and checks ask the obstacle
itself, so they are exact.
"""

from abc import ABC, abstractmethod
from typing import Any, NamedTuple

import numpy as np
import shapely
from numpy.typing import NDArray

from ipoa_mission.errors import BadInput
from ipoa_mission.geometry import Points, Vector
from ipoa_mission.world.polygon import Plane


class Column(NamedTuple):
    """An upright body: the shapely ground plan `shape`, grown by `radius` [m], from `base` to `top`."""

    shape: Any
    radius: float
    base: float
    top: float


class Passing(NamedTuple):
    """Lower bounds of the distances at which straight legs pass a body, (n,) each [m].

    `aside` is to its outline, `above` over its top, `below` under its base. `sides` is the number of sides on which a
    leg can hit it.
    """

    aside: Vector
    above: Vector
    below: Vector
    sides: Vector


class Obstacle(ABC):
    """A closed body with a name; a new kind defines `bounds`, `parts`, `distance` and `leg_clearance`.

    By default it is solid, drawn as its parts, and as its box from above and the side. Proofs use `leg_clearance`. The
    clearance as flown uses `column`, or else `parts`: the closer they cover it, the closer its bound.
    """

    name: str

    @property
    @abstractmethod
    def bounds(self) -> NDArray[np.float64]:
        """Return the box around it, (2, 3): lower and upper corner [m]."""

    @property
    @abstractmethod
    def parts(self) -> "tuple[Part, ...]":
        """Return elementary bodies that cover it closely; the cost of a path counts each as a threat."""

    @abstractmethod
    def distance(self, points: Points) -> Vector:
        """Return the Euclidean distance of points (n, 3) to the surface, (n,) [m]: negative inside."""

    @abstractmethod
    def leg_clearance(self, a: Vector, b: Vector) -> tuple[float, float]:
        """Return the least signed distance [m] of the straight leg from a to b, and the leg's fraction there."""

    @property
    def convex(self) -> bool:
        """Return whether it is surely convex; then the distance along a straight leg is convex."""
        return False

    @property
    def solid(self) -> bool:
        """Return whether it is a solid body; a zone is forbidden air."""
        return True

    @property
    def column(self) -> Column | None:
        return None

    @property
    def plan(self) -> Any:
        """Return its shapely ground plan: that of its column, or its box."""
        if (column := self.column) is not None:
            return column.shape.buffer(column.radius) if column.radius else column.shape
        return shapely.box(*self.bounds[:, :2].ravel())

    def grown(self, aside: float, below: float, above: float) -> "Obstacle":
        """Return it grown by these distances [m]; a kind that cannot grow stays."""
        return self

    def passings(self, a: Points, b: Points) -> "tuple[Passing, ...]":
        """Return the distances at which the straight legs from a to b (n, 3) pass each body that covers it."""
        if self.column is not None:
            return (self.passing(a, b),)
        sides = np.full(len(a), 1.0 if self.convex else 2.0)  # a leg may pass between two parts
        return tuple(part.passing(a, b)._replace(sides=sides) for part in self.parts)

    def passing(self, a: Points, b: Points) -> Passing:
        """Return the distances at which the straight legs from a to b (n, 3) pass its column.

        They are lateral to it, over its top, or under its base; a courtyard or corner has two sides.
        """
        assert self.column is not None
        lines = shapely.linestrings(np.stack([a[:, :2], b[:, :2]], axis=1))
        shape, radius, base, top = self.column
        sides = np.ones(len(a))
        if not self.convex:
            sides = np.where(shapely.intersects(lines, shape.convex_hull), 2.0, 1.0)
        low, high = np.minimum(a[:, 2], b[:, 2]), np.maximum(a[:, 2], b[:, 2])
        return Passing(shapely.distance(lines, shape) - radius, low - top, base - high, sides)

    def leg_distances(self, a: Points, b: Points) -> Vector:
        """Return lower bounds of the signed distances of the straight legs from a to b (n, 3), (n,) [m].

        A bound is exact for a level or vertical leg outside an upright body.
        """
        if self.column is None:
            return np.asarray(np.min([part.leg_distances(a, b) for part in self.parts], axis=0))
        aside, above, below, _ = self.passing(a, b)
        beyond = np.maximum(above, below)
        outside = np.hypot(np.maximum(aside, 0.0), np.maximum(beyond, 0.0))
        return np.asarray(outside + np.minimum(np.maximum(aside, beyond), 0.0))

    def outline(self) -> tuple[Plane, ...]:
        """Return rings of the ground plan, each (n, 2) and open: the outer one, then the holes."""
        return (_rectangle(self.bounds[:, :2]),)

    def silhouette(self, axis: int) -> Plane:
        """Return its silhouette on the vertical plane of `axis` (0: east, 1: north) and up, (n, 2)."""
        return _rectangle(self.bounds[:, [axis, 2]])


class GridRow(NamedTuple):
    """An elementary body for the planner's kernels; `planning.obstacle_grid.ObstacleGrid` defines the numbers.

    With `edges` (m, 4) of east, north, east, north, the first two numbers are replaced by their indices in the grid.
    """

    kind: int
    numbers: tuple[float, float, float, float, float]
    edges: NDArray[np.float64]


SPHERE, CYLINDER, PRISM = range(3)  # kinds of rows
NO_EDGES = np.zeros((0, 4))


class Part(Obstacle):
    """An elementary body that compiled code knows."""

    @property
    @abstractmethod
    def plan_radius(self) -> float:
        """Return the radius [m] of a circle around its outline, about the middle of its box."""

    @abstractmethod
    def grid_row(self) -> GridRow:
        """Return its row for the planner's kernels."""

    @abstractmethod
    def page_shape(self) -> dict[str, Any]:
        """Return it for the page's script: numbers and arrays by name."""


def _rectangle(corners: NDArray[np.float64]) -> Plane:
    (left, low), (right, high) = corners
    return np.array([(left, low), (right, low), (right, high), (left, high)])


def expect_positive(name: str, what: str, value: float) -> None:
    """Raise BadInput, with the obstacle's name, unless the extent is positive."""
    if not value > 0:
        raise BadInput(f"expected a positive number of metres, not {value:g}", place=f"{name}.{what}")
