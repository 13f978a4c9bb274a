"""Read map files by suffix."""

from collections.abc import Callable
from functools import lru_cache
from itertools import compress
from pathlib import Path
from typing import TypeAlias

import shapely

from ipoa_mission.errors import WrongSuffix
from ipoa_mission.maps.feature import Feature, many_objects
from ipoa_mission.maps.geojson import read_geojson
from ipoa_mission.maps.kml import read_kml, read_kmz
from ipoa_mission.maps.map_window import Degrees, MapWindow, expect_size
from ipoa_mission.maps.osm import read_osm
from ipoa_mission.maps.pbf import read_pbf
from ipoa_mission.maps.table_layers import FIRST_BYTES, read_table

GEOJSON = (".geojson", ".json", ".geojsonl", ".geojsons", ".geojsonseq", ".ndjson", ".jsonl")
LARGEST_WHOLE = 500_000_000  # [bytes]; a GeoJSON takes about a minute and 7 GB of memory
Features: TypeAlias = tuple[Feature, ...]
# Of whole files.
_READERS: dict[str, Callable[[Path], Features]] = {
    **dict.fromkeys(GEOJSON, read_geojson),
    ".kml": read_kml,
    ".kmz": read_kmz,
    ".osm": read_osm,
}
# Of parts of files.
_WINDOW_READERS: dict[str, Callable[[Path, MapWindow], Features]] = {
    ".pbf": read_pbf,
    **dict.fromkeys(FIRST_BYTES, read_table),
}
READERS = (*_READERS, *_WINDOW_READERS)


@many_objects()
def read_features(path: Path, around: MapWindow | None = None) -> Features:
    """Return the features in a window, by default all."""
    around = around or MapWindow()
    if path.suffix.lower() not in READERS:
        words = f"expected a file that ends in {', '.join(READERS)}, not in {path.suffix or 'nothing'}"
        raise WrongSuffix(words, hint="GDAL converts most maps: ogr2ogr map.geojson FILE", place=path)
    if around.window == around.near:
        return _read(path, around)
    stat = path.stat() if path.is_file() else None
    version = () if stat is None else (stat.st_mtime_ns, stat.st_ctime_ns, stat.st_size)
    features, around.elsewhere = _read_window(path, version, around.window, around.near)
    return features


@lru_cache(maxsize=8)  # the studio reads a scenario at every change
def _read_window(
    path: Path, version: tuple[int, ...], window: Degrees | None, near: Degrees | None
) -> tuple[Features, int]:
    around = MapWindow(window, near)
    return _read(path, around), around.elsewhere


def _read(path: Path, around: MapWindow) -> Features:
    suffix = path.suffix.lower()
    if suffix in _WINDOW_READERS:
        features = _WINDOW_READERS[suffix](path, around)
    else:
        expect_size(path, LARGEST_WHOLE, around.window, "ogr2ogr -spat {} {} {} {} town.geojson {file}")
        features = _READERS[suffix](path)
        if around.window != around.near:
            boxes = shapely.bounds([feature.shape for feature in features]).reshape(-1, 4)
            features = tuple(compress(features, around.wants(boxes).tolist()))
    around.expect_near(path)
    return features
