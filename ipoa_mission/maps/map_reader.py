"""Read map files by suffix."""

from collections.abc import Callable, Iterator, Sequence
from functools import lru_cache
from pathlib import Path

from ipoa_mission.errors import TooLarge, Unreadable, WrongSuffix
from ipoa_mission.maps.around import Around, Degrees
from ipoa_mission.maps.feature import Feature, many_objects
from ipoa_mission.maps.gdal_layers import FIRST_BYTES, read_layers
from ipoa_mission.maps.geojson import Take, read_geojson
from ipoa_mission.maps.kml import read_kml, read_kmz
from ipoa_mission.maps.osm import read_osm
from ipoa_mission.maps.parquet import read_parquet
from ipoa_mission.maps.pbf import read_pbf

GEOJSON = (".geojson", ".json", ".geojsonl", ".geojsons", ".geojsonseq", ".ndjson", ".jsonl")
_WHOLE_FILE_READERS = {".kml": read_kml, ".kmz": read_kmz, ".osm": read_osm}
# For files that may exceed memory.
_BATCH_READERS: dict[str, Callable[[Path, Around], Iterator[list[Feature]]]] = {
    ".pbf": read_pbf,
    ".parquet": read_parquet,
    ".geoparquet": read_parquet,
}
READERS = (*GEOJSON, *_WHOLE_FILE_READERS, *FIRST_BYTES, *_BATCH_READERS)


def read_features(path: Path, around: Around | None = None) -> tuple[Feature, ...]:
    features: list[Feature] = []

    def begin() -> Take:
        features.clear()
        return lambda more: _extend(features, more, path)

    hand_on_features(path, begin, around)
    return tuple(features)


def hand_on_features(path: Path, begin: Callable[[], Take], around: Around | None = None) -> None:
    """Pass on features in batches; a second call of `begin` voids earlier ones."""
    suffix, around = path.suffix.lower(), around or Around()
    if suffix in GEOJSON:
        read_geojson(path, begin)
    elif suffix in _WHOLE_FILE_READERS or suffix in FIRST_BYTES:
        whole = _WHOLE_FILE_READERS.get(suffix)
        if features := read_layers(path, around) if whole is None else whole(path):
            begin()(features)
    elif suffix in _BATCH_READERS:
        with many_objects():
            _hand_on_large(path, begin(), around)
    else:
        words = f"expected a file that ends in {', '.join(READERS)}, not in {path.suffix or 'nothing'}"
        raise WrongSuffix(words, place=path)


def _hand_on_large(path: Path, take: Take, around: Around) -> None:
    if around.is_small:
        try:
            stat = path.stat()
        except OSError as error:
            raise Unreadable(f"cannot be read: {error.strerror}", place=path) from error
        features, around.elsewhere = _small_part(path, (stat.st_mtime_ns, stat.st_size), around.window, around.near)
        take(features)
        return
    around.elsewhere = 0
    for batch in _BATCH_READERS[path.suffix.lower()](path, around):
        take(batch)
    around.expect_near(path)


@lru_cache(maxsize=2)  # the studio reads a scenario at every change
def _small_part(
    path: Path, version: tuple[int, int], window: Degrees | None, near: Degrees | None
) -> tuple[tuple[Feature, ...], int]:
    around, features = Around(window, near), list[Feature]()
    for batch in _BATCH_READERS[path.suffix.lower()](path, around):
        _extend(features, batch, path)
    around.expect_near(path)
    return tuple(features), around.elsewhere


def _extend(features: list[Feature], more: Sequence[Feature], path: Path) -> None:
    features.extend(more)
    if len(features) > 2_000_000:  # in memory
        raise TooLarge("expected at most 2,000,000 things", hint="cut out the surroundings of the flight", place=path)
