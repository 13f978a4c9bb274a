"""Map files with features: which reader reads which."""

from collections.abc import Callable
from pathlib import Path

from ipoa_mission.errors import BadInput
from ipoa_mission.maps.feature import Feature
from ipoa_mission.maps.geojson import Take, read_geojson
from ipoa_mission.maps.kml import read_kml, read_kmz
from ipoa_mission.maps.osm import read_osm
from ipoa_mission.maps.tables import BEGINS, read_table

GEOJSON = (".geojson", ".json")
_OTHERS = {
    ".kml": read_kml,
    ".kmz": read_kmz,
    ".osm": read_osm,
    **dict.fromkeys(BEGINS, read_table),
}
READERS = (*GEOJSON, *_OTHERS)


def read_features(path: Path) -> tuple[Feature, ...]:
    """The features of a map file, in its order, whatever it is by its suffix (`READERS`).

    Raises:
        BadInput: naming file and place of everything that is wrong, and what was expected there.
        MissionError: a library that reads it is not installed.
    """
    features: list[Feature] = []

    def begin() -> Take:
        features.clear()
        return features.extend

    hand_on_features(path, begin)
    return tuple(features)


def hand_on_features(path: Path, begin: Callable[[], Take]) -> None:
    """Hand on the features of a map file some at a time, so that those of a large GeoJSON file never are all there.

    Args:
        path: the file.
        begin: what takes them, from the first on; it may be asked anew, for what was handed on is not so.

    Raises:
        BadInput: naming file and place of everything that is wrong, and what was expected there.
        MissionError: a library that reads it is not installed.
    """
    suffix = path.suffix.lower()
    if suffix in GEOJSON:
        read_geojson(path, begin)
    elif suffix in _OTHERS:
        if features := _OTHERS[suffix](path):
            begin()(features)
    else:
        raise BadInput(f"{path}: expected a file that ends in {', '.join(READERS)}, not in {path.suffix or 'nothing'}")
