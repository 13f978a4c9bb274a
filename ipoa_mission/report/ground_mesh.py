import math

import numpy as np

from ipoa_mission.world.airspace import Airspace
from ipoa_mission.world.polygon import Plane


def ground_mesh(airspace: Airspace, across: int) -> tuple[Plane, Plane, Plane]:
    """Return east, north and height of square cells over the bounds, each (rows, columns) [m].

    The longer side has `across` cells.
    """
    return ground_mesh_over(airspace, airspace.bounds.lower[:2], airspace.bounds.upper[:2], across)


def ground_mesh_over(
    airspace: Airspace, lower: tuple[float, float], upper: tuple[float, float], across: int
) -> tuple[Plane, Plane, Plane]:
    sides = np.subtract(upper, lower)
    counts = np.maximum(np.rint(sides / sides.max() * across), 1).astype(int) + 1
    east, north = np.meshgrid(*(np.linspace(a, b, n) for a, b, n in zip(lower, upper, counts, strict=True)))
    up = airspace.ground(np.column_stack([east.ravel(), north.ravel()]))
    return east, north, up.reshape(east.shape)


def round_step(value: float) -> float:
    """Return the smallest of 1, 2, 5, 10, ... times a power of ten that is at least `value`."""
    power = 10.0 ** math.floor(math.log10(value))
    return float(next(k * power for k in (1, 2, 5, 10) if k * power >= value * (1 - 1e-9)))
