from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray

from ipoa_mission.geometry import Points, Vector
from ipoa_mission.world.obstacles.nearest import derivative, foot, least, levels, roots, straightened, upright_distance
from ipoa_mission.world.obstacles.obstacle import CYLINDER, NO_EDGES, Column, GridRow, Part, expect_positive
from ipoa_mission.world.polygon import Plane, circle, quadratic_roots

TOUCHING = 1e-9  # relative


@dataclass(frozen=True)
class Cylinder(Part):
    """A vertical, closed cylinder: a tower, a mast, a tree.

    Attributes:
        name: in messages.
        east: of its axis [m].
        north: of its axis [m].
        radius: above zero [m].
        base: its lowest height [m].
        top: its greatest height [m].

    Example:
        >>> import numpy as np
        >>> mast = Cylinder("mast", east=60.0, north=45.0, radius=8.0, base=0.0, top=60.0)
        >>> mast.distance(np.array([[48.0, 45.0, 30.0]]))
        array([4.])
    """

    name: str
    east: float
    north: float
    radius: float
    base: float
    top: float

    def __post_init__(self) -> None:
        expect_positive(self.name, "radius", self.radius)
        expect_positive(self.name, "top - base", self.top - self.base)

    @property
    def bounds(self) -> NDArray[np.float64]:
        r = self.radius
        return np.array([[self.east - r, self.north - r, self.base], [self.east + r, self.north + r, self.top]])

    @property
    def convex(self) -> bool:
        return True

    @property
    def column(self) -> Column:
        return Column(shapely.Point(self.east, self.north), self.radius, self.base, self.top)

    @property
    def parts(self) -> tuple["Cylinder"]:
        return (self,)

    def grown(self, aside: float, below: float, above: float) -> "Cylinder":
        return Cylinder(self.name, self.east, self.north, self.radius + aside, self.base - below, self.top + above)

    def distance(self, points: Points) -> Vector:
        aside = np.hypot(points[:, 0] - self.east, points[:, 1] - self.north) - self.radius
        return upright_distance(aside, points[:, 2], self.base, self.top)

    def leg_clearance(self, a: Vector, b: Vector) -> tuple[float, float]:
        """Solve a quartic for the edge of a cap.

        Let q(t) be the squared distance to the axis and w(t) the height over a cap. The edge is nearest where (q' +
        (w^2)')^2 q = r^2 q'^2. Inside, side and cap balance where q = (r + w)^2.
        """
        b = straightened(a, b)
        axis = np.array([self.east, self.north])
        away, step = a[:2] - axis, (b - a)[:2]
        q = np.array([away @ away, 2 * away @ step, step @ step])
        candidates = [feet := foot(a[:2], b[:2], axis)]
        nearest = min(1.0, max(0.0, float(feet[0]))) if len(feet) else 0.0
        crosses = bool(q @ [1.0, nearest, nearest**2] <= (1 + TOUCHING) * self.radius**2)
        if crosses:
            candidates.append(quadratic_roots(*(q - [self.radius**2, 0, 0])[:, None]))
        for height, climb in ((a[2] - self.top, b[2] - a[2]), (self.base - a[2], a[2] - b[2])):
            if not crosses and max(height, height + climb) <= 0:
                continue
            w_squared = np.array([height**2, 2 * height * climb, climb**2])
            slope, both = derivative(q), derivative(q + w_squared)
            slope_squared = np.pad(np.convolve(slope, slope), (0, 2))
            quartic = np.convolve(np.convolve(both, both), q) - self.radius**2 * slope_squared
            candidates.append(roots(quartic))
            if crosses:
                balance = q - w_squared - 2 * self.radius * np.array([height, climb, 0]) - [self.radius**2, 0, 0]
                candidates.append(quadratic_roots(*balance[:, None]))
        return least(self, a, b, np.concatenate([*candidates, levels(a, b, self.base, self.top)]))

    def outline(self) -> tuple[Plane, ...]:
        return (circle(self.east, self.north, self.radius),)

    @property
    def plan_radius(self) -> float:
        return self.radius

    def grid_row(self) -> GridRow:
        return GridRow(CYLINDER, (self.east, self.north, self.radius, self.base, self.top), NO_EDGES)


class RoundZone(Cylinder):
    """A cylinder of forbidden air."""

    @property
    def solid(self) -> bool:
        return False
