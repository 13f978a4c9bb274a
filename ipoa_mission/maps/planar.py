"""Convert shapes to valid polygons in east, north [m]."""

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
import shapely
from numpy.typing import NDArray

from ipoa_mission.errors import InvalidRing
from ipoa_mission.geodesy import LocalFrame
from ipoa_mission.maps.feature import EMPTY_SHAPE
from ipoa_mission.maps.map_window import MapWindow

LEAST_AREA = 1e-3  # [m^2]
LONGEST_EDGE = 0.02  # a straight edge in degrees bends by 0.1 m at 45 degrees [deg]


def to_plane(
    shapes: Sequence[Any], frame: LocalFrame, about: MapWindow | None = None
) -> tuple[NDArray[Any], NDArray[np.bool_]]:
    """Convert degrees to east, north [m], long edges divided; return which are near home: others become empty."""
    degrees = _unwrap(np.array(shapes, dtype=object))
    near = (about or MapWindow.of(frame)).are_near(shapely.bounds(degrees).reshape(-1, 4))
    degrees[~near] = EMPTY_SHAPE

    def convert(corners: NDArray[np.float64]) -> NDArray[np.float64]:
        return frame.to_local(corners[:, 1], corners[:, 0], np.full(len(corners), frame.home.altitude))[:, :2]

    long = np.ptp(shapely.bounds(degrees).reshape(-1, 2, 2), axis=1).max(axis=1) > LONGEST_EDGE
    for i in np.flatnonzero(long).tolist():
        degrees[i] = _divide_edges(degrees[i])
    return np.asarray(shapely.transform(degrees, convert)), near


def _divide_edges(shape: Any) -> Any:
    """Divide long edges ring by ring: of a whole crossed polygon GEOS would leave out a half."""
    if hasattr(shape, "geoms"):
        return type(shape)([_divide_edges(part) for part in shape.geoms])
    if shape.geom_type != "Polygon":
        return shapely.segmentize(shape, LONGEST_EDGE)
    outer, *inner = (shapely.segmentize(ring, LONGEST_EDGE) for ring in (shape.exterior, *shape.interiors))
    return shapely.Polygon(outer, inner)


def _unwrap(degrees: NDArray[Any]) -> NDArray[Any]:
    """Redraw across longitude 180, where RFC 7946 asks to cut."""
    west, _, east, _ = shapely.bounds(degrees).reshape(-1, 4).T
    for i in np.flatnonzero(east - west > 180.0).tolist():
        degrees[i] = _short_way(degrees[i])
    return degrees


def _short_way(shape: Any) -> Any:
    if hasattr(shape, "geoms"):
        return type(shape)([_short_way(part) for part in shape.geoms])
    if shape.geom_type == "Polygon":
        outer = _unwrap_corners(shape.exterior)
        holes = [_unwrap_corners(ring) for ring in shape.interiors]
        for hole in holes:
            hole[:, 0] += 360.0 * np.round((outer[:, 0].mean() - hole[:, 0].mean()) / 360.0)
        return shapely.Polygon(outer, holes)
    return shapely.LineString(_unwrap_corners(shape)) if shape.geom_type == "LineString" else shape


def _unwrap_corners(line: Any) -> NDArray[np.float64]:
    corners = shapely.get_coordinates(line)
    steps = np.diff(corners[:, 0])
    around = (np.abs(steps) > 180.0) & (np.abs(steps) < 360.0)  # an edge of 360 degrees bounds the whole Earth
    corners[1:, 0] -= 360.0 * np.cumsum(np.where(around, np.round(steps / 360.0), 0.0))
    return np.asarray(corners)


def remove_repeats(shape: Any) -> Any:
    """Remove repeated corners; keep a ring at one point, where GEOS fails."""
    try:
        return shapely.remove_repeated_points(shape)
    except shapely.errors.GEOSException:
        return shape


def polygons_of(shape: Any, place: str) -> tuple[list[Any], str | None]:
    """Return repaired polygons, and the defect."""
    clean = remove_repeats(shape)
    wrong = None if shapely.is_valid(clean) else shapely.is_valid_reason(clean)
    if wrong is not None:
        clean = shapely.make_valid(clean, method="structure", keep_collapsed=False)
        clean = shapely.remove_repeated_points(clean)
    parts = [part for part in shapely.get_parts(clean) if part.geom_type == "Polygon" and part.area > LEAST_AREA]
    if not parts:
        raise InvalidRing(f"expected a polygon with an area, not {_words(wrong)}", place=f"{place}.geometry")
    return parts, None if wrong is None else _words(wrong)


def _words(reason: str | None) -> str:
    return "a ring with " + reason.partition("[")[0].strip().lower() if reason else "a line or a point"


def simple_parts(shape: Any) -> list[Any]:
    return [part for piece in shape.geoms for part in simple_parts(piece)] if hasattr(shape, "geoms") else [shape]


def close_as_polygon(shape: Any) -> Any:
    closed = shape.geom_type == "LineString" and shape.is_closed and len(shape.coords) > 3
    return shapely.Polygon(shape) if closed else shape


def spans(shape: Any) -> Iterator[Any]:
    """Yield the straight segments of lines, except those of length 0."""
    outlines = (part.boundary if part.geom_type == "Polygon" else part for part in simple_parts(shape))
    for line in (line for outline in outlines for line in simple_parts(outline) if line.geom_type == "LineString"):
        corners = shapely.get_coordinates(line)
        legs = np.stack([corners[:-1], corners[1:]], axis=1)
        yield from shapely.linestrings(legs[(legs[:, 0] != legs[:, 1]).any(axis=1)]).tolist()
