from dataclasses import dataclass

import numpy as np

from ipoa_mission.geometry import Points
from ipoa_mission.world.airspace import Airspace
from ipoa_mission.world.obstacles import Obstacle


@dataclass(frozen=True)
class Framing:
    least_room: float = 15.0  # [m]
    room: float = 0.18  # of the longer side
    slenderest: float = 0.62  # shorter side over longer side


FRAMING = Framing()


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
    """Paths are (n, 3); margins and proportions are limited."""
    points = np.vstack(paths)[:, :2]
    low, high = points.min(axis=0), points.max(axis=0)
    room = max(FRAMING.least_room, FRAMING.room * float((high - low).max()))
    half = (high - low) / 2 + room
    half = np.maximum(half, FRAMING.slenderest * half.max())
    middle = (low + high) / 2
    lower, upper = middle - half, middle + half
    return Extent((float(lower[0]), float(lower[1])), (float(upper[0]), float(upper[1])))
