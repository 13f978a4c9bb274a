"""Read OpenStreetMap's XML and Overpass's JSON.

A feature with corners outside the extract gets an empty shape, and a note of the others.
"""

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple
from xml.etree import ElementTree

import numpy as np
import shapely

from ipoa_mission.errors import BadInput, NothingThere, Unreadable, WrongFormat
from ipoa_mission.geometry import union_of
from ipoa_mission.maps.feature import Feature, Missing, on_earth

# Lines even if closed, unless tagged as areas.
LINES = {"highway", "barrier", "railway", "waterway", "aerialway", "route", "man_made=pipeline", "power=line"}
META_TAGS = {"created_by", "source"}
BOUNDS = ("minlon", "minlat", "maxlon", "maxlat")
EMPTY_SHAPE = shapely.GeometryCollection()


class OsmWay(NamedTuple):
    nodes: tuple[str, ...]
    tags: dict[str, str]


class Relation(NamedTuple):
    members: tuple[tuple[str, str, str], ...]
    tags: dict[str, str]


@dataclass
class Extract:
    """A file by numbers; `remarks` are a server's errors."""

    places: dict[str, tuple[float, float]] = field(default_factory=dict)
    tagged: dict[str, dict[str, str]] = field(default_factory=dict)
    ways: dict[str, OsmWay] = field(default_factory=dict)
    relations: dict[str, Relation] = field(default_factory=dict)
    boxes: dict[str, Any] = field(default_factory=dict)
    remarks: list[str] = field(default_factory=list)

    def corners(self, positions: Iterable[tuple[str, float | None, float | None]]) -> tuple[str, ...]:
        """Register positions; return node numbers."""
        numbers = []
        for number, longitude, latitude in positions:
            name = number or f"{longitude},{latitude}"
            if longitude is not None and latitude is not None:
                self.places.setdefault(name, (longitude, latitude))
            numbers.append(name)
        return tuple(numbers)


def read_osm(path: Path) -> tuple[Feature, ...]:
    try:
        extract = _extract(path)
    except OSError as error:
        raise Unreadable(f"cannot be read: {error.strerror or error}", place=path) from error
    except ElementTree.ParseError as error:
        raise WrongFormat(f"expected OpenStreetMap's XML: {error}", place=path) from error
    except (LookupError, ValueError) as error:  # unknown or multi-byte encoding
        raise WrongFormat(f"expected XML in an encoding such as UTF-8: {error}", place=path) from error
    return features_of(extract, path)


def features_of(extract: Extract, path: Path) -> tuple[Feature, ...]:
    tagged = [number for number, way in extract.ways.items() if way.tags.keys() - META_TAGS]
    if tagged and not any(node in extract.places for number in tagged for node in extract.ways[number].nodes):
        raise BadInput(
            f"way {tagged[0]}: expected the places of its nodes",
            hint="end a query of Overpass with `out geom;`, or with `out body; >; out skel qt;`",
            place=path,
        )
    features = tuple(_features(extract, path))
    if not features:
        raise NothingThere("expected things with tags, but there are none", place=path)
    return features


def _extract(path: Path) -> Extract:
    extract, root = Extract(), None
    for event, element in ElementTree.iterparse(path, ("start", "end")):
        if root is None:
            root = element
            if root.tag != "osm":
                raise WrongFormat(f"expected OpenStreetMap's XML, <osm>, not <{root.tag[:40]}>", place=path)
        if event == "end" and element.tag in ("node", "way", "relation", "remark"):
            _take_xml(element, extract, path)
            root.clear()
    return extract


def _take_xml(element: ElementTree.Element, extract: Extract, path: Path) -> None:
    number = element.get("id", "")
    if element.tag == "remark":
        extract.remarks.append((element.text or "").strip())
        return
    if element.get("action") == "delete" or element.get("visible") == "false":
        return
    tags = plain_tags((tag.get("k", ""), tag.get("v", "")) for tag in element.iterfind("tag"))
    if element.tag == "node":
        extract.places[number] = _degrees(element, "lon", path), _degrees(element, "lat", path)
        if tags.keys() - META_TAGS:
            extract.tagged[number] = tags
        return
    if (bounds := element.find("bounds")) is not None:
        with suppress(ValueError):
            extract.boxes[f"{element.tag} {number}"] = shapely.box(*(float(bounds.get(side, "")) for side in BOUNDS))
    if element.tag == "way":
        extract.ways[number] = OsmWay(_nodes(element, extract, path), tags)
    elif is_area(tags):
        members = list(element.iterfind("member"))
        for member in members:
            if member.get("type") == "way" and member.find("nd") is not None:
                extract.ways.setdefault(member.get("ref", ""), OsmWay(_nodes(member, extract, path), {}))
        listed = tuple((each.get("type", ""), each.get("ref", ""), each.get("role", "")) for each in members)
        extract.relations[number] = Relation(listed, tags)


def _nodes(element: ElementTree.Element, extract: Extract, path: Path) -> tuple[str, ...]:
    def place_of(node: ElementTree.Element) -> tuple[float, float] | tuple[None, None]:
        return (None, None) if node.get("lat") is None else (_degrees(node, "lon", path), _degrees(node, "lat", path))

    return extract.corners((node.get("ref", ""), *place_of(node)) for node in element.iterfind("nd"))


def is_overpass(document: Any) -> bool:
    return isinstance(document, dict) and isinstance(document.get("elements"), list)


def overpass_features(document: Mapping[str, Any], path: Path) -> tuple[Feature, ...]:
    extract = Extract(remarks=[str(document["remark"])] if document.get("remark") else [])
    for n, element in enumerate(document["elements"]):
        place = f"{path}: elements[{n}]"
        if not isinstance(element, dict) or not isinstance(element.get("type"), str) or "id" not in element:
            raise BadInput("expected an element with a type and an id", place=place)
        if element["type"] in ("node", "way", "relation"):
            try:
                _take_json(element, extract)
            except (TypeError, ValueError, KeyError, AttributeError) as error:
                raise BadInput("expected a node, way or relation as Overpass writes it", place=place) from error
    return features_of(extract, path)


def _take_json(element: Mapping[str, Any], extract: Extract) -> None:
    number, sort = str(element["id"]), element["type"]
    tags = plain_tags((str(key), str(value)) for key, value in (element.get("tags") or {}).items())
    if sort == "node":
        if "lat" in element:
            extract.places[number] = float(element["lon"]), float(element["lat"])
            if tags.keys() - META_TAGS:
                extract.tagged[number] = tags
        return
    if bounds := element.get("bounds"):
        extract.boxes[f"{sort} {number}"] = shapely.box(*(float(bounds[side]) for side in BOUNDS))
    if sort == "way":
        extract.ways[number] = OsmWay(extract.corners(_json_nodes(element)), tags)
    elif is_area(tags):
        members = element.get("members") or []
        for member in members:
            if member["type"] == "way" and member.get("geometry"):
                extract.ways.setdefault(str(member["ref"]), OsmWay(extract.corners(_json_nodes(member)), {}))
        listed = tuple((member["type"], str(member["ref"]), member.get("role") or "") for member in members)
        extract.relations[number] = Relation(listed, tags)


def _json_nodes(way: Mapping[str, Any]) -> Iterator[tuple[str, float | None, float | None]]:
    numbers, places = way.get("nodes"), way.get("geometry")
    numbers = [""] * len(places or ()) if numbers is None else numbers
    for number, place in zip(numbers, [None] * len(numbers) if places is None else places, strict=True):
        if place is None:
            yield str(number) or "?", None, None
        else:
            yield str(number), float(place["lon"]), float(place["lat"])


def is_area(tags: Mapping[str, str]) -> bool:
    kind = tags.get("type")
    return kind in {"multipolygon", "building", "boundary"} or (
        kind != "route" and not tags.keys().isdisjoint(("building", "building:part"))
    )


def plain_tags(pairs: Iterable[tuple[str, str]]) -> dict[str, str]:
    return {key: value.strip() for key, value in pairs if value.strip()}


def _degrees(element: ElementTree.Element, key: str, path: Path) -> float:
    try:
        value = float(element.get(key, ""))
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        number = element.get("id", element.get("ref"))
        raise BadInput(f"node {number}: expected its {key} in degrees", code="not-degrees", place=path)
    return value


def _features(extract: Extract, path: Path) -> Iterator[Feature]:
    def corners_of(number: str) -> Sequence[Sequence[float]] | None:
        nodes = extract.ways[number].nodes if number in extract.ways else ()
        corners = [extract.places[node] for node in nodes if node in extract.places]
        return corners if len(corners) == len(nodes) > 1 else None

    for remark in extract.remarks:
        words = f"what the server left out ({remark[:80]})"
        missing = Missing(words, EMPTY_SHAPE, "repeat the query for a smaller area")
        yield Feature(f"{path}: remark", EMPTY_SHAPE, {}, missing=missing)
    for number, tags in extract.tagged.items():
        yield feature_of(f"node {number}", tags, shapely.Point(extract.places[number]), path)
    for number, way in extract.ways.items():
        if way.tags.keys() - META_TAGS:
            closes = len(way.nodes) > 1 and way.nodes[0] == way.nodes[-1]
            shape, name = shape_of(corners_of(number), closes, way.tags), f"way {number}"
            yield feature_of(name, way.tags, shape, path, _known((way,), extract, name))
    for number, relation in extract.relations.items():
        if relation.tags.keys() - META_TAGS - {"type"}:
            ways = [extract.ways[way] for way, _ in ways_of(relation) if way in extract.ways]
            shape, name = area_of(relation, corners_of), f"relation {number}"
            yield feature_of(name, relation.tags, shape, path, _known(ways, extract, name))


def _known(ways: Iterable[OsmWay], extract: Extract, name: str) -> list[Any]:
    corners: list[Any] = [extract.places[node] for way in ways for node in way.nodes if node in extract.places]
    return corners or (shapely.get_coordinates(extract.boxes[name]).tolist() if name in extract.boxes else [])


def feature_of(
    name: str, tags: dict[str, str], shape: Any, path: Path, known: Sequence[Sequence[float]] = ()
) -> Feature:
    """Return the feature of a name like `way 12`; note the `known` corners of an empty shape."""
    place = f"{path}: {name}"
    on_earth(shapely.get_coordinates(shape), place)
    missing = None
    if shapely.is_empty(shape):
        hull = shapely.MultiPoint(known).convex_hull if known else EMPTY_SHAPE
        remedy = "export a larger part of the map, with everything that crosses its edge"
        missing = Missing("with a part that is not in the file", hull, remedy, elsewhere=not known)
    return Feature(place, shape, {**tags, "@id": name.replace(" ", "/", 1)}, missing=missing)


def shape_of(corners: Sequence[Sequence[float]] | None, closes: bool, tags: Mapping[str, str]) -> Any:
    if corners is None:
        return EMPTY_SHAPE
    named = {*tags, *(f"{key}={value}" for key, value in tags.items())}
    is_area = tags.get("area") != "no" and (tags.get("area") == "yes" or not named & LINES)
    is_ring = closes and len(corners) >= 4
    return shapely.Polygon(corners) if is_ring and is_area else shapely.LineString(corners)


def ways_of(relation: Relation) -> Iterator[tuple[str, bool]]:
    """Yield an area's ways, and whether each is outer."""
    for sort, number, role in relation.members:
        if sort == "way" and role in ("", "outer", "outline", "inner"):
            yield number, role != "inner"


def area_of(relation: Relation, corners_of: Callable[[str], Sequence[Sequence[float]] | None]) -> Any:
    """Return the area of a relation; empty if its ways do not close."""
    rings: dict[bool, list[Any]] = {True: [], False: []}
    for number, is_outer in ways_of(relation):
        corners = corners_of(number)
        if corners is None:
            return EMPTY_SHAPE
        rings[is_outer].append(shapely.LineString(corners))
    areas = {}
    for is_outer, lines in rings.items():
        polygons, cuts, dangles, invalid = shapely.polygonize_full(np.array(lines, object))
        if any(not shapely.is_empty(rest) for rest in (cuts, dangles, invalid)):
            return EMPTY_SHAPE
        areas[is_outer] = union_of(shapely.get_parts(polygons))
    return shapely.difference(areas[True], areas[False])
