from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from ipoa_mission.geometry import Vector


class HasHeight(Protocol):
    def height(self, points: NDArray[np.float64]) -> Vector:
        """Return heights [m] under points (n, 2 or 3), (n,)."""


@dataclass(frozen=True, eq=False)
class Ground:
    """Ground over a `terrain` (None: unknown, level with home), in heights above `datum` [m].

    With `earth_radius` [m], heights are as a vehicle counts them on a spherical Earth.

    >>> Ground().at(30.0, 40.0)
    0.0
    >>> Ground(HighPlace((100.0, 0.0), 8.5))(np.array([[90.0, 0.0], [10.0, 0.0]]))
    array([8.5, 0. ])
    """

    terrain: HasHeight | None = None
    datum: float = 0.0
    earth_radius: float = np.inf

    @property
    def is_flat(self) -> bool:
        return self.terrain is None

    def __call__(self, points: NDArray[np.float64]) -> Vector:
        if self.terrain is None:
            return np.zeros(len(points))
        heights = self.terrain.height(points)
        if self.datum == 0.0 and np.isinf(self.earth_radius):
            return heights
        return heights - self.datum + (points[:, 0] ** 2 + points[:, 1] ** 2) / (2 * self.earth_radius)

    def at(self, east: float, north: float) -> float:
        return 0.0 if self.terrain is None else float(self(np.array([[east, north]]))[0])


FLAT_GROUND = Ground()


class MovedTerrain(NamedTuple):
    """A terrain of another frame, to which `move` leads."""

    terrain: HasHeight
    move: Callable[[NDArray[np.float64]], NDArray[np.float64]]

    def height(self, points: NDArray[np.float64]) -> Vector:
        moved = self.move(np.column_stack([points[:, :2], np.zeros(len(points))]))
        return np.asarray(self.terrain.height(moved) - moved[:, 2])


class HighPlace(NamedTuple):
    """Ground at `level` [m] nearer to a place (east, north) than to home."""

    place: tuple[float, float]
    level: float

    def height(self, points: NDArray[np.float64]) -> Vector:
        there = np.hypot(points[:, 0] - self.place[0], points[:, 1] - self.place[1])
        return np.where(there < np.hypot(points[:, 0], points[:, 1]), self.level, 0.0)
