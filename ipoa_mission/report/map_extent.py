"""The part of the world that a map shows, and its ground."""

from dataclasses import dataclass

import numpy as np

from ipoa_mission.geometry import Points
from ipoa_mission.world.airspace import Airspace
from ipoa_mission.world.obstacles import Obstacle
from ipoa_mission.world.polygon import Plane


@dataclass(frozen=True)
class Extent:
    """Corners (east, north) [m]."""

    lower: tuple[float, float]
    upper: tuple[float, float]

    def obstacles(self, airspace: Airspace) -> tuple[Obstacle, ...]:
        return tuple(
            body
            for body in airspace.obstacles
            if (body.bounds[1, :2] > self.lower).all() and (body.bounds[0, :2] < self.upper).all()
        )

    def buildings(self, airspace: Airspace) -> tuple[Obstacle, ...]:
        """Leave zones out."""
        return tuple(body for body in self.obstacles(airspace) if body.solid)


def extent_of(*paths: Points) -> Extent:
    """Add 18 % of the longer side, at least 15 m; widen the shorter side to 0.62 of the longer."""
    points = np.vstack(paths)[:, :2]
    low, high = points.min(axis=0), points.max(axis=0)
    half = (high - low) / 2 + max(15.0, 0.18 * float((high - low).max()))
    half = np.maximum(half, 0.62 * half.max())
    (west, south), (east, north) = ((low + high) / 2 - half).tolist(), ((low + high) / 2 + half).tolist()
    return Extent((west, south), (east, north))


def ground_mesh(airspace: Airspace, across: int, extent: Extent | None = None) -> tuple[Plane, Plane, Plane]:
    """Return east, north, height of square cells, `across` on the longer side, over an extent or the bounds [m]."""
    box = Extent(airspace.bounds.lower[:2], airspace.bounds.upper[:2]) if extent is None else extent
    sides = np.subtract(box.upper, box.lower)
    counts = np.maximum(np.rint(sides / sides.max() * across), 1).astype(int) + 1
    east, north = np.meshgrid(*(np.linspace(a, b, n) for a, b, n in zip(box.lower, box.upper, counts, strict=True)))
    up = airspace.ground(np.column_stack([east.ravel(), north.ravel()]))
    return east, north, up.reshape(east.shape)
