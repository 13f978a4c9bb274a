"""A thing with corners outside the extract gets an empty shape, and a note of its other corners."""

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
from ipoa_mission.maps.feature import Feature, Missing, on_earth
from ipoa_mission.world.polygon import union_of

# Lines even if closed, unless tagged as areas.
LINES = {"highway", "barrier", "railway", "waterway", "aerialway", "route", "man_made=pipeline", "power=line"}
AREAS = {"multipolygon", "building", "boundary"}
META_TAGS = {"created_by", "source"}
MOST_SHOWN = 80  # characters
BOUNDS = ("minlon", "minlat", "maxlon", "maxlat")
LARGER_EXTRACT = "export a larger part of the map, with everything that crosses its edge"
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

    def corners(self, each: Iterable[tuple[str, float | None, float | None]]) -> tuple[str, ...]:
        """Register positions; return node numbers."""
        numbers = []
        for number, longitude, latitude in each:
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
            _take(element, extract, path)
            root.clear()
    return extract


def _take(element: ElementTree.Element, extract: Extract, path: Path) -> None:
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
        listed = tuple((one.get("type", ""), one.get("ref", ""), one.get("role", "")) for one in members)
        extract.relations[number] = Relation(listed, tags)


def _nodes(element: ElementTree.Element, extract: Extract, path: Path) -> tuple[str, ...]:
    here = [(one, one.get("lat") is not None) for one in element.iterfind("nd")]
    return extract.corners(
        (one.get("ref", ""), *((_degrees(one, "lon", path), _degrees(one, "lat", path)) if known else (None, None)))
        for one, known in here
    )


def is_area(tags: Mapping[str, str]) -> bool:
    kind = tags.get("type")
    return kind in AREAS or (kind != "route" and not tags.keys().isdisjoint(("building", "building:part")))


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
        return _corners(extract.ways[number], extract) if number in extract.ways else None

    for remark in extract.remarks:
        words = f"what the server left out ({remark[:MOST_SHOWN]})"
        missing = Missing(words, EMPTY_SHAPE, "repeat the query for a smaller area")
        yield Feature(f"{path}: remark", EMPTY_SHAPE, {}, missing=missing)
    for number, tags in extract.tagged.items():
        yield thing("node", number, tags, shapely.Point(extract.places[number]), path)
    for number, way in extract.ways.items():
        if way.tags.keys() - META_TAGS:
            closes = len(way.nodes) > 1 and way.nodes[0] == way.nodes[-1]
            known = _known((way,), extract, f"way {number}")
            yield thing("way", number, way.tags, shape_of(corners_of(number), closes, way.tags), path, known)
    for number, relation in extract.relations.items():
        if relation.tags.keys() - META_TAGS - {"type"}:
            ways = [extract.ways[way] for way, _ in ways_of(relation) if way in extract.ways]
            known = _known(ways, extract, f"relation {number}")
            yield thing("relation", number, relation.tags, area_of(relation, corners_of), path, known)


def _known(ways: Iterable[OsmWay], extract: Extract, name: str) -> list[Any]:
    corners: list[Any] = [extract.places[node] for way in ways for node in way.nodes if node in extract.places]
    return corners or (shapely.get_coordinates(extract.boxes[name]).tolist() if name in extract.boxes else [])


def thing(
    sort: str, number: str, tags: dict[str, str], shape: Any, path: Path, known: Sequence[Sequence[float]] = ()
) -> Feature:
    """Return a feature; note the `known` corners of an empty shape."""
    place = f"{path}: {sort} {number}"
    on_earth(shapely.get_coordinates(shape), place)
    missing = None
    if shapely.is_empty(shape):
        hull = shapely.MultiPoint(known).convex_hull if known else EMPTY_SHAPE
        missing = Missing("of which a part is not in the file", hull, LARGER_EXTRACT, elsewhere=not known)
    return Feature(place, shape, {**tags, "@id": f"{sort}/{number}"}, missing=missing)


def _corners(way: OsmWay, extract: Extract) -> Sequence[tuple[float, float]] | None:
    corners = [extract.places[node] for node in way.nodes if node in extract.places]
    return corners if len(corners) == len(way.nodes) > 1 else None


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
        found, cuts, dangles, invalid = shapely.polygonize_full(np.array(lines, object))
        if any(not shapely.is_empty(rest) for rest in (cuts, dangles, invalid)):
            return EMPTY_SHAPE
        areas[is_outer] = union_of(shapely.get_parts(found))
    return shapely.difference(areas[True], areas[False])
