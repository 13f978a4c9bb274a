"""Readers of map files by suffix."""

from collections.abc import Callable, Iterator, Sequence
from functools import lru_cache
from pathlib import Path

from ipoa_mission.errors import TooLarge, Unreadable, WrongSuffix
from ipoa_mission.maps.around import Around, Degrees
from ipoa_mission.maps.csv_table import BEGINS, read_table
from ipoa_mission.maps.feature import Feature, many_objects
from ipoa_mission.maps.geojson import Take, read_geojson
from ipoa_mission.maps.kml import read_kml, read_kmz
from ipoa_mission.maps.osm import read_osm
from ipoa_mission.maps.parquet import read_parquet
from ipoa_mission.maps.pbf import read_pbf

GEOJSON = (".geojson", ".json", ".geojsonl", ".geojsons", ".geojsonseq", ".ndjson", ".jsonl")
_WHOLE_FILE_READERS = {
    ".kml": read_kml,
    ".kmz": read_kmz,
    ".osm": read_osm,
}
# For files that may exceed memory.
_BATCH_READERS: dict[str, Callable[[Path, Around], Iterator[list[Feature]]]] = {
    ".pbf": read_pbf,
    ".parquet": read_parquet,
    ".geoparquet": read_parquet,
}
READERS = (*GEOJSON, *_WHOLE_FILE_READERS, *BEGINS, *_BATCH_READERS)
MOST_FEATURES = 2_000_000  # in memory


def read_features(path: Path, around: Around | None = None) -> tuple[Feature, ...]:
    """Read all features; report every error with file and place."""
    features: list[Feature] = []

    def begin() -> Take:
        features.clear()
        return lambda more: _extend(features, more, path)

    hand_on_features(path, begin, around)
    return tuple(features)


def hand_on_features(path: Path, begin: Callable[[], Take], around: Around | None = None) -> None:
    """Pass on features in batches; a second call of `begin` voids earlier ones."""
    suffix = path.suffix.lower()
    if suffix in GEOJSON:
        read_geojson(path, begin)
    elif suffix in _WHOLE_FILE_READERS:
        if features := _WHOLE_FILE_READERS[suffix](path):
            begin()(features)
    elif suffix in BEGINS:
        if features := read_table(path, around or Around()):
            begin()(features)
    elif suffix in _BATCH_READERS:
        with many_objects():
            _hand_on_large(path, begin(), around or Around())
    else:
        words = f"expected a file that ends in {', '.join(READERS)}, not in {path.suffix or 'nothing'}"
        raise WrongSuffix(words, place=path)


def _hand_on_large(path: Path, take: Take, around: Around) -> None:
    if around.is_small:
        try:
            about = path.stat()
        except OSError as error:
            raise Unreadable(f"cannot be read: {error.strerror}", place=path) from error
        features, around.elsewhere = _small_part(path, (about.st_mtime_ns, about.st_size), around.window, around.near)
        take(features)
        return
    around.elsewhere = 0
    for some in _BATCH_READERS[path.suffix.lower()](path, around):
        take(some)
    around.expect_near(path)


@lru_cache(maxsize=2)  # the studio reads a scenario at every change
def _small_part(
    path: Path, as_it_was: tuple[int, int], window: Degrees | None, near: Degrees | None
) -> tuple[tuple[Feature, ...], int]:
    around, features = Around(window, near), list[Feature]()
    for some in _BATCH_READERS[path.suffix.lower()](path, around):
        _extend(features, some, path)
    around.expect_near(path)
    return tuple(features), around.elsewhere


def _extend(features: list[Feature], more: Sequence[Feature], path: Path) -> None:
    features.extend(more)
    if len(features) > MOST_FEATURES:
        words = f"expected at most {MOST_FEATURES:,} things"
        raise TooLarge(words, hint="cut out the surroundings of the flight", place=path)
