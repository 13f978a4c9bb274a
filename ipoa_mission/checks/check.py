"""All that can be known to be wrong with a mission before it flies; nothing here repairs anything.

Autopilots accept positions at (0, 0), altitudes that are no number and missions that they cannot fly: whoever sends
one checks first.
"""

from collections.abc import Iterator
from dataclasses import replace
from typing import TYPE_CHECKING

from ipoa_mission.checks.finding import Finding, Severity
from ipoa_mission.checks.firmware import check_firmware, is_too_long
from ipoa_mission.checks.positions import check_positions, refusals
from ipoa_mission.checks.sound import between_sound, sound_part
from ipoa_mission.items import Mission
from ipoa_mission.itinerary.legs import Leg, flown_legs
from ipoa_mission.vehicles.kinds import NO_AIRCRAFT
from ipoa_mission.world.frame import LocalFrame

if TYPE_CHECKING:
    from ipoa_mission.scenario import Scenario
    from ipoa_mission.tube.promise import Promise

__all__ = ["Finding", "Severity", "check_mission"]


def check_mission(
    mission: Mission, scenario: "Scenario | None" = None, promise: "Promise | None" = None
) -> tuple[Finding, ...]:
    """What is wrong with a mission for its autopilot, and with a scenario for that scenario's world.

    The vehicle has the mission's parameters, and those of the scenario that the mission does not name. A leg is looked
    at where the positions at both of its ends are sound. `promise` is what it promises in that world, where that is
    known already. Errors come before warnings, items in their order.
    """
    if scenario is not None and mission.firmware_version is None and mission.autopilot is scenario.vehicle.autopilot:
        mission = replace(mission, firmware_version=scenario.vehicle.version)
    positions = tuple(check_positions(mission))
    findings = [*mission.findings, *check_firmware(mission), *positions]
    if mission.vehicle_type in NO_AIRCRAFT:
        message = f"the mission is for {mission.other_vehicle}, which does not fly: only flights are judged"
        findings.append(Finding(Severity.ERROR, None, message))
    elif mission.other_vehicle:
        message = f"the mission is for {mission.other_vehicle}: its legs are judged as a multicopter flies them"
        findings.append(Finding(Severity.WARNING, None, message))
    elsewhere = None if scenario is None else scenario.why_elsewhere(mission.home)
    if elsewhere is not None:
        findings.append(Finding(Severity.ERROR, 0, str(elsewhere), elsewhere.hint))
    sound = None if elsewhere else sound_part(mission, positions)
    if sound is not None and scenario is None:
        frame = LocalFrame(mission.home)
        findings += _check_fence(sound[0], frame, between_sound(flown_legs(sound[0], frame), sound[1]))
    elif sound is not None and scenario is not None:  # what looks at a world is imported where there is one
        from ipoa_mission.checks.clearance import promise_if_known
        from ipoa_mission.checks.failsafe_return import check_failsafe_return
        from ipoa_mission.tube.flown_in import flown_in

        flown = flown_in(sound[0], scenario)
        if refusals(mission) or is_too_long(mission):
            promise = None
        elif promise is None:
            promise = promise_if_known(flown, scenario)
        findings += _check_world(flown, sound[1], scenario, promise)
        if promise is not None and not any(finding.severity is Severity.ERROR for finding in findings):
            findings += check_failsafe_return(flown, promise.flight)
    return tuple(sorted(findings, key=lambda finding: (finding.severity is Severity.WARNING, finding.seq or 0)))


def _check_world(
    mission: Mission, left_out: frozenset[int], scenario: "Scenario", promise: "Promise | None"
) -> Iterator[Finding]:
    """Findings about the legs in a scenario's world, those at items that are left out apart."""
    from ipoa_mission.checks.airspace import check_airspace
    from ipoa_mission.checks.clearance import check_clearance
    from ipoa_mission.checks.ground import check_ground
    from ipoa_mission.checks.passed_over import check_passed_over

    legs = between_sound(flown_legs(mission, scenario.frame, scenario.airspace.ground), left_out)
    findings = [*_check_fence(mission, scenario.frame, legs), *check_airspace(mission, scenario, legs)]
    judged = {finding.seq for finding in findings}
    yield from findings
    yield from (finding for finding in check_clearance(mission, scenario, promise) if finding.seq not in judged)
    yield from check_passed_over(mission, scenario, legs)
    yield from check_ground(mission, scenario, legs)


def _check_fence(mission: Mission, frame: LocalFrame, legs: tuple[Leg, ...]) -> Iterator[Finding]:
    if mission.fence:
        from ipoa_mission.checks.fence import check_fence

        yield from check_fence(mission, frame, legs)
