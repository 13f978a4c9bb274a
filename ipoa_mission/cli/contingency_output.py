import math
from collections import Counter
from collections.abc import Iterator
from typing import Any

from ipoa_mission.autopilot.failsafe import Failsafe
from ipoa_mission.forecast.contingency.contingencies import ContingencyRow, Grade
from ipoa_mission.forecast.contingency.contingencies_now import ContingenciesNow
from ipoa_mission.forecast.contingency.energy_budget import ReserveNow, budget_of
from ipoa_mission.forecast.forecast import Forecast
from ipoa_mission.geodesy import Geodetic
from ipoa_mission.link.messages import Message, Position
from ipoa_mission.link.vehicle import Vehicle
from ipoa_mission.progress import Progress
from ipoa_mission.terminal import picked, print_lines, print_table

CELL = {Grade.CLEAR: "yes", Grade.POSSIBLY_UNCLEAR: "perhaps", Grade.UNCLEAR: "NO", Grade.UNKNOWN: "?"}


def contingencies_as_json(rows: tuple[ContingencyRow, ...], failsafes: tuple[Failsafe, ...]) -> dict[str, Any]:
    """Return JSON values: meters, seconds from arming, watt hours; unknown values are null."""
    if not rows:
        return {"contingencies": None, "failsafes": None}
    return {"contingencies": [_row(row) for row in rows], "failsafes": [_failsafe(failsafe) for failsafe in failsafes]}


def _row(row: ContingencyRow) -> dict[str, Any]:
    lands = None if row.lands is None else {"east": _rounded(row.lands[0]), "north": _rounded(row.lands[1])}
    return {
        "contingency": str(row.contingency),
        "from_s": _rounded(row.from_s),
        "to_s": _rounded(row.to_s),
        "clear": row.clear,
        "grade": str(row.grade),
        "least_m": _rounded(row.least_m),
        "required_m": _rounded(row.required_m),
        **picked(row, "to", "goal"),
        "touches_s": _between(row.touches_s),
        "duration_s": _between(row.duration_s),
        "why_untimed": row.why_untimed or None,
        "energy_wh": _between(row.energy_wh),
        "lands": lands,
    } | ({"remarks": list(row.remarks)} if row.remarks else {})


def _failsafe(failsafe: Failsafe) -> dict[str, Any]:
    return {
        "cause": failsafe.cause,
        "parameter": failsafe.parameter or None,
        "value": None if math.isnan(failsafe.value) else failsafe.value,
        "contingency": str(failsafe.action.contingency),
        "otherwise": [str(contingency) for contingency in failsafe.action.otherwise],
        "words": failsafe.action.words,
    }


def print_contingencies(rows: tuple[ContingencyRow, ...], failsafes: tuple[Failsafe, ...]) -> None:
    if not rows:
        print_lines("contingencies: unknown, because the flight is unknown")
        return
    columns = ["contingency", "from\ns", "to\ns", "clear", "least\nm", "required\nm", "to", "leads to"]
    columns += ["takes\ns", "takes\nWh"]
    print_table("contingencies, seconds from arming", columns, [_cells(row) for row in rows])
    print_lines(*dict.fromkeys(f"no time of {row.contingency}: {row.why_untimed}" for row in rows if row.why_untimed))
    print_lines(*dict.fromkeys(f"{row.contingency}: {remark}" for row in rows for remark in row.remarks))
    causes = ["cause", "parameter", "contingency"]
    decided = [(f.cause, f"{f.parameter} = {f.value:g}" if f.parameter else "", str(f.action)) for f in failsafes]
    if decided:
        print_table("failsafes, by the mission's parameters and the firmware's defaults", causes, decided)
    many, grades = len(rows), Counter(row.grade for row in rows)
    unclear = [f"{grades[grade]} of {many} stretches are {grade}" for grade in tuple(Grade)[1:] if grades[grade]]
    print_lines("; ".join(unclear) or "every contingency is clear")


def _cells(row: ContingencyRow) -> tuple[str, ...]:
    takes = "" if row.duration_s is None else f"{row.duration_s[0]:.0f} to {row.duration_s[1]:.0f}"
    energy = "" if row.energy_wh is None else f"{row.energy_wh[0]:.1f} to {row.energy_wh[1]:.1f}"
    least = f"{row.least_m:.2f}" if math.isfinite(row.least_m) else ""
    clear = CELL[row.grade]
    times = f"{row.from_s:.1f}", f"{row.to_s:.1f}"
    return (str(row.contingency), *times, clear, least, f"{row.required_m:.2f}", row.to, row.goal, takes, energy)


def _between(both: tuple[float, float] | None) -> list[float | None] | None:
    return None if both is None else [*map(_rounded, both)]


def _rounded(value: float) -> float | None:
    return round(value, 2) if math.isfinite(value) else None


class ContingencyDisplay:
    """Show contingencies by position; append to `reserves` when the battery's share changes."""

    def __init__(
        self,
        forecast: Forecast,
        vehicle: Vehicle,
        show: Progress,
        reserves: list[ReserveNow],
        contingencies: ContingenciesNow,
    ) -> None:
        self._now, self._frame, self._vehicle, self._show = contingencies, forecast.frame, vehicle, show
        self._done, self._words, self._shown_s = 0.0, "", -math.inf
        self._budget, self._reserves = budget_of(forecast), reserves

    def show(self, share: float, words: str) -> None:
        self._done, self._words = share, words
        self._show(share, words)

    def hear(self, message: Message) -> None:
        interval_s = 1.0
        if not isinstance(message, Position) or message.time_s - self._shown_s < interval_s:
            return
        path = self._vehicle.record().path
        if path and self._vehicle.state.in_air:
            self._shown_s = message.time_s
            place = self._frame.local(Geodetic(message.latitude_deg, message.longitude_deg, message.altitude))
            time, away = self._now.time_at(place, path[-1].time_s)
            off = "off its path: not forecast from here"
            words = [off if away > self._now.off_path else self._now.words(time), *map(str, self._reserve(time))]
            self._show(self._done, f"{self._words}  now: {'; '.join(words)}")

    def _reserve(self, time: float) -> Iterator[ReserveNow]:
        left = self._vehicle.state.battery_left
        if self._budget is None or left is None:
            return
        if (now := self._budget.against_plan(left, time)) is not None:
            if not self._reserves or self._reserves[-1].left != now.left:
                self._reserves.append(now)
            yield now
