"""Refuse a mission with errors, or a scenario with unread content."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

from ipoa_mission.autopilot.commands import Command
from ipoa_mission.checks.firmware_check import check_version
from ipoa_mission.errors import BadInput, Unsafe
from ipoa_mission.finding import Finding, Severity
from ipoa_mission.forecast.forecast import Forecast
from ipoa_mission.unread import Unread

if TYPE_CHECKING:
    from ipoa_mission.scenario import Scenario


def with_strict_vehicle_class(findings: Sequence[Finding], anyway: bool = False) -> tuple[Finding, ...]:
    """Take another class of vehicle for an error unless `anyway`; errors come first."""
    if anyway:
        return tuple(findings)
    harder = [replace(each, severity=Severity.ERROR) if each.code == "other-vehicle" else each for each in findings]
    return tuple(sorted(harder, key=lambda finding: finding.severity is Severity.WARNING))


def unreadable(error: BadInput) -> Finding:
    return Finding("file-unreadable", Severity.ERROR, None, str(error), error.hint)


def refuse_errors(findings: Sequence[Finding]) -> tuple[Finding, ...]:
    """Return the warnings of a check, or raise Unsafe."""
    errors = [finding for finding in with_strict_vehicle_class(findings) if finding.severity is Severity.ERROR]
    if errors:
        codes = list(dict.fromkeys(error.code for error in errors))
        hints = dict.fromkeys(error.hint for error in errors if error.hint)
        words = "\n".join(f"{error.message} [{error.code}]" for error in errors)
        remedies = tuple(dict.fromkeys(remedy for error in errors for remedy in error.remedies))
        raise Unsafe(words, hint="; ".join(hints) or None, remedies=remedies, known={"codes": codes})
    return tuple(findings)


def refuse_unclear_returns(findings: Sequence[Finding], forecast: Forecast) -> None:
    if forecast.world.safety.returns != "planned":
        return
    rtl = {seq for seq, item in enumerate(forecast.mission.items, 1) if item.command == Command.NAV_RETURN_TO_LAUNCH}
    codes = {"return-too-near", "land-too-near"}
    unclear = [each for each in findings if each.code in codes or (each.code == "leg-too-near" and each.seq in rtl)]
    if unclear:
        advice = (*(each.hint for each in unclear), '[safety] returns = "warn", to be warned only')
        hints = dict.fromkeys(filter(None, advice))
        raise Unsafe("\n".join(each.message for each in unclear), hint="; or ".join(hints))


IGNORE_HINT = 'if it limits no flight: --ignore not-read, or [safety] ignore = ["not-read"]'


def check_unread(things: Iterable[Unread]) -> Iterator[Finding]:
    for thing in things:
        if thing.may_limit:
            hint = "; ".join(filter(None, (thing.remedy, IGNORE_HINT)))
            yield Finding("not-read", Severity.ERROR, None, thing.words, hint)


def refuse_unread(scenario: "Scenario | None") -> None:
    """Raise Unsafe if unread content may limit the flight."""
    if scenario is not None and "not-read" not in scenario.safety.ignored:
        refuse_errors([*check_unread(scenario.unread)])


def expect_plannable(scenario: "Scenario") -> None:
    """Raise Unsafe if the version was not measured, or content that may limit the flight was not read."""
    vehicle = scenario.vehicle
    refuse_errors([*check_version(vehicle.autopilot, vehicle.version, vehicle.unmeasured_version)])
    refuse_unread(scenario)
