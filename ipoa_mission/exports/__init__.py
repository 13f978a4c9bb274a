"""Missions for other people's programs: KML, GeoJSON, CSV and GPX, chosen by the suffix."""

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from ipoa_mission.checks.positions import refuse_unsound
from ipoa_mission.errors import BadInput
from ipoa_mission.exports.comma_separated import to_csv
from ipoa_mission.exports.geojson import to_geojson
from ipoa_mission.exports.gpx import to_gpx
from ipoa_mission.exports.kml import to_kml
from ipoa_mission.files import write_atomically
from ipoa_mission.items import Mission

if TYPE_CHECKING:
    from ipoa_mission.scenario import Scenario

#: Suffix -> the mission, under a name, in the world of a scenario where there is one, as the text of such a file.
EXPORTS: "dict[str, Callable[[Mission, str, Scenario | None], str]]" = {
    ".kml": to_kml,
    ".geojson": to_geojson,
    ".csv": to_csv,
    ".gpx": to_gpx,
}


def write_export(mission: Mission, path: str | Path, scenario: "Scenario | None" = None) -> None:
    """Write the mission in the format of the suffix, named as the file; the same mission gives the same bytes.

    With a scenario, heights above its ground are known, and a landing goes down to it.

    Raises:
        BadInput: no such format, a position or height that cannot be drawn, or the file cannot be written.
    """
    path = Path(path)
    if path.suffix.lower() not in EXPORTS:
        raise BadInput(f'{path}: expected a name that ends in {", ".join(EXPORTS)}, not in "{path.suffix}"')
    write_atomically(path, export_text(mission, path.suffix.lower(), path.stem, scenario))


def export_text(mission: Mission, suffix: str, name: str, scenario: "Scenario | None" = None) -> str:
    """The text of such a file.

    Raises:
        BadInput: a position or height that cannot be drawn.
    """
    refuse_unsound(mission)
    return EXPORTS[suffix](mission, name, scenario)
