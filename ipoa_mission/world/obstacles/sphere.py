from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray

from ipoa_mission.geometry import Points, Vector
from ipoa_mission.world.obstacles.nearest import foot, least, straightened
from ipoa_mission.world.obstacles.obstacle import NO_EDGES, SPHERE, GridRow, Part, Passing, expect_positive
from ipoa_mission.world.polygon import Plane, circle


@dataclass(frozen=True)
class Sphere(Part):
    """A ball.

    Attributes:
        name: in messages.
        center: east, north and up [m].
        radius: above zero [m].

    Example:
        >>> import numpy as np
        >>> Sphere("ball", (50.0, 0.0, 30.0), 10.0).distance(np.array([[30.0, 0.0, 30.0]]))
        array([10.])
    """

    name: str
    center: tuple[float, float, float]
    radius: float

    def __post_init__(self) -> None:
        expect_positive(self.name, "radius", self.radius)

    @property
    def bounds(self) -> NDArray[np.float64]:
        return np.array([np.subtract(self.center, self.radius), np.add(self.center, self.radius)])

    @property
    def convex(self) -> bool:
        return True

    @property
    def parts(self) -> tuple["Sphere"]:
        return (self,)

    @property
    def horizontal_shape(self) -> shapely.Geometry:
        return shapely.Point(self.center[:2]).buffer(self.radius)

    def grown(self, aside: float, below: float, above: float) -> "Sphere":
        return Sphere(self.name, self.center, self.radius + aside)

    def passing(self, a: Points, b: Points) -> Passing:
        """Return distances to the tangent plane nearest to each leg."""
        away = self._away(a, b)
        length = np.maximum(np.linalg.norm(away, axis=1), 1e-9)
        share = (length - self.radius) / length
        up = share * away[:, 2]
        return Passing(share * np.hypot(away[:, 0], away[:, 1]), up, -up, np.ones(len(a)))

    def leg_distances(self, a: Points, b: Points) -> Vector:
        return np.asarray(np.linalg.norm(self._away(a, b), axis=1) - self.radius)

    def _away(self, a: Points, b: Points) -> Points:
        step, center = b - a, np.asarray(self.center)
        squares = np.maximum((step**2).sum(axis=1), 1e-12)
        along = np.clip(((center - a) * step).sum(axis=1) / squares, 0.0, 1.0)
        return np.asarray(a + along[:, None] * step - center)

    def distance(self, points: Points) -> Vector:
        return np.asarray(np.linalg.norm(points - np.asarray(self.center), axis=1) - self.radius)

    def leg_clearance(self, a: Vector, b: Vector) -> tuple[float, float]:
        b = straightened(a, b)
        return least(self, a, b, foot(a, b, np.asarray(self.center)))

    def outline(self) -> tuple[Plane, ...]:
        return (circle(*self.center[:2], self.radius),)

    def silhouette(self, axis: int) -> Plane:
        return circle(self.center[axis], self.center[2], self.radius)

    @property
    def plan_radius(self) -> float:
        return self.radius

    def grid_row(self) -> GridRow:
        east, north, up = self.center
        return GridRow(SPHERE, (east, north, up, self.radius, 0.0), NO_EDGES)
