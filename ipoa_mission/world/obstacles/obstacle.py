"""Interface of obstacles: a new kind is a subclass of `Obstacle`.

The planner's kernels know only three elementary bodies, the `parts` of every kind.
"""

from abc import ABC, abstractmethod
from typing import Any, ClassVar, NamedTuple

import numpy as np
import shapely
from numpy.typing import NDArray

from ipoa_mission.errors import BadInput
from ipoa_mission.geometry import Plane, Points, Vector


class Column(NamedTuple):
    """The plan `shape`, grown by `radius` [m], from `base` to `top`."""

    shape: Any
    radius: float
    base: float
    top: float


class Passing(NamedTuple):
    """Lower bounds of legs' distances, (n,) [m]; `sides`: number of sides on which a leg can hit it."""

    aside: Vector
    above: Vector
    below: Vector
    sides: Vector


class Obstacle(ABC):
    """A closed body, drawn by default as its parts and its box.

    Proofs use `leg_clearance`, the clearance as flown `column`, or else `parts`.
    """

    name: str
    solid: ClassVar[bool] = True

    @property
    @abstractmethod
    def bounds(self) -> NDArray[np.float64]:
        """Return lower and upper corner, (2, 3) [m]."""

    @property
    @abstractmethod
    def parts(self) -> "tuple[Part, ...]":
        """Return elementary bodies that cover it closely."""

    @abstractmethod
    def distance(self, points: Points) -> Vector:
        """Return signed distances (n,) [m]: negative inside."""

    @abstractmethod
    def leg_clearance(self, a: Vector, b: Vector) -> tuple[float, float]:
        """Return the leg's least signed distance [m], and its fraction."""

    @property
    def convex(self) -> bool:
        return False

    @property
    def column(self) -> Column | None:
        """Return its upright column; without one its parts bound distances, its box is its shape, no view has it."""
        return None

    @property
    def horizontal_shape(self) -> Any:
        if (column := self.column) is not None:
            return column.shape.buffer(column.radius) if column.radius else column.shape
        return shapely.box(*self.bounds[:, :2].ravel())

    @abstractmethod
    def grown(self, aside: float, below: float, above: float) -> "Obstacle":
        """Return a body with at least this room [m] around, below and above this one."""

    def passings(self, a: Points, b: Points) -> "tuple[Passing, ...]":
        """Bound the distances to each body that covers it."""
        if self.column is not None:
            return (self.passing(a, b),)
        sides = np.full(len(a), 1.0 if self.convex else 2.0)  # a leg may pass between two parts
        return tuple(part.passing(a, b)._replace(sides=sides) for part in self.parts)

    def passing(self, a: Points, b: Points) -> Passing:
        """Bound the distances to its column; a courtyard or corner has two sides."""
        assert self.column is not None
        lines = shapely.linestrings(np.stack([a[:, :2], b[:, :2]], axis=1))
        shape, radius, base, top = self.column
        sides = np.ones(len(a))
        if not self.convex:
            sides = np.where(shapely.intersects(lines, shape.convex_hull), 2.0, 1.0)
        low, high = np.minimum(a[:, 2], b[:, 2]), np.maximum(a[:, 2], b[:, 2])
        return Passing(shapely.distance(lines, shape) - radius, low - top, base - high, sides)

    def leg_distances(self, a: Points, b: Points) -> Vector:
        """Bound legs' signed distances (n,) [m], exactly if level or vertical outside an upright body."""
        if self.column is None:
            return np.asarray(np.min([part.leg_distances(a, b) for part in self.parts], axis=0))
        aside, above, below, _ = self.passing(a, b)
        return distance_of(aside, np.maximum(above, below))

    def outline(self) -> tuple[Plane, ...]:
        """Return open rings of the plan (n, 2), the outer one first."""
        return (_rectangle(self.bounds[:, :2]),)

    def silhouette(self, axis: int) -> Plane:
        """Return its outline along `axis` (0: east, 1: north) and up, (n, 2)."""
        return _rectangle(self.bounds[:, [axis, 2]])


SPHERE, CYLINDER, PRISM = range(3)  # kinds of rows
NO_EDGES = np.zeros((0, 4))


class GridRow(NamedTuple):
    """A row of `planning.obstacle_grid.ObstacleGrid`.

    `plan_radius` [m] is that around the middle of its box. The grid sets the indices of `edges` (m, 4), east, north,
    east, north, as the first two numbers.
    """

    kind: int
    numbers: tuple[float, float, float, float, float]
    plan_radius: float
    edges: NDArray[np.float64] = NO_EDGES


class Part(Obstacle):
    @property
    def parts(self) -> "tuple[Part, ...]":
        return (self,)

    @abstractmethod
    def grid_row(self) -> GridRow:
        """Return its row for the planner's kernels."""


def _rectangle(corners: NDArray[np.float64]) -> Plane:
    (left, low), (right, high) = corners
    return np.array([(left, low), (right, low), (right, high), (left, high)])


def distance_of(aside: Vector, above: Vector) -> Vector:
    """Return signed distances to an upright body by those to its outline, and to its top or base, (n,) [m]."""
    outside = np.hypot(np.maximum(aside, 0.0), np.maximum(above, 0.0))
    return np.asarray(outside + np.minimum(np.maximum(aside, above), 0.0))


def expect_positive(name: str, what: str, value: float) -> None:
    if not value > 0:
        raise BadInput(f"expected a positive number of meters, not {value:g}", place=f"{name}.{what}")
