"""Shapes of a map in the local plane: valid polygons in east, north [m], repaired where the file's rings are not.

A ring that crosses or touches itself is mended as shapely's `make_valid` does by "structure"; what has no area left is
refused by name.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np
import shapely
from numpy.typing import NDArray

from ipoa_mission.errors import BadInput
from ipoa_mission.world.frame import REACH, LocalFrame

LEAST_AREA = 1e-3  # [m^2]


def to_plane(shapes: Sequence[Any], places: Sequence[str], frame: LocalFrame) -> NDArray[Any]:
    """Shapes in longitude, latitude [deg] as shapes in east, north [m], as many.

    Raises:
        BadInput: one of them is more than 100 km from home.
    """
    height = frame.home.altitude

    def convert(corners: NDArray[np.float64]) -> NDArray[np.float64]:
        return frame.to_local(corners[:, 1], corners[:, 0], np.full(len(corners), height))[:, :2]

    local = shapely.transform(np.array(shapes, dtype=object), convert)
    far = ~(np.abs(shapely.bounds(local)) < REACH).all(axis=1) & ~shapely.is_empty(local)
    if far.any():
        raise BadInput(
            f"{places[int(np.argmax(far))]}.geometry: expected a place within {REACH / 1000:g} km of home",
            hint="GeoJSON has longitude first, then latitude",
        )
    return np.asarray(local)


def polygons_of(shape: Any, place: str) -> tuple[list[Any], str | None]:
    """The valid polygons that a local polygon is or can be mended to, and what was wrong with it, if anything was.

    Raises:
        BadInput: nothing with an area is left.
    """
    clean = shapely.remove_repeated_points(shape)
    wrong = None if shapely.is_valid(clean) else shapely.is_valid_reason(clean)
    if wrong is not None:
        clean = shapely.make_valid(clean, method="structure", keep_collapsed=False)
        clean = shapely.remove_repeated_points(clean)
    parts = [part for part in shapely.get_parts(clean) if part.geom_type == "Polygon" and part.area > LEAST_AREA]
    if not parts:
        raise BadInput(f"{place}.geometry: expected a polygon with an area, not {_words(wrong)}")
    return parts, None if wrong is None else _words(wrong)


def rings_of(
    polygon: Any,
) -> tuple[tuple[tuple[float, float], ...], tuple[tuple[tuple[float, float], ...], ...]]:
    """The outer ring and the holes of a valid polygon as corners, not closed."""
    outer, *holes = (
        tuple((float(east), float(north)) for east, north in shapely.get_coordinates(ring)[:-1])
        for ring in (polygon.exterior, *polygon.interiors)
    )
    return outer, tuple(holes)


def _words(reason: str | None) -> str:
    """`a ring with self-intersection` of GEOS's `Self-intersection[12.3 45.6]`."""
    return "a ring with " + reason.partition("[")[0].strip().lower() if reason else "a line or a point"
