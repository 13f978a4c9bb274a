"""Read OpenStreetMap's binary extracts by osmium: a first pass locates all, a second reads the wanted."""

from collections.abc import Iterator, Mapping
from itertools import compress, islice
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import shapely
from numpy.typing import NDArray

from ipoa_mission.errors import BadInput, DamagedFile, NothingThere, TooLarge, WrongFormat, imported
from ipoa_mission.files import read_bytes
from ipoa_mission.maps.feature import BATCH, EMPTY_SHAPE, Feature
from ipoa_mission.maps.map_window import MapWindow, cut_out
from ipoa_mission.maps.osm import META_TAGS, Relation, area_of, feature_of, is_area, plain_tags, shape_of, ways_of

LARGEST_PBF = 200_000_000  # [bytes], about a minute
UNKNOWN_BOX = (np.nan,) * 4


class _Located(NamedTuple):
    """A node or way: its corners as WKB, or the box of the known ones."""

    is_node: bool
    number: int
    has_tags: bool
    wkb: bytes | None
    box: tuple[float, ...]


def read_pbf(path: Path, around: MapWindow) -> Iterator[list[Feature]]:
    osmium = imported("osmium", f"{path}: reading it needs osmium, which is not installed", "maps", BadInput)
    if b"OSMHeader" not in read_bytes(path, 64):
        raise WrongFormat("expected an .osm.pbf file, but its first bytes are those of another format", place=path)
    if (size := path.stat().st_size) > LARGEST_PBF:
        raise TooLarge(
            f"expected an extract of at most {LARGEST_PBF / 1e6:.0f} MB, not {size / 1e6:.0f} MB",
            hint="cut out the surroundings of the flight: osmium extract --strategy smart "
            f"--bbox {cut_out(around.window)} --output town.osm.pbf {path.name}",
            place=path,
        )
    any_there = False
    features = _Extract(osmium, path, around).read()
    try:
        while some := list(islice(features, BATCH)):
            any_there = True
            yield some
    except (RuntimeError, OSError, ValueError) as error:
        raise DamagedFile(f"expected a whole .osm.pbf file: {error}", place=path) from error
    if not any_there and not around.elsewhere:
        raise NothingThere("expected things with tags, but there are none", place=path)


class _Extract:
    def __init__(self, osmium: Any, path: Path, around: MapWindow) -> None:
        self._osmium = osmium
        self._path = path
        self._around = around
        self._file = osmium.io.File(str(path), "pbf")
        self._factory = osmium.geom.WKBFactory()
        self._all = osmium.geom.use_nodes.ALL
        self._nodes = set[int]()
        self._ways = set[int]()
        self._boxes: dict[str, list[float]] = {}  # of ways of areas [deg]

    def read(self) -> Iterator[Feature]:
        osmium = self._osmium
        osm = self._osmium.osm
        if osmium.io.Reader(self._file, osm.NOTHING).header().has_multiple_object_versions:
            raise BadInput("expected the map as it is now, not its history", place=self._path)
        relations = self._relations()
        places = self._locate(_parts(relations))
        if relations:
            counts = self._around.wants(np.array([self._box_of(relation) for relation in relations.values()]))
            relations = {number: relations[number] for number in compress(relations, counts.tolist())}
        for node in self._again(osm.NODE, self._nodes):
            shape = shapely.Point(node.lon, node.lat) if _is_known(node) else EMPTY_SHAPE
            tags = _tags(node)
            if tags.keys() - META_TAGS:
                yield feature_of(f"node {node.id}", tags, shape, self._path)
        parts = _parts(relations)
        lines = dict[str, list[tuple[float, float]] | None]()
        known = dict[str, list[tuple[float, float]]]()
        located = osmium.NodeLocationsForWays(places)
        located.ignore_errors()
        for way in self._again(osm.WAY, self._ways.union(map(int, parts)), located):
            here = [(node.lon, node.lat) for node in way.nodes if _is_known(node)]
            corners = here if len(here) == len(way.nodes) > 1 else None
            if str(way.id) in parts:
                lines[str(way.id)] = corners
                known[str(way.id)] = here
            tags = _tags(way)
            if way.id in self._ways and tags.keys() - META_TAGS:
                yield feature_of(f"way {way.id}", tags, shape_of(corners, way.is_closed(), tags), self._path, here)
        for number, relation in relations.items():
            of_ways = [corner for way, _ in ways_of(relation) for corner in known.get(way, ())]
            shape = area_of(relation, lines.get)
            yield feature_of(f"relation {number}", relation.tags, shape, self._path, of_ways)

    def _relations(self) -> dict[str, Relation]:
        relations = {}
        sorts = {"n": "node", "w": "way", "r": "relation"}
        for relation in self._osmium.FileProcessor(self._file, self._osmium.osm.RELATION):
            tags = _tags(relation)
            if is_area(tags) and tags.keys() - META_TAGS - {"type"}:
                members = tuple((sorts.get(each.type, ""), str(each.ref), each.role) for each in relation.members)
                relations[str(relation.id)] = Relation(members, tags)
        return relations

    def _locate(self, parts: set[str]) -> Any:
        """Select the wanted things, and return libosmium's node positions."""
        osm = self._osmium.osm
        tagged = self._osmium.filter.EmptyTagFilter().enable_for(osm.NODE)
        things = self._osmium.FileProcessor(self._file, osm.NODE | osm.WAY).with_locations("sparse_file_array")
        waiting: list[_Located] = []
        for each in things.with_filter(tagged):
            if each.id < 0:  # libosmium keeps no position
                raise BadInput(
                    f"expected things that OpenStreetMap has numbered, not "
                    f"{'node' if each.is_node() else 'way'} {each.id}",
                    hint="save it as OpenStreetMap's XML (.osm), which may have them",
                    place=self._path,
                )
            waiting.append(self._located(each))
            if len(waiting) >= BATCH:
                self._choose(waiting, parts)
                waiting.clear()
        self._choose(waiting, parts)
        return things.node_location_storage

    def _located(self, each: Any) -> _Located:
        if each.is_node():
            box = (each.lon, each.lat, each.lon, each.lat) if _is_known(each) else UNKNOWN_BOX
            return _Located(True, each.id, True, None, box)
        wkb = None
        box = UNKNOWN_BOX
        try:
            wkb = bytes.fromhex(self._factory.create_linestring(each, self._all))
        except (self._osmium.InvalidLocationError, RuntimeError):  # missing or single node
            if corners := [(node.lon, node.lat) for node in each.nodes if _is_known(node)]:
                box = (*np.min(corners, axis=0).tolist(), *np.max(corners, axis=0).tolist())
        return _Located(False, each.id, len(each.tags) > 0, wkb, box)

    def _choose(self, located: list[_Located], parts: set[str]) -> None:
        shapes = shapely.from_wkb([each.wkb for each in located])
        known = np.array([each.box for each in located]).reshape(-1, 4)
        boxes = np.where(shapely.is_missing(shapes)[:, None], known, shapely.bounds(shapes).reshape(-1, 4))
        for each, box in zip(located, boxes, strict=True):
            if not each.is_node and parts and str(each.number) in parts:
                self._boxes[str(each.number)] = box.tolist()
        has_tags = np.array([each.has_tags for each in located], bool)
        for n in np.flatnonzero(has_tags)[self._around.wants(boxes[has_tags])].tolist():
            (self._nodes if located[n].is_node else self._ways).add(located[n].number)

    def _box_of(self, relation: Relation) -> NDArray[np.float64]:
        boxes = np.array([self._boxes.get(number, UNKNOWN_BOX) for number, _ in ways_of(relation)] or [UNKNOWN_BOX])
        return np.concatenate([np.fmin.reduce(boxes[:, :2]), np.fmax.reduce(boxes[:, 2:])])

    def _again(self, sort: Any, numbers: set[int], *handlers: Any) -> Iterator[Any]:
        if numbers:
            of_these = self._osmium.filter.IdFilter(numbers)  # not kept alive by the iterator
            with self._osmium.io.Reader(self._file, sort) as reader:
                yield from self._osmium.OsmFileIterator(reader, *handlers, of_these)


def _tags(each: Any) -> dict[str, str]:
    return plain_tags((tag.k, tag.v) for tag in each.tags)


def _is_known(node: Any) -> bool:
    return bool(node.location.valid())


def _parts(relations: Mapping[str, Relation]) -> set[str]:
    return {number for relation in relations.values() for number, _ in ways_of(relation)}
