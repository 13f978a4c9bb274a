"""CityJSON (1.0 to 2.0); height counts from the whole building's lowest point."""

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import shapely
from numpy.typing import NDArray
from pyproj import CRS, Transformer
from pyproj.exceptions import CRSError

from ipoa_mission.errors import BadInput, NoCoordinateSystem
from ipoa_mission.geometry import Points
from ipoa_mission.maps.feature import DEEPEST, Feature, Mistakes, on_earth, read_all
from ipoa_mission.world.union import union_of

VERSIONS = ("1.0", "1.1", "2.0")
MOST_SHOWN = 60  # characters
# Nesting depth of corners.
DEPTHS = {"GeometryInstance": 0, "MultiPoint": 0, "MultiLineString": 1, "MultiSurface": 2, "CompositeSurface": 2}
DEPTHS |= {"Solid": 3, "MultiSolid": 4, "CompositeSolid": 4}
TALL_KINDS = {
    "SolitaryVegetationObject": ("natural", "tree"),
    "PlantCover": ("natural", "wood"),
    "CityFurniture": ("man_made", "utility_pole"),
}
FLAT_KINDS = {
    **dict.fromkeys(("Road", "Square", "TransportSquare", "Track", "TransportationComplex"), ("highway", "road")),
    **dict.fromkeys(("WaterBody", "Waterway"), ("natural", "water")),
    **dict.fromkeys(("TINRelief", "LandUse", "CityObjectGroup"), ("landcover", "ground")),
    "Railway": ("railway", "rail"),
    **dict.fromkeys(("Tunnel", "TunnelPart"), ("location", "underground")),
}
LEAST_WALL_AREA = 1e-13  # a wall's footprint has none [deg^2]


@dataclass(frozen=True)
class _City:
    """Corners (n, 3), transformation, unit [m], least height of whole buildings."""

    corners: Points
    to_degrees: Transformer
    unit: float
    lowest: Mapping[str, float]


def is_cityjson(document: Any) -> bool:
    return isinstance(document, dict) and document.get("type") == "CityJSON"


def cityjson_features(document: Mapping[str, Any], path: Path) -> tuple[Feature, ...]:
    version = document.get("version")
    if not isinstance(version, str) or not version.startswith(VERSIONS):
        raise BadInput(f"expected {' or '.join(VERSIONS)}, not {str(version)[:20]!r}", place=f"{path}: version")
    objects = document.get("CityObjects")
    if not isinstance(objects, dict) or not all(isinstance(each, dict) for each in objects.values()):
        raise BadInput("expected an object of objects", place=f"{path}: CityObjects")
    corners, system = _corners(document, path), _system(document, path)
    places = {name: f"{path}: CityObjects.{name[:MOST_SHOWN]}" for name in objects}
    mistakes = Mistakes()
    used = {name: mistakes.attempt(_used, objects[name], len(corners), place) or [] for name, place in places.items()}
    mistakes.raise_all()
    vertical = [axis for axis in system.axis_info if axis.direction == "up"]
    city = _City(
        corners,
        Transformer.from_crs(system.to_2d(), "OGC:CRS84", always_xy=True),
        float(vertical[0].unit_conversion_factor) if vertical else 1.0,
        _lowest(objects, used, corners, path),
    )
    return read_all(_feature, ((name, objects[name], used[name], city, place) for name, place in places.items()))


def _corners(document: Mapping[str, Any], path: Path) -> Points:
    try:
        corners = np.array(document.get("vertices"), float)
        transform = document.get("transform") or {"scale": [1, 1, 1], "translate": [0, 0, 0]}
        scale, translate = (np.array(transform[key], float) for key in ("scale", "translate"))
        if corners.size == 0:
            corners = np.zeros((0, 3))
        with np.errstate(invalid="ignore", over="ignore"):  # infinite values are refused below
            corners = corners * scale + translate
    except (TypeError, ValueError, KeyError, OverflowError):
        corners = np.zeros((0, 0))
    if corners.ndim != 2 or corners.shape[1] != 3 or not np.isfinite(corners).all():
        words = "expected corners as [x, y, z], and a transform of scale and translate"
        raise BadInput(words, place=f"{path}: vertices")
    return corners


def _system(document: Mapping[str, Any], path: Path) -> CRS:
    metadata = document.get("metadata")
    name = metadata.get("referenceSystem") if isinstance(metadata, dict) else None
    code = name.rstrip("/").replace(":", "/").rpartition("/")[2] if isinstance(name, str) else ""
    try:
        return CRS.from_epsg(int(code[:MOST_SHOWN]))
    except (ValueError, CRSError) as error:
        raise NoCoordinateSystem(
            f"expected the name of a coordinate system with its EPSG code, such as "
            f"https://www.opengis.net/def/crs/EPSG/0/7415, not {str(name)[:MOST_SHOWN]!r}",
            place=f"{path}: metadata.referenceSystem",
        ) from error


def _used(thing: Mapping[str, Any], count: int, place: str) -> list[NDArray[np.intp]]:
    given = thing.get("geometry") or []
    if not isinstance(given, list):
        raise BadInput("expected a list", place=f"{place}.geometry")
    rings = list[NDArray[np.intp]]()
    for i, geometry in enumerate(given):
        depth = DEPTHS.get(str(geometry.get("type"))) if isinstance(geometry, dict) else None
        if depth is None:
            raise BadInput(f"expected one of {', '.join(DEPTHS)}", place=f"{place}.geometry[{i}]")
        rings += _rings(geometry.get("boundaries"), depth, count, f"{place}.geometry[{i}].boundaries")
    return rings


def _rings(boundaries: Any, depth: int, count: int, place: str) -> Iterator[NDArray[np.intp]]:
    lists = [boundaries]
    for level in range(depth):
        if not all(isinstance(each, list) for each in lists):
            raise BadInput("expected lists in lists", place=place)
        outer_only = level == depth - 1 and depth > 1  # a surface's edge
        lists = [inner for each in lists for inner in (each[:1] if outer_only else each)]
    for one in lists:
        try:
            ring = np.array(one)
        except ValueError:
            ring = np.zeros((0, 0))
        if ring.ndim != 1 or not len(ring) or ring.dtype.kind not in "iu" or ring.min() < 0 or ring.max() >= count:
            raise BadInput(f"expected lists of numbers below {count}, the number of vertices", place=place)
        yield ring


def _lowest(
    objects: Mapping[str, Any], used: Mapping[str, list[NDArray[np.intp]]], corners: Points, path: Path
) -> dict[str, float]:
    roots, lowest = dict[str, str](), dict[str, float]()
    for name in objects:
        way = [name]
        while way[-1] not in roots:
            parents = objects[way[-1]].get("parents")
            above = parents[0] if isinstance(parents, list) and parents else None
            if not isinstance(above, str) or above not in objects or above in way[-1:]:
                break
            if len(way) > DEEPEST:
                words = "expected parents that end at a building"
                raise BadInput(words, place=f"{path}: CityObjects.{name[:MOST_SHOWN]}")
            way.append(above)
        root = roots.get(way[-1], way[-1])
        roots |= dict.fromkeys(way, root)
        if used[name]:
            least = float(corners[np.concatenate(used[name]), 2].min())
            lowest[root] = min(lowest.get(root, least), least)
    return {name: lowest.get(root, 0.0) for name, root in roots.items()}


def _feature(
    name: str, thing: Mapping[str, Any], rings: list[NDArray[np.intp]], city: _City, place: str
) -> Feature | None:
    kind, attributes = str(thing.get("type")), thing.get("attributes")
    attributes = attributes if isinstance(attributes, dict) else {}
    named = attributes.get("name")
    tags = {"name": named} if isinstance(named, str) and named.strip() else {}
    key, value = (
        ("building", "yes") if kind.startswith("Building") else {**TALL_KINDS, **FLAT_KINDS}.get(kind, ("kind", kind))
    )
    tags |= {"id": name, key: value}
    if not rings:
        return None if thing.get("children") else Feature(place, shapely.GeometryCollection(), tags)
    corners = city.corners[np.concatenate(rings)]
    height = float(corners[:, 2].max() - city.lowest[name]) * city.unit
    measured = attributes.get("measuredHeight")
    if height <= 0 and isinstance(measured, int | float) and measured > 0:
        height = float(measured)
    if height > 0 and kind not in FLAT_KINDS:
        tags["height"] = f"{math.ceil(height * 100) / 100:.2f}"
    flat = on_earth(np.column_stack(city.to_degrees.transform(corners[:, 0], corners[:, 1])), place)
    return Feature(place, _shadow(np.split(flat, np.cumsum([len(ring) for ring in rings])[:-1])), tags)


def _shadow(rings: list[Points]) -> Any:
    shadows = [shapely.make_valid(shapely.Polygon(ring)) for ring in rings if len(ring) > 2]
    pieces = [part for shadow in shadows for part in shapely.get_parts(shadow)]
    polygons = [part for part in pieces if "Polygon" in part.geom_type and part.area > LEAST_WALL_AREA]
    if polygons:
        return union_of(polygons)
    return shapely.MultiPoint(np.unique(np.vstack(rings), axis=0))
