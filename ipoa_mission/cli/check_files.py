import math
from collections import Counter
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from ipoa_mission.autopilot.failsafe import Cause, Failsafe
from ipoa_mission.checks.check import check as check_forecast
from ipoa_mission.checks.check import guarantee_if_flown
from ipoa_mission.checks.unsafe import with_strict_vehicle_class
from ipoa_mission.cli.groups import WorldOptions
from ipoa_mission.cli.reading import read_requested
from ipoa_mission.errors import Unreadable
from ipoa_mission.files import MISSIONS
from ipoa_mission.finding import Finding, Severity
from ipoa_mission.forecast.forecast import Forecast
from ipoa_mission.mission.item_words import count_words
from ipoa_mission.options import expect_mission
from ipoa_mission.report.summary import clearance_as_json, findings_as_json, passed_over_as_json
from ipoa_mission.terminal import notes, picked, print_lines, print_table, round_finite
from ipoa_mission.unread import unread_as_json

if TYPE_CHECKING:
    from ipoa_mission.forecast.contingency.contingencies import ContingencyRow
    from ipoa_mission.forecast.deviation.clearance_guarantee import ClearanceGuarantee
    from ipoa_mission.scenario import Scenario
    from ipoa_mission.wind import Wind


def missions_in(paths: Iterable[Path]) -> list[Path]:
    """List the mission files, each once, also of folders."""
    missions: dict[Path, None] = {}
    for path in paths:
        inside = sorted(f for f in path.rglob("*") if f.suffix.lower() in MISSIONS) if path.is_dir() else [path]
        if not inside:
            raise Unreadable("no .plan or .waypoints file in this folder", place=path)
        missions |= dict.fromkeys(map(expect_mission, inside))
    return list(missions)


class CheckedFile(NamedTuple):
    """The findings; without a forecast the file could not be read."""

    file: Path
    findings: tuple[Finding, ...]
    remarks: tuple[str, ...] = ()
    forecast: Forecast | None = None
    guarantee: "ClearanceGuarantee | None" = None
    shows_contingencies: bool = False

    @property
    def errors(self) -> int:
        return sum(finding.severity is Severity.ERROR for finding in self.findings)

    def as_json(self) -> dict[str, Any]:
        result: dict[str, Any] = {"ok": not self.errors, "findings": findings_as_json(self.findings)}
        result["remarks"] = list(self.remarks)
        if self.forecast is None:
            return result
        world = self.forecast.scenario
        if world is not None:
            result["clearance"] = clearance_as_json(self.guarantee) or None
            result["passed_over"] = passed_over_as_json(world)
            result["unread"] = unread_as_json(world.unread)
        if self.shows_contingencies:
            result |= contingencies_as_json(self.forecast, self.guarantee is not None)
        if self.forecast.wind.strongest > 0:
            result["wind"] = self.forecast.wind.as_json()
        mission = self.forecast.mission_as_read
        return result | {"firmware": mission.autopilot.facts(mission.firmware_version)}

    def print(self) -> None:
        print_lines(*self._lines())
        if self.forecast is not None and self.shows_contingencies:
            print_contingencies(self.forecast, self.guarantee is not None)
        print_lines(self._counts())

    def _lines(self) -> Iterator[str]:
        yield from notes(self.remarks)
        if self.forecast is not None and self.forecast.scenario is not None:
            yield from wind_words(self.forecast.wind)
        for finding in self.findings:
            yield f"{finding} [{finding.code}]"
            if finding.hint:
                yield f"hint: {finding.hint}"
        if self.guarantee is not None:
            yield from clearance_words(self.guarantee)

    def _counts(self) -> str:
        if self.forecast is None:
            return f"{self.file}: not checked"
        mission = self.forecast.mission_as_read
        severities = f"{count_words(self.errors, 'error')}, {count_words(len(self.findings) - self.errors, 'warning')}"
        items = count_words(len(mission.items))
        return f"{self.file}: {severities}, {items} for {mission.autopilot.checked_for(mission.firmware_version)}"


def check_file(file: Path, options: WorldOptions, world: "Scenario | None", anyway: bool) -> CheckedFile:
    """`anyway` accepts any class of vehicle."""
    requested = read_requested(file, options.flown_by, world=world)
    forecast = Forecast(requested.mission, world)
    world = forecast.scenario
    findings = with_strict_vehicle_class(check_forecast(forecast, options.ignore or (), requested.findings), anyway)
    guarantee = None if world is None else guarantee_if_flown(forecast)
    messages = {finding.message for finding in findings}
    remarks = tuple(remark for remark in requested.remarks if remark not in messages)
    remarks += () if world is None else tuple(remark for remark in world.remarks if remark not in messages)
    return CheckedFile(file, findings, remarks, forecast, guarantee)


def wind_words(wind: "Wind") -> list[str]:
    return [f"wind {wind}"] if wind.strongest > 0 else []


def clearance_words(guarantee: "ClearanceGuarantee | None") -> list[str]:
    if guarantee is None or guarantee.clearance is None:
        return []
    least = guarantee.clearance
    return [f"least clearance, to {least.to} at item {least.item}: {least.words(guarantee.confidence)}"]


def contingencies_as_json(forecast: Forecast, is_known: bool) -> dict[str, Any]:
    """Return JSON values: meters, seconds from arming, watt hours; unknown values are null."""
    from ipoa_mission.forecast.contingency.contingencies import Contingencies, failsafes_of

    rows = forecast.cached(Contingencies).all_rows() if is_known else ()
    if not rows:
        return {"contingencies": None, "failsafes": None}
    return {"contingencies": [*map(_row, rows)], "failsafes": [*map(_failsafe, failsafes_of(forecast))]}


def _row(row: "ContingencyRow") -> dict[str, Any]:
    lands = row.lands and [round_finite(meters, 2) for meters in row.lands[:2]]
    return {
        "contingency": str(row.contingency),
        **picked(row, "from_s", "to_s", "clear", digits=2),
        "grade": str(row.grade),
        **picked(row, "least_m", "required_m", "to", "goal", digits=2),
        "touches_s": _between(row.touches_s),
        "duration_s": _between(row.duration_s),
        "why_untimed": row.why_untimed or None,
        "energy_wh": _between(row.energy_wh),
        "lands": lands and {"east": lands[0], "north": lands[1]},
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
    from ipoa_mission.forecast.contingency.contingencies import Contingencies, Grade, failsafes_of

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


def _cells(row: "ContingencyRow") -> tuple[str, ...]:
    words = {"clear": "yes", "perhaps not clear": "perhaps", "not clear": "NO"}
    takes = "" if row.duration_s is None else f"{row.duration_s[0]:.0f} to {row.duration_s[1]:.0f}"
    energy = "" if row.energy_wh is None else f"{row.energy_wh[0]:.1f} to {row.energy_wh[1]:.1f}"
    least = f"{row.least_m:.2f}" if math.isfinite(row.least_m) else ""
    grade = (f"{row.from_s:.1f}", f"{row.to_s:.1f}", words.get(row.grade, "?"), least, f"{row.required_m:.2f}")
    return (str(row.contingency), *grade, row.to, row.goal, takes, energy)


def _between(both: tuple[float, float] | None) -> list[float | None] | None:
    return None if both is None else [round_finite(value, 2) for value in both]
