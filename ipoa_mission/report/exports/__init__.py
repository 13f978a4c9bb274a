"""Write a mission in formats of other programs."""

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, TypeAlias

from ipoa_mission.checks.positions import refuse_unsound
from ipoa_mission.errors import WrongSuffix
from ipoa_mission.files import write_atomically
from ipoa_mission.forecast.forecast import Forecast
from ipoa_mission.mission.items import Mission
from ipoa_mission.report.exports.map_formats import to_geojson, to_gpx, to_kml
from ipoa_mission.report.exports.table import to_csv

if TYPE_CHECKING:
    from ipoa_mission.scenario import Scenario

Export: TypeAlias = Callable[[Forecast, str], str]
EXPORTS: dict[str, Export] = {".kml": to_kml, ".geojson": to_geojson, ".csv": to_csv, ".gpx": to_gpx}


def write_export(mission: Mission, path: str | Path, scenario: "Scenario | None" = None) -> None:
    """Write the mission in the format of the suffix; the same mission gives the same bytes.

    Args:
        mission: to write.
        path: ends in a suffix of `EXPORTS`, like `.kml`.
        scenario: gives heights above its ground; a landing goes down to it.

    Raises:
        BadInput: no such format, a position or height that cannot be drawn, or the file cannot be written.

    Example:
        >>> from ipoa_mission import read_mission, write_export
        >>> write_export(read_mission("missions/sitl.plan"), "sitl.kml")
    """
    path = Path(path)
    if path.suffix.lower() not in EXPORTS:
        raise WrongSuffix(f'expected a name that ends in {", ".join(EXPORTS)}, not in "{path.suffix}"', place=path)
    write_atomically(path, forecast_text(Forecast(mission, scenario), path.suffix.lower(), path.stem))


def forecast_text(forecast: Forecast, suffix: str, name: str) -> str:
    """Raise BadInput for an undrawable position or height."""
    refuse_unsound(forecast.given)
    return EXPORTS[suffix](forecast, name)
