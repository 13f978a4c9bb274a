"""Map files with features: which reader reads which."""

from pathlib import Path

from ipoa_mission.errors import BadInput
from ipoa_mission.maps.feature import Feature
from ipoa_mission.maps.geojson import read_geojson
from ipoa_mission.maps.kml import read_kml, read_kmz
from ipoa_mission.maps.tables import BEGINS, read_table

READERS = {
    ".geojson": read_geojson,
    ".json": read_geojson,
    ".kml": read_kml,
    ".kmz": read_kmz,
    **dict.fromkeys(BEGINS, read_table),
}


def read_features(path: Path) -> tuple[Feature, ...]:
    """The features of a map file, in its order: by its suffix GeoJSON, KML, KMZ, Shapefile, FlatGeobuf or GeoPackage.

    Raises:
        BadInput: naming file and place of everything that is wrong, and what was expected there.
        MissionError: a library that reads it is not installed.
    """
    suffix = path.suffix.lower()
    if suffix not in READERS:
        raise BadInput(f"{path}: expected a file that ends in {', '.join(READERS)}, not in {path.suffix or 'nothing'}")
    return READERS[suffix](path)
