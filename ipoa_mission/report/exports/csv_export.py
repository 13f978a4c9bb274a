"""CSV (RFC 4180, but LF), one item a line, units in the column names."""

import csv
import io

from ipoa_mission.forecast.forecast import Forecast
from ipoa_mission.report.exports.table import Row, rows_of

COLUMNS = {
    "seq": ("seq", None),
    "command": ("command", None),
    "latitude_deg": ("latitude_deg", 9),
    "longitude_deg": ("longitude_deg", 9),
    "altitude_amsl_m": ("altitude_amsl", 3),
    "height_above_home_m": ("height", 3),
    "height_above_ground_m": ("height_above_ground", 3),
    "leg_m": ("length", 2),
    "heading_deg": ("heading_deg", 1),
    "climb_m": ("climb", 2),
    "hold_s": ("hold_s", 1),
    "speed_m_s": ("speed", 2),
    "detail": ("detail", None),
    "passes": ("passes", None),
}


def to_csv(forecast: Forecast, name: str) -> str:
    """`name` is unused."""
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(COLUMNS)
    writer.writerows([_cell(row, *column) for column in COLUMNS.values()] for row in rows_of(forecast))
    return out.getvalue()


def _cell(row: Row, attribute: str, decimals: int | None) -> str:
    value = getattr(row, attribute)
    if value is None or decimals is None:
        return "" if value is None else str(value)
    return f"{value:.{decimals}f}"
