"""What everyone asks of an obstacle; a new kind is one file that answers, mostly by inheriting from `Obstacle`.

Compiled code (the planner's kernels, the page's script) cannot ask objects. It knows three elementary bodies, and
every kind says by which `parts` it is to be stood for there: a sphere by itself, a cone perhaps by a pile of
cylinders. Proofs and checks ask the obstacle itself, and so they are exact.
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
    """An upright body: the ground plan `shape` (of shapely), larger by `radius` [m] all round, from `base` to `top`."""

    shape: Any
    radius: float
    base: float
    top: float


class Passing(NamedTuple):
    """How straight legs pass a body, (n,) each: distances that no part of a leg falls short of [m].

    `aside` is to its outline, `above` over its top and `below` under its base; `sides` is on how many a leg can hit it.
    """

    aside: Vector
    above: Vector
    below: Vector
    sides: Vector


class Obstacle(ABC):
    """A closed body with a name; of a new kind these must be said: `bounds`, `parts`, `distance`, `leg_clearance`.

    What a kind does not say else: it is a solid, and drawn as its parts, and as its box from above and the side.
    """

    name: str
    """What messages call it."""

    @property
    @abstractmethod
    def bounds(self) -> NDArray[np.float64]:
        """The box around it, (2, 3): lower and upper corner [m]."""

    @property
    @abstractmethod
    def parts(self) -> "tuple[Part, ...]":
        """Elementary bodies that cover it closely; the cost of a path counts each as a threat of its own."""

    @abstractmethod
    def distance(self, points: Points) -> Vector:
        """Euclidean distance of points (n, 3) to the surface, (n,) [m]: negative inside."""

    @abstractmethod
    def leg_clearance(self, a: Vector, b: Vector) -> tuple[float, float]:
        """Least signed distance [m] of the straight leg from a to b, and the fraction of the leg where it is."""

    @property
    def convex(self) -> bool:
        """Whether it is known to be convex; then distance along a straight leg is a convex function."""
        return False

    @property
    def solid(self) -> bool:
        """Whether something stands there; a zone is air that may not be entered."""
        return True

    @property
    def column(self) -> Column | None:
        """Itself as an upright body, if it is one."""
        return None

    @property
    def plan(self) -> Any:
        """Its ground plan, a geometry of shapely: that of its column, or its box."""
        if (column := self.column) is not None:
            return column.shape.buffer(column.radius) if column.radius else column.shape
        return shapely.box(*self.bounds[:, :2].ravel())

    def grown(self, aside: float, below: float, above: float) -> "Obstacle":
        """The same, larger by so much [m]; one that cannot grow stays as it is."""
        return self

    def passing(self, a: Points, b: Points) -> Passing:
        """How the straight legs from a to b (n, 3) pass it.

        Beside its column or its box, over its top or under its base; a court or a corner has two sides.
        """
        lines = shapely.linestrings(np.stack([a[:, :2], b[:, :2]], axis=1))
        shape, radius, base, top = self.column or Column(self.plan, 0.0, *self.bounds[:, 2])
        sides = np.ones(len(a))
        if self.column is not None and not self.convex:
            sides = np.where(shapely.intersects(lines, shape.convex_hull), 2.0, 1.0)
        low, high = np.minimum(a[:, 2], b[:, 2]), np.maximum(a[:, 2], b[:, 2])
        return Passing(shapely.distance(lines, shape) - radius, low - top, base - high, sides)

    def leg_distances(self, a: Points, b: Points) -> Vector:
        """What the signed distance of the straight legs from a to b (n, 3) does not fall short of, (n,) [m].

        It is that distance where a leg is level or upright, and outside a body that stands upright.
        """
        aside, above, below, _ = self.passing(a, b)
        beyond = np.maximum(above, below)
        outside = np.hypot(np.maximum(aside, 0.0), np.maximum(beyond, 0.0))
        return np.asarray(outside + np.minimum(np.maximum(aside, beyond), 0.0))

    def outline(self) -> tuple[Plane, ...]:
        """Rings of the ground plan, each (n, 2) and open: the outer one, then the holes."""
        return (_rectangle(self.bounds[:, :2]),)

    def silhouette(self, axis: int) -> Plane:
        """Its shadow on the upright plane through `axis` (0: east, 1: north) and up, (n, 2): its front view."""
        return _rectangle(self.bounds[:, [axis, 2]])


class ChartRow(NamedTuple):
    """An elementary body as the planner's kernels have it: see `planning.chart.ObstacleGrid` for what the numbers are.

    Where there are `edges` (m, 4), of east, north, east, north, the first two numbers say which they are on the chart.
    """

    kind: int
    numbers: tuple[float, float, float, float, float]
    edges: NDArray[np.float64]


SPHERE, CYLINDER, PRISM = range(3)  # kinds of rows
NO_EDGES = np.zeros((0, 4))


class Part(Obstacle):
    """An elementary body, which compiled code knows."""

    @property
    @abstractmethod
    def plan_radius(self) -> float:
        """Radius [m] of a circle round its outline, about the middle of its box."""

    @abstractmethod
    def chart_row(self) -> ChartRow:
        """Itself for the planner's kernels."""

    @abstractmethod
    def page_shape(self) -> dict[str, Any]:
        """Itself for the page's script: numbers and arrays by name."""


def _rectangle(corners: NDArray[np.float64]) -> Plane:
    (left, low), (right, high) = corners
    return np.array([(left, low), (right, low), (right, high), (left, high)])


def expect_positive(name: str, what: str, value: float) -> None:
    """Refuse an extent that is none.

    Raises:
        BadInput: naming the obstacle and what of it.
    """
    if not value > 0:
        raise BadInput(f"expected a positive number of metres, not {value:g}", place=f"{name}.{what}")
