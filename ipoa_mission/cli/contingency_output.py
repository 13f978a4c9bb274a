import math
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from ipoa_mission.autopilot.failsafe import Cause, Failsafe
from ipoa_mission.forecast.contingency.contingencies import Contingencies, ContingencyRow, Grade, failsafes_of
from ipoa_mission.forecast.contingency.contingencies_now import ContingenciesNow
from ipoa_mission.forecast.contingency.energy_budget import ReserveNow, budget_of
from ipoa_mission.forecast.forecast import Forecast
from ipoa_mission.geodesy import Geodetic
from ipoa_mission.link.messages import Message, Position
from ipoa_mission.link.vehicle import Vehicle
from ipoa_mission.progress import Progress
from ipoa_mission.terminal import picked, print_lines, print_table, round_finite

CELL = {Grade.CLEAR: "yes", Grade.POSSIBLY_UNCLEAR: "perhaps", Grade.UNCLEAR: "NO", Grade.UNKNOWN: "?"}


def contingencies_as_json(forecast: Forecast, is_known: bool) -> dict[str, Any]:
    """Return JSON values: meters, seconds from arming, watt hours; unknown values are null."""
    rows = forecast.cached(Contingencies).all_rows() if is_known else ()
    if not rows:
        return {"contingencies": None, "failsafes": None}
    failsafes = [_failsafe(failsafe) for failsafe in failsafes_of(forecast)]
    return {"contingencies": [_row(row) for row in rows], "failsafes": failsafes}


def _row(row: ContingencyRow) -> dict[str, Any]:
    lands = None
    if row.lands is not None:
        lands = {"east": round_finite(row.lands[0], 2), "north": round_finite(row.lands[1], 2)}
    return {
        "contingency": str(row.contingency),
        **picked(row, "from_s", "to_s", "clear", digits=2),
        "grade": str(row.grade),
        **picked(row, "least_m", "required_m", "to", "goal", digits=2),
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
        "otherwise": [str(contingency) for contingency in failsafe.action.fallbacks],
        "words": failsafe.action.words,
    }


def print_contingencies(forecast: Forecast, is_known: bool) -> None:
    rows = forecast.cached(Contingencies).all_rows() if is_known else ()
    if not rows:
        print_lines("contingencies: unknown, because the flight is unknown")
        return

    columns = ["contingency", "from\ns", "to\ns", "clear", "least\nm", "required\nm", "to", "leads to"]
    columns += ["takes\ns", "takes\nWh"]
    print_table("contingencies, seconds from arming", columns, [_cells(row) for row in rows])
    print_lines(*dict.fromkeys(f"no time of {row.contingency}: {row.why_untimed}" for row in rows if row.why_untimed))
    print_lines(*dict.fromkeys(f"{row.contingency}: {remark}" for row in rows for remark in row.remarks))

    failsafes = [
        (
            "pilot or ground station" if failsafe.cause == Cause.BY_HAND else failsafe.cause,
            f"{failsafe.parameter} = {failsafe.value:g}" if failsafe.parameter else "",
            str(failsafe.action),
        )
        for failsafe in failsafes_of(forecast)
    ]
    if failsafes:
        title = "failsafes, by the mission's parameters and the firmware's defaults"
        print_table(title, ["cause", "parameter", "contingency"], failsafes)

    grades = Counter(row.grade for row in rows)
    unclear = [f"{grades[grade]} of {len(rows)} stretches are {grade}" for grade in tuple(Grade)[1:] if grades[grade]]
    print_lines("; ".join(unclear) or "every contingency is clear")


def _cells(row: ContingencyRow) -> tuple[str, ...]:
    takes = "" if row.duration_s is None else f"{row.duration_s[0]:.0f} to {row.duration_s[1]:.0f}"
    energy = "" if row.energy_wh is None else f"{row.energy_wh[0]:.1f} to {row.energy_wh[1]:.1f}"
    least = f"{row.least_m:.2f}" if math.isfinite(row.least_m) else ""
    clear = CELL[row.grade]
    times = f"{row.from_s:.1f}", f"{row.to_s:.1f}"
    return (str(row.contingency), *times, clear, least, f"{row.required_m:.2f}", row.to, row.goal, takes, energy)


def _between(both: tuple[float, float] | None) -> list[float | None] | None:
    return None if both is None else [round_finite(value, 2) for value in both]


@dataclass
class ContingencyDisplay:
    """Show contingencies by position; append to `reserves` when the battery's share changes."""

    forecast: Forecast
    vehicle: Vehicle
    progress: Progress
    reserves: list[ReserveNow]
    contingencies: ContingenciesNow
    _shown: tuple[float, str] = (0.0, "")
    _shown_s: float = -math.inf

    def show(self, share: float, words: str) -> None:
        self._shown = (share, words)
        self.progress(share, words)

    def hear(self, message: Message) -> None:
        if not isinstance(message, Position) or message.time_s - self._shown_s < 1.0:
            return
        path = self.vehicle.record().path
        if path and self.vehicle.state.in_air:
            self._shown_s = message.time_s
            place = self.forecast.frame.local(Geodetic(message.latitude_deg, message.longitude_deg, message.altitude))
            time, distance = self.contingencies.time_at(place, path[-1].time_s)
            words = "off its path: not forecast from here"
            if distance <= self.contingencies.off_path:
                words = self.contingencies.words(time)
            now = "; ".join([words, *map(str, self._reserve(time))])
            share, stage = self._shown
            self.progress(share, f"{stage}  now: {now}")

    def _reserve(self, time: float) -> Iterator[ReserveNow]:
        left = self.vehicle.state.battery_left
        budget = budget_of(self.forecast)
        reserve = None if budget is None or left is None else budget.against_plan(left, time)
        if reserve is None:
            return
        if not self.reserves or self.reserves[-1].left != reserve.left:
            self.reserves.append(reserve)
        yield reserve
