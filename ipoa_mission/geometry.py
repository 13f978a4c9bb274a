"""Vectors and polylines in the local frame, and unions of polygons."""

import math
from typing import Any, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

Points: TypeAlias = NDArray[np.float64]  # (n, 3) east, north, up [m]
Plane: TypeAlias = NDArray[np.float64]  # (n, 2) east, north [m]
Samples: TypeAlias = NDArray[np.float64]  # (n, 7) time [s], place [m], velocity [m/s]
Matrix: TypeAlias = NDArray[np.float64]  # (n, m)
Vector: TypeAlias = NDArray[np.float64]  # (n,)
Place: TypeAlias = tuple[float, float, float]  # east, north, up [m]

GRAVITY = 9.80665  # standard [m/s^2]


def as_place(point: Vector) -> Place:
    return float(point[0]), float(point[1]), float(point[2])


def place_words(place: Place) -> str:
    east, north, up = place
    return f"at east {east:z.1f}, north {north:z.1f}, up {up:z.1f} m"


def bearing(degrees: float, digits: int = 0) -> float:
    """Round a direction to `digits`, 0 to below 360.

    >>> bearing(359.98, 1), bearing(-90.0)
    (0.0, 270.0)
    """
    return round(degrees, digits) % 360.0


class Enu(NamedTuple):
    """A place or vector of the local frame, for kernels."""

    east: float
    north: float
    up: float


ZERO = Enu(0.0, 0.0, 0.0)


def plus(first: Enu, second: Enu) -> Enu:
    return Enu(first.east + second.east, first.north + second.north, first.up + second.up)


def minus(first: Enu, second: Enu) -> Enu:
    return Enu(first.east - second.east, first.north - second.north, first.up - second.up)


def scaled(vector: Enu, factor: float) -> Enu:
    return Enu(vector.east * factor, vector.north * factor, vector.up * factor)


def dot(first: Enu, second: Enu) -> float:
    return first.east * second.east + first.north * second.north + first.up * second.up


def norm(vector: Enu) -> float:
    return math.sqrt(dot(vector, vector))


def horizontal_norm(vector: Enu) -> float:
    """Return the length of a vector's horizontal part."""
    return math.sqrt(vector.east * vector.east + vector.north * vector.north)


def leg_lengths(points: Points) -> Vector:
    """Return leg lengths (n-1,) [m]."""
    axes = np.ascontiguousarray(points.T)  # quicker for many points
    return np.asarray(np.linalg.norm(np.diff(axes), axis=0))


def arc_lengths(points: Points) -> Vector:
    """Return lengths from the first point, (n,) [m]."""
    return np.concatenate([[0.0], np.cumsum(leg_lengths(points))])


def polyline_length(points: Points) -> float:
    """Return the length [m]: the paper's W1, eq. (4)."""
    return float(leg_lengths(points).sum())


def turning_angles(points: Points) -> Vector:
    """Return horizontal angles between legs, (n-2,) [rad]: the paper's eqs. (5)-(6)."""
    legs = np.diff(points[:, :2], axis=0)
    before, after = legs[:-1], legs[1:]
    cross = before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0]
    return np.asarray(np.arctan2(np.abs(cross), np.einsum("ij,ij->i", before, after)))


def climb_angles(points: Points) -> Vector:
    """Return angles above the horizontal, (n-1,) [rad]: the paper's eq. (7)."""
    legs = np.diff(points, axis=0)
    return np.asarray(np.arctan2(legs[:, 2], np.hypot(legs[:, 0], legs[:, 1])))


def places_under(shape: Any, smallest: float = 20.0, apart: float = 5.0) -> Plane:
    """Return places (k, 2) on the edges of a shapely shape and within it, `apart` [m]; none under a small one."""
    import shapely  # slow import

    west, south, east, north = shape.bounds
    if max(east - west, north - south) <= smallest:
        return np.empty((0, 2))
    inside = np.stack(np.meshgrid(np.arange(west, east, apart), np.arange(south, north, apart)), axis=-1).reshape(-1, 2)
    edges = shapely.get_coordinates(shapely.segmentize(shape, apart))
    return np.vstack([edges, inside[shapely.contains_xy(shape, inside)]])


def union_of(areas: Any) -> Any:
    """Return the union of shapely polygons (n,), or nothing.

    GEOS 3.14 may lose some polygons where many just touch. A grid prevents this, but takes three times as long; it is
    used only if an inner point of a polygon is missing.
    """
    import shapely  # slow import

    areas = np.asarray(areas, dtype=object)
    whole = shapely.union_all(areas)
    shapely.prepare(whole)
    covered = shapely.intersects(whole, shapely.point_on_surface(areas)) | shapely.is_empty(areas)
    return whole if covered.all() else shapely.union_all(areas, grid_size=1e-9)  # [m or degrees]
