"""A firmware whose flights were not measured: nothing is planned for it, checked clear or sent to it unasked."""

from collections.abc import Iterator
from dataclasses import replace
from typing import TYPE_CHECKING

from ipoa_mission.checks.unsafe import refuse_errors
from ipoa_mission.finding import Finding, Severity
from ipoa_mission.mission.items import Mission
from ipoa_mission.vehicles.autopilot import Autopilot
from ipoa_mission.vehicles.version import Version

if TYPE_CHECKING:
    from ipoa_mission.scenario import Scenario

NOT_MEASURED = "version-not-measured"
HINT = (
    "fly it in simulation first (docs/lab/flown.md), or go on with --unmeasured-version "
    "(in a scenario vehicle.unmeasured_version = true)"
)


def check_version(autopilot: Autopilot, version: Version | None, unmeasured: bool) -> Iterator[Finding]:
    """An error where flights of the version were not measured; a warning where an `unmeasured` one is asked for."""
    if (why := autopilot.not_measured(version)) is not None:
        yield _finding(why, unmeasured)


def expect_measured(scenario: "Scenario") -> None:
    """Refuse to plan for a version that was not measured.

    Raises:
        Unsafe: the scenario names one, and does not ask for it as such.
    """
    vehicle = scenario.vehicle
    refuse_errors(tuple(check_version(vehicle.autopilot, vehicle.version, vehicle.unmeasured_version)))


def check_aboard(mission: Mission, autopilot: Autopilot, said: Version | None) -> tuple[Mission, tuple[Finding, ...]]:
    """The mission as a vehicle meets it that says this version, and a finding where it says none and nobody names one.

    A vehicle that says nothing is taken for the version that the mission names.
    """
    aboard = replace(mission, autopilot=autopilot, firmware_version=said or mission.firmware_version)
    if aboard.firmware_version is not None:
        return aboard, ()
    taken = autopilot.checked_for(None)
    why = f"the vehicle does not say its version: nobody knows whether it was measured; it is taken for {taken}"
    return aboard, (_finding(why, mission.unmeasured_version),)


def _finding(why: str, unmeasured: bool) -> Finding:
    severity = Severity.WARNING if unmeasured else Severity.ERROR
    return Finding("version-not-measured", severity, None, why, None if unmeasured else HINT)
