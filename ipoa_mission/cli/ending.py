"""`check --endings`: how each second of a flight can end, and what of a vehicle's parameters decides that."""

import math
from typing import Any

from ipoa_mission.cli.telling import picked, tell, tell_table
from ipoa_mission.forecast.endings import EndingRow
from ipoa_mission.vehicles.failsafe import Failsafe


def endings_as_json(rows: tuple[EndingRow, ...], failsafes: tuple[Failsafe, ...]) -> dict[str, Any]:
    """Both for machines: metres, seconds from arming, watt hours; what nobody knows is null."""
    return {"endings": [_row(row) for row in rows], "failsafes": [_failsafe(one) for one in failsafes]}


def _row(row: EndingRow) -> dict[str, Any]:
    lands = None if row.lands is None else {"east": _rounded(row.lands[0]), "north": _rounded(row.lands[1])}
    times = None if row.duration_s is None else [_rounded(time) for time in row.duration_s]
    return {
        "ending": str(row.ending),
        "from_s": _rounded(row.from_s),
        "to_s": _rounded(row.to_s),
        "clear": row.clear,
        "least_m": _rounded(row.least_m),
        "required_m": _rounded(row.required_m),
        **picked(row, "to", "goal"),
        "duration_s": times,
        "energy_wh": None if row.energy_wh is None else _rounded(row.energy_wh),
        "lands": lands,
    }


def _failsafe(failsafe: Failsafe) -> dict[str, Any]:
    return {
        "cause": failsafe.cause,
        "parameter": failsafe.parameter or None,
        "value": None if math.isnan(failsafe.value) else failsafe.value,
        "ending": str(failsafe.route.ending),
        "otherwise": [str(ending) for ending in failsafe.route.otherwise],
        "words": failsafe.route.words,
    }


def tell_endings(rows: tuple[EndingRow, ...], failsafes: tuple[Failsafe, ...]) -> None:
    """Both as tables."""
    columns = ["ending", "from\ns", "to\ns", "clear", "least\nm", "required\nm", "to", "leads to", "takes\ns"]
    tell_table("how this flight can end, seconds from arming", columns, [_cells(row) for row in rows])
    causes = ["cause", "parameter", "ending"]
    decided = [(one.cause, _setting(one), str(one.route)) for one in failsafes]
    if decided:
        tell_table("what ends it, by the parameters of the mission and the firmware's defaults", causes, decided)
    unclear = sum(not row.clear for row in rows)
    tell("every ending is clear" if not unclear else f"{unclear} of {len(rows)} stretches are not clear")


def _cells(row: EndingRow) -> tuple[str, ...]:
    takes = "" if row.duration_s is None else f"{row.duration_s[0]:.0f} to {row.duration_s[1]:.0f}"
    least = f"{row.least_m:.2f}" if math.isfinite(row.least_m) else ""
    clear = "yes" if row.clear else "NO"
    times = f"{row.from_s:.1f}", f"{row.to_s:.1f}"
    return (str(row.ending), *times, clear, least, f"{row.required_m:.2f}", row.to, row.goal, takes)


def _setting(failsafe: Failsafe) -> str:
    return f"{failsafe.parameter} = {failsafe.value:g}" if failsafe.parameter else ""


def _rounded(value: float) -> float | None:
    return round(value, 2) if math.isfinite(value) else None
