"""UAS geographical zones: ED-269 (JSON) and ED-318 (GeoJSON)."""

import json
import math
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import shapely
from pyproj import Geod

from ipoa_mission.errors import BadInput, InvalidRing
from ipoa_mission.maps.feature import Corners, Feature, on_earth, positions_of, read_all

CORNERS = 72  # 0.1 % wider
RADIUS = "radius in other units than M"  # internal tag
WIDEST = 1_000_000.0  # [m]
_EARTH = Geod(ellps="WGS84")


def is_ed269(document: Any) -> bool:
    features = document.get("features") if isinstance(document, dict) and "type" not in document else None
    return isinstance(features, list) and all(
        isinstance(each, dict) and isinstance(each.get("geometry"), list) for each in features
    )


def ed269_features(document: Mapping[str, Any], path: Path) -> tuple[Feature, ...]:
    """Return each volume of each zone."""
    return read_all(
        _volume,
        (
            (zone, volume, f"{path}: features[{i}].geometry[{j}]")
            for i, zone in enumerate(document["features"])
            for j, volume in enumerate(zone["geometry"])
        ),
    )


def circle(center: Any, radius: Any, place: str) -> Any:
    try:
        corner = np.array([center[:2]], float)
        size = float(radius)
    except (TypeError, ValueError, OverflowError, KeyError):
        corner, size = np.zeros((0, 2)), math.nan
    if corner.shape != (1, 2) or not np.isfinite(corner).all() or not 0 < size < WIDEST:
        raise BadInput("expected a circle: center [longitude, latitude] and a radius in meters", place=place)
    longitude, latitude = on_earth(corner, place)[0]
    around = np.linspace(0.0, 360.0, CORNERS, endpoint=False)
    wide = np.full(CORNERS, size / math.cos(math.pi / CORNERS))
    east, north, _ = _EARTH.fwd(np.full(CORNERS, longitude), np.full(CORNERS, latitude), around, wide)
    return shapely.Polygon(np.column_stack([east, north]))


def layer_tags(layer: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
    for key in ("lower", "lowerReference", "upper", "upperReference", "uom"):
        if layer.get(key) is not None:
            yield key, str(layer[key])


def layers_apart(feature: Any) -> list[Any]:
    geometry = feature.get("geometry") if isinstance(feature, dict) else None
    members = geometry.get("geometries") if isinstance(geometry, dict) else None
    if not isinstance(geometry, dict) or not isinstance(members, list):
        return [feature]
    if not any(isinstance(member, dict) and "layer" in member for member in members):
        return [feature]
    shared = {"layer": geometry["layer"]} if "layer" in geometry else {}
    apart = [feature | {"geometry": shared | member if isinstance(member, dict) else member} for member in members]
    return [one for each in apart for one in layers_apart(each)]


def zone_tags(properties: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
    if isinstance(names := properties.get("name"), list):  # ED-318: by language
        texts = [name for name in names if isinstance(name, dict) and isinstance(name.get("text"), str)]
        english = [name for name in texts if str(name.get("lang", "")).startswith("en")]
        if chosen := english or texts:
            yield "name", chosen[0]["text"]
    if isinstance(properties.get("applicability"), list):
        yield from _times(properties["applicability"])
    if isinstance(volume := properties.get("geometry"), dict):  # Estonia: an ED-269 volume
        yield from _limit_tags(volume)


def _volume(zone: Mapping[str, Any], volume: Any, place: str) -> Feature:
    projection = volume.get("horizontalProjection") if isinstance(volume, dict) else None
    if not isinstance(projection, dict):
        raise BadInput("expected a Polygon or a Circle", place=f"{place}.horizontalProjection")
    shape = _projection(projection, f"{place}.horizontalProjection")
    tags = {key: zone[key] for key in ("identifier", "name", "type", "restriction") if isinstance(zone.get(key), str)}
    tags |= dict(_limit_tags(volume)) | dict(_times(zone.get("applicability")))
    if projection.get("type") == "Circle" and tags.get("uom", "M").upper() != "M":
        tags[RADIUS] = f"{projection['radius']} {tags['uom']}"
    return Feature(place, shape, tags)


def _limit_tags(volume: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
    given = {"uom": "uomDimensions", "lower": "lowerLimit", "upper": "upperLimit"}
    given |= {"lowerReference": "lowerVerticalReference", "upperReference": "upperVerticalReference"}
    yield from ((key, str(volume[name])) for key, name in given.items() if volume.get(name) is not None)


def _times(times: Any) -> Iterator[tuple[str, str]]:
    """Return ED-269 times as the ED-318 tag."""
    if isinstance(times, list) and not any(isinstance(each, dict) and each.get("permanent") == "YES" for each in times):
        yield "limitedApplicability", json.dumps(times)


def _projection(projection: Mapping[str, Any], place: str) -> Any:
    if projection.get("type") == "Circle":
        return circle(projection.get("center"), projection.get("radius"), place)
    rings = projection.get("coordinates")
    if projection.get("type") != "Polygon" or not isinstance(rings, list) or not rings:
        raise BadInput(f"expected a Polygon or a Circle, not {projection.get('type')!r}", place=place)
    corners = [_ring(ring, f"{place}.coordinates[{i}]") for i, ring in enumerate(rings)]
    return shapely.Polygon(corners[0], corners[1:])


def _ring(values: Any, place: str) -> Corners:
    corners = positions_of(values, place)
    if len(np.unique(corners, axis=0)) < 3:
        raise InvalidRing("expected a ring of 3 different corners or more", place=place)
    return on_earth(corners, place)
