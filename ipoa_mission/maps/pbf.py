"""Read OpenStreetMap's binary extracts by osmium: a first pass locates all, a second reads tags of the wanted."""

from collections.abc import Iterator, Mapping
from itertools import compress, islice
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import shapely

from ipoa_mission.errors import BadInput, DamagedFile, NothingThere, WrongFormat, imported
from ipoa_mission.files import read_bytes
from ipoa_mission.maps.feature import BATCH, EMPTY_SHAPE, Feature
from ipoa_mission.maps.map_window import MapWindow, expect_size
from ipoa_mission.maps.osm import META_TAGS, Relation, area_of, feature_of, is_area, plain_tags, shape_of, ways_of

LARGEST_PBF = 200_000_000  # [bytes], about a minute


class _Located(NamedTuple):
    """A node or way as WKB; if places are missing None, and the `known` ones."""

    is_node: bool
    number: int
    has_tags: bool
    wkb: bytes | None
    known: tuple[tuple[float, float], ...] = ()


def read_pbf(path: Path, around: MapWindow) -> tuple[Feature, ...]:
    osmium = imported("osmium", f"{path}: reading it needs osmium, which is not installed", "maps", BadInput)
    if b"OSMHeader" not in read_bytes(path, 64):
        raise WrongFormat("expected an .osm.pbf file, but its first bytes are those of another format", place=path)
    cut = "osmium extract --strategy smart --bbox {},{},{},{} --output town.osm.pbf {file}"
    expect_size(path, LARGEST_PBF, around.window, cut)
    try:
        features = tuple(_features(osmium, path, around))
    except (RuntimeError, OSError, ValueError) as error:
        raise DamagedFile(f"expected a whole .osm.pbf file: {error}", place=path) from error
    if not features and not around.elsewhere:
        raise NothingThere("expected things with tags, but there are none", place=path)
    return features


def _features(osmium: Any, path: Path, around: MapWindow) -> Iterator[Feature]:
    osm = osmium.osm
    file = osmium.io.File(str(path), "pbf")
    if osmium.io.Reader(file, osm.NOTHING).header().has_multiple_object_versions:
        raise BadInput("expected the map as it is now, not its history", place=path)
    relations = _areas(osmium, file)
    numbers = {int(number) for relation in relations.values() for number, _ in ways_of(relation)}
    members = dict[str, Any]()  # ways of relations, with or without tags of their own
    wanted: dict[Any, dict[int, Any]] = {osm.NODE: {}, osm.WAY: {}}
    elements = _located(osmium, file, path)
    while batch := list(islice(elements, BATCH)):
        shapes = shapely.from_wkb([element.wkb for element in batch])
        for n in np.flatnonzero(shapely.is_missing(shapes)):
            shapes[n] = shapely.MultiPoint(batch[n].known)
        for element, shape in zip(batch, shapes, strict=True):
            if not element.is_node and element.number in numbers:
                members[str(element.number)] = shape
        tagged = np.flatnonzero([element.has_tags for element in batch])
        is_wanted = around.wants(shapely.bounds(shapes[tagged]).reshape(-1, 4))
        for n in tagged[is_wanted].tolist():
            wanted[osm.NODE if batch[n].is_node else osm.WAY][batch[n].number] = shapes[n]
    for sort, wanted_shapes in wanted.items():
        of_these = osmium.filter.IdFilter(wanted_shapes)  # not kept alive by the iterator
        for element in osmium.FileProcessor(file, sort).with_filter(of_these) if wanted_shapes else ():
            tags = _tags(element)
            if tags.keys() - META_TAGS:
                yield _feature(element, tags, wanted_shapes[element.id], path)
    yield from _relation_features(relations, members, path, around)


def _areas(osmium: Any, file: Any) -> dict[str, Relation]:
    relations = dict[str, Relation]()
    sorts = {"n": "node", "w": "way", "r": "relation"}
    for relation in osmium.FileProcessor(file, osmium.osm.RELATION):
        tags = _tags(relation)
        if is_area(tags) and tags.keys() - META_TAGS - {"type"}:
            members = tuple((sorts.get(each.type, ""), str(each.ref), each.role) for each in relation.members)
            relations[str(relation.id)] = Relation(members, tags)
    return relations


def _located(osmium: Any, file: Any, path: Path) -> Iterator[_Located]:
    osm = osmium.osm
    factory = osmium.geom.WKBFactory()
    all_nodes = osmium.geom.use_nodes.ALL
    with_tags = osmium.filter.EmptyTagFilter().enable_for(osm.NODE)
    elements = osmium.FileProcessor(file, osm.NODE | osm.WAY).with_locations("sparse_file_array")
    for element in elements.with_filter(with_tags):
        is_node = element.is_node()
        if element.id < 0:  # libosmium keeps no position
            words = f"expected things that OpenStreetMap has numbered, not {'node' if is_node else 'way'} {element.id}"
            raise BadInput(words, hint="save it as OpenStreetMap's XML (.osm), which may have them", place=path)
        has_tags = len(element.tags) > 0
        try:
            text = factory.create_point(element) if is_node else factory.create_linestring(element, all_nodes)
        except (osmium.InvalidLocationError, RuntimeError):  # missing, or a way of one node
            places = () if is_node else element.nodes
            known = tuple((place.lon, place.lat) for place in places if place.location.valid())
            yield _Located(is_node, element.id, has_tags, None, known)
        else:
            yield _Located(is_node, element.id, has_tags, bytes.fromhex(text))


def _feature(element: Any, tags: dict[str, str], located: Any, path: Path) -> Feature:
    if element.is_node():
        return feature_of(f"node {element.id}", tags, EMPTY_SHAPE if located.is_empty else located, path, ())
    corners = shapely.get_coordinates(located).tolist()
    shape = shape_of(corners if located.geom_type == "LineString" else None, element.is_closed(), tags)
    return feature_of(f"way {element.id}", tags, shape, path, corners)


def _relation_features(
    relations: Mapping[str, Relation], members: Mapping[str, Any], path: Path, around: MapWindow
) -> Iterator[Feature]:
    def corners_of(number: str) -> Any:
        way = members.get(number)
        return shapely.get_coordinates(way) if way is not None and way.geom_type == "LineString" else None

    parts = {number: [members[way] for way, _ in ways_of(each) if way in members] for number, each in relations.items()}
    boxes = np.array([shapely.total_bounds(shapes) for shapes in parts.values()]).reshape(-1, 4)
    for number, relation in compress(relations.items(), around.wants(boxes).tolist()):
        known = shapely.get_coordinates(parts[number]).tolist()
        yield feature_of(f"relation {number}", relation.tags, area_of(relation, corners_of), path, known)


def _tags(element: Any) -> dict[str, str]:
    return plain_tags((tag.k, tag.v) for tag in element.tags)
