"""Map files with features: which reader reads which."""

from pathlib import Path

from ipoa_mission.errors import BadInput
from ipoa_mission.maps.feature import Feature
from ipoa_mission.maps.geojson import read_geojson
from ipoa_mission.maps.kml import read_kml

READERS = {".geojson": read_geojson, ".json": read_geojson, ".kml": read_kml}


def read_features(path: Path) -> tuple[Feature, ...]:
    """The features of a GeoJSON (`.geojson`, `.json`) or KML (`.kml`) file, in its order.

    Raises:
        BadInput: naming file and place of everything that is wrong, and what was expected there.
    """
    suffix = path.suffix.lower()
    if suffix not in READERS:
        raise BadInput(f"{path}: expected a file that ends in {', '.join(READERS)}, not in {path.suffix or 'nothing'}")
    return READERS[suffix](path)
