"""Read map files by suffix. A small map is compared with the shapes that GDAL finds in it."""

import warnings
from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from functools import lru_cache
from importlib.util import find_spec
from itertools import compress
from pathlib import Path
from typing import Any, TypeAlias

import shapely

from ipoa_mission.errors import WrongSuffix
from ipoa_mission.finding import Finding, Severity
from ipoa_mission.maps.feature import Feature, many_objects
from ipoa_mission.maps.geojson import read_geojson
from ipoa_mission.maps.kml import read_kml, read_kmz
from ipoa_mission.maps.map_window import Degrees, MapWindow, expect_size
from ipoa_mission.maps.osm import read_osm
from ipoa_mission.maps.pbf import read_pbf
from ipoa_mission.maps.planar import simple_parts
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


def compare_with_gdal(path: Path) -> Iterator[Finding]:
    """Yield a warning if GDAL finds other shapes in a map; nothing without GDAL, or where it refuses the file."""
    most = 2 << 20  # bytes, read twice in about a second
    can_be_compared = path.suffix.lower() in (*GEOJSON, ".kml", ".kmz") and path.stat().st_size <= most
    if not can_be_compared or find_spec("pyogrio") is None:
        return
    from importlib.metadata import version

    import pyogrio

    features = read_features(path)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            layers = [name for name, _ in pyogrio.list_layers(path)]
            shapes = [shape for name in layers for shape in pyogrio.raw.read(path, layer=name, columns=[])[2]]
    except pyogrio.errors.DataSourceError:
        return
    theirs = _parts(shapely.from_wkb([shape for shape in shapes if shape is not None], on_invalid="fix"))
    ours = _parts(feature.shape for feature in features)
    if _describe_counts(ours) == _describe_counts(theirs):
        return
    apart = next((each.name.removeprefix(f"{path}: ") for each in features if _parts([each.shape]) - theirs), None)
    west, south, *_ = next(iter(theirs - ours), ("", (0.0, 0.0)))[1]
    first = f"the first that only GDAL has is at {south:g}, {west:g}" if apart is None else f"GDAL lacks {apart}"
    words = (
        f"{path.name}: two readers differ: {_describe_counts(ours)} by ipoa-mission {version('ipoa-mission')}, which "
        f"count, {_describe_counts(theirs)} by GDAL {pyogrio.__gdal_version_string__} (pyogrio {pyogrio.__version__}); "
        f"{first}"
    )
    yield Finding("readers-differ", Severity.WARNING, None, words, "look at that shape in the map")


def _parts(shapes: Iterable[Any]) -> Counter[tuple[str, tuple[float, ...]]]:
    """Return the kind and bounds of each part; closed lines are rings."""
    parts = Counter[tuple[str, tuple[float, ...]]]()
    for part in (part for shape in shapes if shape is not None for part in simple_parts(shape) if not part.is_empty):
        rings = [part.exterior, *part.interiors] if part.geom_type == "Polygon" else [part]
        for ring in rings:
            kind = "point" if ring.geom_type == "Point" else "ring" if ring.is_closed else "line"
            parts[kind, tuple(round(side, 6) + 0.0 for side in ring.bounds)] += 1  # to about 0.1 m
    return parts


def _describe_counts(parts: Counter[tuple[str, tuple[float, ...]]]) -> str:
    kinds = Counter[str]()
    for (kind, _), count in parts.items():
        kinds[kind] += count
    return ", ".join(f"{count} {kind}{'' if count == 1 else 's'}" for kind, count in sorted(kinds.items())) or "nothing"
