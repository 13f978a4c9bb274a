"""Convert JSON geometries (RFC 7946, with circles of ED-269 and ED-318) to shapes [deg, WGS 84]."""

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import shapely
from pyproj import CRS, Geod, Transformer

from ipoa_mission.errors import BadInput, InvalidRing, TooLarge
from ipoa_mission.maps.feature import DEEPEST, Corners, is_altitude, on_earth

SHAPES = ("Point", "MultiPoint", "LineString", "MultiLineString", "Polygon", "MultiPolygon")
ToDegrees = Callable[[Corners], Corners]


def degrees_of(system: CRS) -> ToDegrees:
    if system.is_geographic and system.ellipsoid is not None and "WGS 84" in system.ellipsoid.name:
        return unchanged
    convert = Transformer.from_crs(system, "OGC:CRS84", always_xy=True)
    return lambda corners: np.column_stack(convert.transform(*corners.T))


def unchanged(corners: Corners) -> Corners:
    return corners


def shape_of(geometry: Any, place: str, to_degrees: ToDegrees = unchanged, depth: int = 0) -> Any:
    """Return the shape, maybe an invalid one; raise BadInput at the place of a mistake in its spelling."""
    kind = geometry.get("type") if isinstance(geometry, dict) else None
    if kind == "GeometryCollection":
        members = geometry.get("geometries")
        if not isinstance(members, list):
            raise BadInput("expected a list", place=f"{place}.geometries")
        if depth >= DEEPEST:
            raise TooLarge(f"expected collections in no more than {DEEPEST} others", place=f"{place[:80]}...")
        shapes = [shape_of(each, f"{place}.geometries[{i}]", to_degrees, depth + 1) for i, each in enumerate(members)]
        return shapely.GeometryCollection(shapes)
    if not isinstance(kind, str) or kind not in SHAPES:
        raise BadInput(f"expected a kind of geometry, such as 'Polygon', not {kind!r}", place=f"{place}.type")
    extent = geometry.get("extent")
    if kind == "Point" and isinstance(extent, dict):  # ED-318
        return circle(geometry.get("coordinates"), extent.get("radius"), f"{place}.extent")
    values = geometry.get("coordinates")
    place = f"{place}.coordinates"
    if not kind.startswith("Multi"):
        return _part(kind, values, place, to_degrees)
    if not isinstance(values, list):
        raise BadInput("expected a list", place=place)
    parts = [_part(kind.removeprefix("Multi"), value, f"{place}[{i}]", to_degrees) for i, value in enumerate(values)]
    return getattr(shapely, kind)(parts)


def _part(kind: str, values: Any, place: str, to_degrees: ToDegrees) -> Any:
    if kind == "Point":
        return shapely.Point(_corners([values], place, to_degrees)[0])
    if kind == "LineString":
        corners = _corners(values, place, to_degrees)
        if len(corners) < 2:
            raise InvalidRing(f"expected 2 positions or more, not {len(corners)}", place=place)
        return shapely.LineString(corners)
    if not isinstance(values, list) or not values:
        raise InvalidRing("expected a list of rings", place=place)
    rings = list[Corners]()
    for i, ring in enumerate(values):
        corners = _corners(ring, f"{place}[{i}]", to_degrees)
        if len(set(map(tuple, corners.tolist()))) < 3:
            raise InvalidRing("expected a ring of 3 different corners or more", place=f"{place}[{i}]")
        rings.append(corners)
    return shapely.Polygon(rings[0], rings[1:])


def _corners(positions: Any, place: str, to_degrees: ToDegrees) -> Corners:
    try:
        corners = np.array([position[:2] for position in positions], float)
    except (TypeError, ValueError, KeyError, OverflowError):
        corners = np.zeros((0, 0))
    if corners.ndim != 2 or corners.shape[1] != 2 or not np.isfinite(corners).all():
        raise BadInput("expected positions as [longitude, latitude]", place=place)
    return on_earth(to_degrees(corners), place)


def highest_of(geometry: Any) -> float:
    """Return the greatest third coordinate [m], -inf without one."""
    if isinstance(geometry, dict):
        return highest_of(geometry.get("geometries", geometry.get("coordinates")))
    if isinstance(geometry, list) and len(geometry) > 2 and not isinstance(geometry[0], list | dict):
        third = geometry[2]
        return third if isinstance(third, int | float) and is_altitude(third) else -math.inf
    is_nested = isinstance(geometry, list) and geometry and isinstance(geometry[0], list | dict)
    return max(map(highest_of, geometry)) if is_nested else -math.inf


def circle(center: Any, radius: Any, place: str) -> Any:
    """Return a polygon around a circle, at most 0.1 % wider."""
    try:
        corner = np.array([center[:2]], float)
        size = float(radius)
    except (TypeError, ValueError, OverflowError, KeyError):
        corner = np.zeros((0, 2))
        size = math.nan
    if corner.shape != (1, 2) or not np.isfinite(corner).all() or not 0 < size < 1e6:
        raise BadInput("expected a circle: center [longitude, latitude] and a radius in meters", place=place)
    longitude, latitude = on_earth(corner, place)[0]
    corners = 72
    around = np.linspace(0.0, 360.0, corners, endpoint=False)
    wide = np.full(corners, size / math.cos(math.pi / corners))
    east, north, _ = Geod(ellps="WGS84").fwd(np.full(corners, longitude), np.full(corners, latitude), around, wide)
    return shapely.Polygon(np.column_stack([east, north]))
