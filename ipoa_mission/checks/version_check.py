"""Check that flights of a firmware version were measured."""

from collections.abc import Iterator
from dataclasses import replace
from typing import TYPE_CHECKING

from ipoa_mission.autopilot.autopilot import Autopilot
from ipoa_mission.autopilot.version import Version
from ipoa_mission.checks.unsafe import refuse_errors
from ipoa_mission.finding import Finding, Severity
from ipoa_mission.mission.items import Mission

if TYPE_CHECKING:
    from ipoa_mission.scenario import Scenario

NOT_MEASURED = "version-not-measured"
MEASURE_HINT = (
    "fly it in simulation first (docs/lab/flown.md), or go on with --unmeasured-version "
    "(in a scenario vehicle.unmeasured_version = true)"
)


def check_version(autopilot: Autopilot, version: Version | None, unmeasured: bool) -> Iterator[Finding]:
    """Report a version that was not measured, as an error unless `unmeasured`."""
    if (why := autopilot.not_measured(version)) is not None:
        yield _finding(why, unmeasured)


def expect_measured(scenario: "Scenario") -> None:
    """Raise Unsafe if the version was not measured, and not requested by `unmeasured_version`."""
    vehicle = scenario.vehicle
    refuse_errors(tuple(check_version(vehicle.autopilot, vehicle.version, vehicle.unmeasured_version)))


def check_aboard(
    mission: Mission, autopilot: Autopilot, reported: Version | None
) -> tuple[Mission, tuple[Finding, ...]]:
    """Return the mission with the reported version, and a finding if none is known."""
    aboard = replace(mission, autopilot=autopilot, firmware_version=reported or mission.firmware_version)
    if aboard.firmware_version is not None:
        return aboard, ()
    taken = autopilot.checked_for(None)
    why = f"the vehicle does not report its version: whether it was measured is unknown; {taken} is assumed"
    return aboard, (_finding(why, mission.unmeasured_version),)


def _finding(why: str, unmeasured: bool) -> Finding:
    severity = Severity.WARNING if unmeasured else Severity.ERROR
    return Finding("version-not-measured", severity, None, why, None if unmeasured else MEASURE_HINT)
