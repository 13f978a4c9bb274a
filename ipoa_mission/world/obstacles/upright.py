"""What stands upright on a ground plan, from `base` to `top`."""

from abc import abstractmethod

import numpy as np
from numpy.typing import NDArray

from ipoa_mission.geometry import Points, Vector
from ipoa_mission.world.obstacles.obstacle import Column, Part
from ipoa_mission.world.obstacles.surface import raised, roof, walls


class Upright(Part):
    """A plan between two heights [m]."""

    base: float
    top: float

    @property
    @abstractmethod
    def column(self) -> Column:
        """Its plan and heights."""

    def tiles(self, size: float) -> list[Points]:
        """The roof and the walls, diced."""
        rings = self.outline()
        return roof(rings, self.top, size) + [tile for r in rings for tile in walls(r, self.base, self.top, size)]

    def edges(self) -> list[Points]:
        """Roof and foot."""
        return [raised(np.vstack([ring, ring[:1]]), up) for ring in self.outline() for up in (self.base, self.top)]


def upright_distance(aside: Vector, up: Vector, base: float, top: float) -> NDArray[np.float64]:
    """Signed distance (n,) to an upright body, from the signed distance to its plan (n,) and heights (n,) [m]."""
    above = np.maximum(base - up, up - top)
    outside = np.hypot(np.maximum(aside, 0.0), np.maximum(above, 0.0))
    return np.asarray(outside + np.minimum(np.maximum(aside, above), 0.0))
