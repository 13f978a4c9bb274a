from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

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
from ipoa_mission.terminal import notes, print_lines
from ipoa_mission.unread import unread_as_json

if TYPE_CHECKING:
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
            from ipoa_mission.cli.contingency_output import contingencies_as_json

            result |= contingencies_as_json(self.forecast, self.guarantee is not None)
        if self.forecast.wind.strongest > 0:
            result["wind"] = self.forecast.wind.as_json()
        mission = self.forecast.mission_as_read
        return result | {"firmware": mission.autopilot.facts(mission.firmware_version)}

    def print(self) -> None:
        print_lines(*self._lines())
        if self.forecast is not None and self.shows_contingencies:
            from ipoa_mission.cli.contingency_output import print_contingencies

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
