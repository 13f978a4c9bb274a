"""The ground as a value: how high it is above home, wherever one asks, and nothing of how to fly over it.

It can be compared by what it is made of, kept in a mission, and handed to another process.
"""

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from ipoa_mission.geometry import Vector

EARTH_RADIUS = 6_371_000.0  # of the round Earth on which a vehicle counts heights [m]


class HasHeight(Protocol):
    """Any terrain, as far as heights go."""

    def height(self, points: NDArray[np.float64]) -> Vector:
        """Height [m] under points (n, 2 or 3) east, north(, up), (n,)."""


@dataclass(frozen=True, eq=False)
class Ground:
    """Ground over a `terrain` (None: nothing is known, and it is as high as home), told from `datum` upwards [m].

    `earth_radius` [m]: heights are told as a vehicle counts them, on a round Earth, not over home's plane.

    >>> Ground().at(30.0, 40.0)
    0.0
    >>> Ground(HighPlace((100.0, 0.0), 8.5))(np.array([[90.0, 0.0], [10.0, 0.0]]))
    array([8.5, 0. ])
    """

    terrain: HasHeight | None = None
    datum: float = 0.0
    earth_radius: float = np.inf

    @property
    def is_level(self) -> bool:
        """Whether nothing is known of it."""
        return self.terrain is None

    def __call__(self, points: NDArray[np.float64]) -> Vector:
        """Its height under points (n, 2 or 3), (n,) [m]."""
        if self.terrain is None:
            return np.zeros(len(points))
        heights = self.terrain.height(points)
        if self.datum == 0.0 and np.isinf(self.earth_radius):
            return heights
        return heights - self.datum + (points[:, 0] ** 2 + points[:, 1] ** 2) / (2 * self.earth_radius)

    def at(self, east: float, north: float) -> float:
        """Its height at one place [m]."""
        return 0.0 if self.terrain is None else float(self(np.array([[east, north]]))[0])


#: The ground where nothing is known of it: as high as home.
LEVEL = Ground()


@dataclass(frozen=True)
class HighPlace:
    """Ground so high about one place (east, north), nearer to it than to home, and as high as home elsewhere [m]."""

    place: tuple[float, float]
    level: float

    def height(self, points: NDArray[np.float64]) -> Vector:
        """Height under points (n, 2 or 3), (n,)."""
        there = np.hypot(points[:, 0] - self.place[0], points[:, 1] - self.place[1])
        return np.where(there < np.hypot(points[:, 0], points[:, 1]), self.level, 0.0)
