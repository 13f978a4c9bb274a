"""UAS geographical zones as European authorities publish them: ED-269 (JSON), and ED-318 (GeoJSON with layers).

Both become features whose tags are the zone's restriction, limits and times (`activity`). A circle becomes a polygon
round it.
"""

import json
import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import shapely
from pyproj import Geod

from ipoa_mission.errors import BadInput
from ipoa_mission.maps.feature import Corners, Feature, on_earth, positions_of, read_all

UNITS = {"M": 1.0, "FT": 0.3048}
REFERENCES = ("AGL", "AMSL")
CORNERS = 72  # of the polygon round a circle, which is 0.1 % wider
WIDEST = 1_000_000.0  # radius of a circle [m]
_EARTH = Geod(ellps="WGS84")


@dataclass(frozen=True)
class VerticalLimit:
    """A lower or upper limit [m], above ground (`AGL`) or above mean sea level (`AMSL`)."""

    height: float
    reference: str


def is_ed269(document: Any) -> bool:
    """Whether a JSON document holds zones by ED-269: features of its own kind, each with a list of geometries."""
    features = document.get("features") if isinstance(document, dict) and "type" not in document else None
    return isinstance(features, list) and all(
        isinstance(each, dict) and isinstance(each.get("geometry"), list) for each in features
    )


def ed269_features(document: Mapping[str, Any], path: Path) -> tuple[Feature, ...]:
    """Each volume of each zone as a feature.

    Raises:
        BadInput: naming file and place, and what was expected there.
    """
    return read_all(
        _volume,
        (
            (zone, volume, f"{path}: features[{i}].geometry[{j}]")
            for i, zone in enumerate(document["features"])
            for j, volume in enumerate(zone["geometry"])
        ),
    )


def circle(center: Any, radius: Any, place: str) -> Any:
    """A polygon round a circle of `radius` [m] about longitude and latitude [deg].

    Raises:
        BadInput: it is none.
    """
    try:
        corner = np.array([center[:2]], float)
        size = float(radius)
    except (TypeError, ValueError, OverflowError, KeyError):
        corner, size = np.zeros((0, 2)), math.nan
    if corner.shape != (1, 2) or not np.isfinite(corner).all() or not 0 < size < WIDEST:
        raise BadInput(f"{place}: expected a circle: center [longitude, latitude] and a radius in metres")
    longitude, latitude = on_earth(corner, place)[0]
    around = np.linspace(0.0, 360.0, CORNERS, endpoint=False)
    wide = np.full(CORNERS, size / math.cos(math.pi / CORNERS))
    east, north, _ = _EARTH.fwd(np.full(CORNERS, longitude), np.full(CORNERS, latitude), around, wide)
    return shapely.Polygon(np.column_stack([east, north]))


def layer_tags(layer: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
    """The limits of a layer of ED-318 as tags."""
    for key in ("lower", "lowerReference", "upper", "upperReference", "uom"):
        if layer.get(key) is not None:
            yield key, str(layer[key])


def limits_of(tags: Mapping[str, str], place: str) -> tuple[VerticalLimit | None, VerticalLimit | None]:
    """Lower and upper limit; None where there is none, or where it is the ground itself.

    Raises:
        BadInput: they are none.
    """
    if not {"lowerReference", "upperReference"} & tags.keys():
        return None, None
    lower, upper = (_limit(tags, side, place) for side in ("lower", "upper"))
    return (None if lower is not None and lower.reference == "AGL" and lower.height <= 0 else lower), upper


def _limit(tags: Mapping[str, str], side: str, place: str) -> VerticalLimit | None:
    if side not in tags:
        return None
    unit, reference = tags.get("uom", "M").upper(), tags.get(f"{side}Reference", "AGL").upper()
    try:
        height = float(tags[side])
    except ValueError:
        height = math.nan
    if unit not in UNITS or not math.isfinite(height):
        raise BadInput(f"{place}.{side}: expected a number in M or FT, not {tags[side]!r} in {unit!r}")
    if reference not in REFERENCES:
        raise BadInput(f"{place}.{side}Reference: expected AGL or AMSL, not {reference!r}")
    return VerticalLimit(height * UNITS[unit], reference)


def _volume(zone: Mapping[str, Any], volume: Any, place: str) -> Feature:
    projection = volume.get("horizontalProjection") if isinstance(volume, dict) else None
    if not isinstance(projection, dict):
        raise BadInput(f"{place}.horizontalProjection: expected a Polygon or a Circle")
    shape = _projection(projection, f"{place}.horizontalProjection")
    tags = {key: zone[key] for key in ("identifier", "name", "type", "restriction") if isinstance(zone.get(key), str)}
    given = {"uom": "uomDimensions", "lower": "lowerLimit", "upper": "upperLimit"}
    given |= {"lowerReference": "lowerVerticalReference", "upperReference": "upperVerticalReference"}
    tags |= {key: str(volume[name]) for key, name in given.items() if volume.get(name) is not None}
    times = zone.get("applicability")
    always = not isinstance(times, list) or any(isinstance(t, dict) and t.get("permanent") == "YES" for t in times)
    return Feature(place, shape, tags | ({} if always else {"limitedApplicability": json.dumps(times)}))


def _projection(projection: Mapping[str, Any], place: str) -> Any:
    if projection.get("type") == "Circle":
        return circle(projection.get("center"), projection.get("radius"), place)
    rings = projection.get("coordinates")
    if projection.get("type") != "Polygon" or not isinstance(rings, list) or not rings:
        raise BadInput(f"{place}: expected a Polygon or a Circle, not {projection.get('type')!r}")
    corners = [_ring(ring, f"{place}.coordinates[{i}]") for i, ring in enumerate(rings)]
    return shapely.Polygon(corners[0], corners[1:])


def _ring(values: Any, place: str) -> Corners:
    corners = positions_of(values, place)
    if len(np.unique(corners, axis=0)) < 3:
        raise BadInput(f"{place}: expected a ring of 3 different corners or more")
    return on_earth(corners, place)
