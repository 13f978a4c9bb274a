"""Read OpenStreetMap's XML and Overpass's JSON. A feature with corners outside the extract has an empty shape."""

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple
from xml.etree import ElementTree

import numpy as np
import shapely

from ipoa_mission.errors import BadInput, NothingThere, WrongFormat
from ipoa_mission.files import reading_xml
from ipoa_mission.geometry import union_of
from ipoa_mission.maps.feature import EMPTY_SHAPE, Feature, Missing, on_earth

# Lines even if closed, unless tagged as areas.
LINES = {"highway", "barrier", "railway", "waterway", "aerialway", "route", "man_made=pipeline", "power=line"}
META_TAGS = {"created_by", "source"}
BOUNDS = ("minlon", "minlat", "maxlon", "maxlat")


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

    def add(self, element: Mapping[str, Any], place: str) -> None:
        """Add an element of Overpass's JSON, read at `place`."""
        try:
            self._add(element)
        except (TypeError, ValueError, KeyError, AttributeError) as error:
            words = "expected a node, way or relation with its places in degrees"
            raise BadInput(words, code="not-degrees", place=place) from error

    def _add(self, element: Mapping[str, Any]) -> None:
        number = str(element["id"])
        sort = element["type"]
        tags = plain_tags((str(key), str(value)) for key, value in (element.get("tags") or {}).items())
        if bounds := element.get("bounds"):
            self.boxes[f"{sort} {number}"] = shapely.box(*(float(bounds[side]) for side in BOUNDS))
        if sort == "node" and ("lat" in element or tags.keys() - META_TAGS):
            self.places[number] = _degrees(element)
            if tags.keys() - META_TAGS:
                self.tagged[number] = tags
        elif sort == "way":
            self.ways[number] = OsmWay(self._nodes(element), tags)
        elif sort == "relation" and is_area(tags):
            members = element.get("members") or []
            for member in members:
                if member["type"] == "way" and member.get("geometry"):
                    self.ways.setdefault(str(member["ref"]), OsmWay(self._nodes(member), {}))
            listed = tuple((member["type"], str(member["ref"]), member.get("role") or "") for member in members)
            self.relations[number] = Relation(listed, tags)

    def _nodes(self, way: Mapping[str, Any]) -> tuple[str, ...]:
        """Return the numbers of nodes; of unnumbered ones the places."""
        numbers = way.get("nodes") or [""] * len(way.get("geometry") or ())
        places = way.get("geometry") or [None] * len(numbers)
        names = list[str]()
        for number, place in zip(numbers, places, strict=True):
            if place is None:
                names.append(str(number) or "?")
                continue
            longitude, latitude = _degrees(place)
            names.append(str(number) or f"{longitude},{latitude}")
            self.places.setdefault(names[-1], (longitude, latitude))
        return tuple(names)


def read_osm(path: Path) -> tuple[Feature, ...]:
    with reading_xml(path):
        extract = _extract(path)
    return features_of(extract, path)


def features_of(extract: Extract, path: Path) -> tuple[Feature, ...]:
    tagged = [number for number, way in extract.ways.items() if way.tags.keys() - META_TAGS]
    if tagged and not any(node in extract.places for number in tagged for node in extract.ways[number].nodes):
        words = f"way {tagged[0]}: expected the places of its nodes"
        hint = "end a query of Overpass with `out geom;`, or with `out body; >; out skel qt;`"
        raise BadInput(words, hint=hint, place=path)
    features = tuple(_features(extract, path))
    if not features:
        raise NothingThere("expected things with tags, but there are none", place=path)
    return features


def _degrees(place: Mapping[str, Any]) -> tuple[float, float]:
    longitude, latitude = float(place["lon"]), float(place["lat"])
    if not math.isfinite(longitude + latitude):
        raise ValueError(place)
    return longitude, latitude


def _extract(path: Path) -> Extract:
    extract = Extract()
    root = None
    for event, element in ElementTree.iterparse(path, ("start", "end")):
        if root is None:
            root = element
            if root.tag != "osm":
                raise WrongFormat(f"expected OpenStreetMap's XML, <osm>, not <{root.tag[:40]}>", place=path)
        if event == "end" and element.tag in ("node", "way", "relation", "remark"):
            if element.tag == "remark":
                extract.remarks.append((element.text or "").strip())
            elif element.get("action") != "delete" and element.get("visible") != "false":
                extract.add(_as_json(element), f"{path}: {element.tag} {element.get('id')}")
            root.clear()
    return extract


def _as_json(element: ElementTree.Element) -> dict[str, Any]:
    nodes = element.findall("nd")
    bounds = element.find("bounds")
    return {
        **element.attrib,
        "type": element.get("type", element.tag),
        "tags": {tag.get("k"): tag.get("v") for tag in element.iterfind("tag")},
        "nodes": [node.get("ref", "") for node in nodes],
        "geometry": [node.attrib if "lat" in node.attrib else None for node in nodes],
        "members": [_as_json(member) for member in element.iterfind("member")],
        "bounds": None if bounds is None else bounds.attrib,
    }


def is_overpass(document: Any) -> bool:
    return isinstance(document, dict) and isinstance(document.get("elements"), list)


def overpass_features(document: Mapping[str, Any], path: Path) -> tuple[Feature, ...]:
    extract = Extract(remarks=[str(document["remark"])] if document.get("remark") else [])
    for n, element in enumerate(document["elements"]):
        place = f"{path}: elements[{n}]"
        if not isinstance(element, dict) or not isinstance(element.get("type"), str) or "id" not in element:
            raise BadInput("expected an element with a type and an id", place=place)
        extract.add(element, place)
    return features_of(extract, path)


def is_area(tags: Mapping[str, str]) -> bool:
    kind = tags.get("type")
    is_building = not tags.keys().isdisjoint(("building", "building:part"))
    return kind in {"multipolygon", "building", "boundary"} or (is_building and kind != "route")


def plain_tags(pairs: Iterable[tuple[str, str]]) -> dict[str, str]:
    return {key: value.strip() for key, value in pairs if value.strip()}


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
        yield feature_of(f"node {number}", tags, shapely.Point(extract.places[number]), path, ())
    for number, way in extract.ways.items():
        if way.tags.keys() - META_TAGS:
            closes = len(way.nodes) > 1 and way.nodes[0] == way.nodes[-1]
            name = f"way {number}"
            shape = shape_of(corners_of(number), closes, way.tags)
            yield feature_of(name, way.tags, shape, path, _known((way,), extract, name))
    for number, relation in extract.relations.items():
        if relation.tags.keys() - META_TAGS - {"type"}:
            ways = [extract.ways[way] for way, _ in ways_of(relation) if way in extract.ways]
            name = f"relation {number}"
            shape = area_of(relation, corners_of)
            yield feature_of(name, relation.tags, shape, path, _known(ways, extract, name))


def _known(ways: Iterable[OsmWay], extract: Extract, name: str) -> list[Any]:
    corners: list[Any] = [extract.places[node] for way in ways for node in way.nodes if node in extract.places]
    return corners or (shapely.get_coordinates(extract.boxes[name]).tolist() if name in extract.boxes else [])


def feature_of(name: str, tags: dict[str, str], shape: Any, path: Path, known: Sequence[Sequence[float]]) -> Feature:
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
