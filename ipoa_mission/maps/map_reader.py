"""Map files with features: which reader reads which."""

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
_OTHERS = {
    ".kml": read_kml,
    ".kmz": read_kmz,
    ".osm": read_osm,
}
#: Of files that may be larger than memory only what is wanted is read, some at a time.
_LARGE: dict[str, Callable[[Path, Around], Iterator[list[Feature]]]] = {
    ".pbf": read_pbf,
    ".parquet": read_parquet,
    ".geoparquet": read_parquet,
}
READERS = (*GEOJSON, *_OTHERS, *BEGINS, *_LARGE)
MOST_FEATURES = 2_000_000  # are in memory together


def read_features(path: Path, around: Around | None = None) -> tuple[Feature, ...]:
    """The features of a map file, in its order, whatever it is by its suffix (`READERS`).

    Args:
        path: the file.
        around: what of a large file is wanted (of .pbf, GeoParquet, Shapefile, FlatGeobuf, GeoPackage); None for all.

    Raises:
        BadInput: naming file and place of everything that is wrong, and what was expected there.
        BadInput: a library that reads it is not installed.
    """
    features: list[Feature] = []

    def begin() -> Take:
        features.clear()
        return lambda more: _extend(features, more, path)

    hand_on_features(path, begin, around)
    return tuple(features)


def hand_on_features(path: Path, begin: Callable[[], Take], around: Around | None = None) -> None:
    """Hand on the features of a map file some at a time, so that those of a large file never are all there.

    Args:
        path: the file.
        begin: what takes them, from the first on; it may be asked anew, for what was handed on is not so.
        around: what of a large file is wanted, where what is not is counted; None for all of it.

    Raises:
        BadInput: naming file and place of everything that is wrong, and what was expected there.
        BadInput: a library that reads it is not installed.
    """
    suffix = path.suffix.lower()
    if suffix in GEOJSON:
        read_geojson(path, begin)
    elif suffix in _OTHERS:
        if features := _OTHERS[suffix](path):
            begin()(features)
    elif suffix in BEGINS:
        if features := read_table(path, around or Around()):
            begin()(features)
    elif suffix in _LARGE:
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
    for some in _LARGE[path.suffix.lower()](path, around):
        take(some)
    around.expect_near(path)


@lru_cache(maxsize=2)  # on the page a scenario is read anew at every change, and little of it changes
def _small_part(
    path: Path, as_it_was: tuple[int, int], window: Degrees | None, near: Degrees | None
) -> tuple[tuple[Feature, ...], int]:
    """What of a large file meets a window, and how much does not."""
    around, features = Around(window, near), list[Feature]()
    for some in _LARGE[path.suffix.lower()](path, around):
        _extend(features, some, path)
    around.expect_near(path)
    return tuple(features), around.elsewhere


def _extend(features: list[Feature], more: Sequence[Feature], path: Path) -> None:
    features.extend(more)
    if len(features) > MOST_FEATURES:
        words = f"expected at most {MOST_FEATURES:,} things"
        raise TooLarge(words, hint="cut out what lies round the flight", place=path)
