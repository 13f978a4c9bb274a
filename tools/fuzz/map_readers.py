"""What each reader of maps takes of a file: geometries, their areas and lengths, keys.

`python -m tools.fuzz.map_readers FILE...` prints a row a file and a reader: ours, pyogrio (GDAL), fastkml, osmium. Each
reader runs in a process of its own.
"""

import argparse
import json
import subprocess
import sys
import warnings
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import Any

import shapely

LONGEST_S = 1200.0
Thing = tuple[Any, Iterable[str]]  # a shape and the keys of its properties


def ours(path: Path) -> Iterator[Thing]:
    """This package."""
    from ipoa_mission.maps.map_reader import read_features

    for feature in read_features(path):
        yield feature.shape, feature.tags


def gdal(path: Path) -> Iterator[Thing]:
    """Every layer by pyogrio; what packs other tags is unpacked."""
    import pyogrio

    from ipoa_mission.maps.properties import tags_of

    for layer in pyogrio.list_layers(path)[:, 0]:
        meta, _, shapes, fields = pyogrio.raw.read(path, layer=layer)
        for row in range(len(fields[0]) if fields else len(shapes)):
            known = {str(key): column[row] for key, column in zip(meta["fields"], fields, strict=True)}
            known = {key: value for key, value in known.items() if value is not None and value == value}
            shape = None if shapes is None else shapes[row]
            yield shapely.from_wkb(shape) if shape else None, dict(tags_of(known)) or known


def fastkml(path: Path) -> Iterator[Thing]:
    """The placemarks of a KML."""
    import fastkml as library
    from fastkml.utils import find_all

    marks: Iterator[Any] = find_all(library.KML.parse(path, strict=False), of_type=library.Placemark)
    for mark in marks:
        yield None if mark.geometry is None else shapely.geometry.shape(mark.geometry), ["name"] if mark.name else []


def osmium(path: Path) -> Iterator[Thing]:
    """Nodes, ways that are no areas, and areas, with tags."""
    import osmium as library

    make = library.geom.WKBFactory()
    for thing in library.FileProcessor(path).with_areas().with_filter(library.filter.EmptyTagFilter()):
        shape = None
        try:
            if thing.is_node():
                shape = make.create_point(thing)
            elif thing.is_way() and not thing.is_closed():
                shape = make.create_linestring(thing)
            elif thing.is_area():
                shape = make.create_multipolygon(thing)
            else:
                continue
        except (library.InvalidLocationError, RuntimeError):
            pass
        yield None if shape is None else shapely.from_wkb(bytes.fromhex(shape)), [tag.k for tag in thing.tags]


READERS: dict[str, tuple[Callable[[Path], Iterator[Thing]], tuple[str, ...]]] = {
    "ours": (ours, ()),
    "GDAL": (gdal, (".kml", ".kmz", ".osm", ".pbf", ".geojson", ".json", ".shp", ".gpkg", ".fgb")),
    "fastkml": (fastkml, (".kml",)),
    "osmium": (osmium, (".osm", ".pbf")),
}


def summary(things: Iterable[Thing]) -> dict[str, Any]:
    """How many shapes and how many features without one; area of polygons and closed lines, length of others, keys."""
    found: dict[str, Any] = {"shapes": 0, "without": 0, "area": 0.0, "length": 0.0}
    keys = set[str]()
    for shape, names in things:
        keys.update(names)
        if shape is None or shapely.is_empty(shape):
            found["without"] += 1
            continue
        found["shapes"] += 1
        for part in _flat(shape):
            is_ring = part.geom_type in ("LineString", "LinearRing") and part.is_closed
            found["area"] += shapely.Polygon(part).area if is_ring and len(part.coords) > 3 else part.area
            found["length"] += 0.0 if part.area or is_ring else part.length
    return found | {"keys": len(keys)}


def _flat(shape: Any) -> Iterator[Any]:
    if hasattr(shape, "geoms"):
        for part in shape.geoms:
            yield from _flat(part)
    else:
        yield shape


def each(reader: str, names: list[str]) -> None:
    """Print what one reader finds in each file, as JSON, one a line."""
    warnings.simplefilter("ignore")
    for name in names:
        try:
            found = summary(READERS[reader][0](Path(name)))
        except Exception as error:  # whatever the library raises
            found = {"refused": f"{type(error).__name__}: {error}".replace(name, "").strip()[:100]}
        print(json.dumps(found), flush=True)


def main() -> None:
    """A row for each file and reader; with --each what one of them finds."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("files", nargs="+")
    parser.add_argument("--each", metavar="READER", choices=READERS, help="what this one finds, a line of JSON a file")
    options = parser.parse_args()
    if options.each:
        each(options.each, options.files)
        return
    for reader, (_, suffixes) in READERS.items():
        names = [name for name in options.files if not suffixes or Path(name).suffix.lower() in suffixes]
        while names:
            command = [sys.executable, "-m", "tools.fuzz.map_readers", "--each", reader, *names]
            ended = subprocess.run(command, capture_output=True, text=True, timeout=LONGEST_S, check=False)
            lines = ended.stdout.splitlines()
            for name, line in zip(names, lines, strict=False):
                print(f"{Path(name).name}\t{reader}\t{line}", flush=True)
            names = names[len(lines) :]
            if names:  # it ended in the next one
                print(f"{Path(names.pop(0)).name}\t{reader}\t{json.dumps({'ended': ended.returncode})}", flush=True)


if __name__ == "__main__":
    main()
