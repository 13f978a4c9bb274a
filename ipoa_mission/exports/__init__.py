"""Missions for other people's programs: KML, GeoJSON, CSV and GPX, chosen by the suffix."""

from collections.abc import Callable
from pathlib import Path

from ipoa_mission.checks.positions import refuse_unsound
from ipoa_mission.errors import BadInput
from ipoa_mission.exports.comma_separated import to_csv
from ipoa_mission.exports.geojson import to_geojson
from ipoa_mission.exports.gpx import to_gpx
from ipoa_mission.exports.kml import to_kml
from ipoa_mission.files import write_atomically
from ipoa_mission.items import Mission

#: Suffix -> the mission, under a name, as the text of such a file.
EXPORTS: dict[str, Callable[[Mission, str], str]] = {
    ".kml": to_kml,
    ".geojson": to_geojson,
    ".csv": to_csv,
    ".gpx": to_gpx,
}


def write_export(mission: Mission, path: str | Path) -> None:
    """Write the mission in the format of the suffix, named as the file; the same mission gives the same bytes.

    Raises:
        BadInput: no such format, a position or height that cannot be drawn, or the file cannot be written.
    """
    path = Path(path)
    if path.suffix not in EXPORTS:
        raise BadInput(f'{path}: expected a name that ends in {", ".join(EXPORTS)}, not in "{path.suffix}"')
    refuse_unsound(mission)
    write_atomically(path, EXPORTS[path.suffix](mission, path.stem))
