"""Shapes of a map in the local plane: valid polygons in east, north [m], repaired where the file's rings are not.

A ring that crosses or touches itself is mended as shapely's `make_valid` does by "structure"; what has no area left is
refused by name.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np
import shapely
from numpy.typing import NDArray

from ipoa_mission.errors import InvalidRing, TooFar
from ipoa_mission.maps.around import near_home
from ipoa_mission.world.frame import REACH, LocalFrame

LEAST_AREA = 1e-3  # [m^2]
LONGEST_EDGE = 0.02  # a straight edge in degrees is bent in the plane: by 0.1 m over so much at 45 degrees [deg]


class Whereabouts:
    """Where the shapes of a map lie, to be told if none of them comes within 100 km of home."""

    def __init__(self, frame: LocalFrame) -> None:
        self.frame = frame
        self._any_near = self._turned_near = False
        self._first_far = ""
        self._box = np.array([np.inf, np.inf, -np.inf, -np.inf])  # west, south, east, north [deg]

    def near(self, degrees: NDArray[Any], places: Sequence[str]) -> NDArray[np.bool_]:
        """Which of some shapes come near to home, or are empty."""
        boxes, empty = shapely.bounds(degrees).reshape(-1, 4), shapely.is_empty(degrees)
        near = _near(boxes, self.frame) | empty
        self._any_near = self._any_near or bool((near & ~empty).any())
        if not self._any_near and not empty.all():
            self._first_far = self._first_far or str(places[int(np.argmin(near))])
            here = shapely.total_bounds(degrees)
            self._box = np.concatenate([np.minimum(self._box[:2], here[:2]), np.maximum(self._box[2:], here[2:])])
            self._turned_near |= bool(_near(boxes[:, [1, 0, 3, 2]], self.frame).any())
        return np.asarray(near)

    def expect_near(self) -> None:
        """See that one of all those asked about comes near.

        Raises:
            BadInput: none does. It says where they are, and whether their coordinates seem to stand in wrong order.
        """
        if self._any_near or not self._first_far:
            return
        home, (west, south, east, north) = self.frame.home, self._box.tolist()
        raise TooFar(
            f"expected a place within {REACH / 1000:g} km of home "
            f"({home.latitude_deg:.4f}, {home.longitude_deg:.4f}), "
            f"not round {(south + north) / 2:.4f}, {(west + east) / 2:.4f}",
            hint="in its coordinates longitude must stand before latitude"
            if self._turned_near
            else "is it the map of another place?",
            place=f"{self._first_far}.geometry",
        )


def to_plane(
    shapes: Sequence[Any], places: Sequence[str], about: Whereabouts
) -> tuple[NDArray[Any], NDArray[np.bool_]]:
    """Shapes in longitude, latitude [deg] as shapes in east, north [m], as many, and which come within 100 km of home.

    Those that do not are empty. Edges are straight in longitude and latitude, as the formats say: long ones are cut.
    """
    frame = about.frame
    height = frame.home.altitude
    degrees = _unwrapped(np.array(shapes, dtype=object))
    near = about.near(degrees, places)
    degrees[~near] = shapely.GeometryCollection()

    def convert(corners: NDArray[np.float64]) -> NDArray[np.float64]:
        return frame.to_local(corners[:, 1], corners[:, 0], np.full(len(corners), height))[:, :2]

    sides = np.ptp(shapely.bounds(degrees).reshape(-1, 2, 2), axis=1).max(axis=1)
    long = sides > LONGEST_EDGE
    degrees[long] = shapely.segmentize(degrees[long], LONGEST_EDGE)
    return np.asarray(shapely.transform(degrees, convert)), near


def _unwrapped(degrees: NDArray[Any]) -> NDArray[Any]:
    """The same shapes, those with an edge of more than 180 degrees drawn the short way: beyond longitude 180.

    RFC 7946 wants a shape cut in two there, but not all programs do so; nothing near home is half as wide as the Earth.
    """
    wide = np.flatnonzero(np.ptp(shapely.bounds(degrees).reshape(-1, 2, 2)[:, :, 0], axis=1) > 180.0)
    for i in wide.tolist():
        degrees[i] = _short_way(degrees[i])
    return degrees


def _short_way(shape: Any) -> Any:
    """A shape whose rings and lines each go on from where they are by less than half a turn."""
    if hasattr(shape, "geoms"):
        return type(shape)([_short_way(part) for part in shape.geoms])
    if shape.geom_type == "Polygon":
        outer = _turned(shape.exterior)
        return shapely.Polygon(outer, [_beside(_turned(ring), outer) for ring in shape.interiors])
    return shapely.LineString(_turned(shape)) if shape.geom_type == "LineString" else shape


def _turned(line: Any) -> NDArray[np.float64]:
    corners = shapely.get_coordinates(line)
    steps = np.diff(corners[:, 0])
    around = (np.abs(steps) > 180.0) & (np.abs(steps) < 360.0)  # an edge of 360 degrees bounds the whole Earth
    corners[1:, 0] -= 360.0 * np.cumsum(np.where(around, np.round(steps / 360.0), 0.0))
    return np.asarray(corners)


def _beside(hole: NDArray[np.float64], outer: NDArray[np.float64]) -> NDArray[np.float64]:
    """A hole on the same turn round the Earth as the outline that it is in."""
    hole[:, 0] += 360.0 * np.round((outer[:, 0].mean() - hole[:, 0].mean()) / 360.0)
    return hole


def _near(boxes: NDArray[np.float64], frame: LocalFrame) -> NDArray[np.bool_]:
    """Which boxes (n, 4) of longitudes and latitudes meet the square of 100 km round home."""
    return near_home(frame.home).meets(boxes)


def clean_polygons(shapes: NDArray[Any]) -> tuple[NDArray[Any], NDArray[np.bool_]]:
    """Local shapes (n,), and which of them are one polygon of which `polygons_of` makes just that; these are clean."""
    clean = unrepeated(shapes)
    sound = (shapely.get_type_id(shapes) == shapely.GeometryType.POLYGON) & shapely.is_valid(clean)
    sound &= shapely.area(clean) > LEAST_AREA
    return np.where(sound, clean, shapes), sound


def unrepeated(shapes: NDArray[Any]) -> NDArray[Any]:
    """Shapes without corners that repeat the one before; GEOS makes none with a ring all in one place: as it is."""
    try:
        return np.asarray(shapely.remove_repeated_points(shapes))
    except shapely.errors.GEOSException:
        if len(shapes) == 1:
            return shapes
        half = len(shapes) // 2
        return np.concatenate([unrepeated(shapes[:half]), unrepeated(shapes[half:])])


def polygons_of(shape: Any, place: str) -> tuple[list[Any], str | None]:
    """The valid polygons that a local polygon is or can be mended to, and what was wrong with it, if anything was.

    Raises:
        BadInput: nothing with an area is left.
    """
    (clean,) = unrepeated(np.array([shape], object))
    wrong = None if shapely.is_valid(clean) else shapely.is_valid_reason(clean)
    if wrong is not None:
        clean = shapely.make_valid(clean, method="structure", keep_collapsed=False)
        clean = shapely.remove_repeated_points(clean)
    parts = [part for part in shapely.get_parts(clean) if part.geom_type == "Polygon" and part.area > LEAST_AREA]
    if not parts:
        raise InvalidRing(f"expected a polygon with an area, not {_words(wrong)}", place=f"{place}.geometry")
    return parts, None if wrong is None else _words(wrong)


def _words(reason: str | None) -> str:
    """`a ring with self-intersection` of GEOS's `Self-intersection[12.3 45.6]`."""
    return "a ring with " + reason.partition("[")[0].strip().lower() if reason else "a line or a point"
