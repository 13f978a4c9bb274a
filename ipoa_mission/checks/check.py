import math
from collections.abc import Iterable
from dataclasses import replace
from typing import TYPE_CHECKING

import ipoa_mission.checks.firmware_check as firmware
from ipoa_mission.autopilot.autopilot import NO_AIRCRAFT
from ipoa_mission.checks.landings import check_landings
from ipoa_mission.finding import Finding, Severity
from ipoa_mission.forecast.forecast import Forecast
from ipoa_mission.mission.items import LEFT_OUT, Mission
from ipoa_mission.mission.positions import check_positions, refusals, unsound
from ipoa_mission.rules import expect_ignorable

if TYPE_CHECKING:
    from ipoa_mission.forecast.deviation.clearance_guarantee import ClearanceGuarantee
    from ipoa_mission.scenario import Scenario


def check_mission(
    mission: Mission, scenario: "Scenario | None" = None, ignore: Iterable[str] = ()
) -> tuple[Finding, ...]:
    """Return the findings on a mission for its autopilot and, with a scenario, in the scenario's world.

    Args:
        mission: the mission to check.
        scenario: its world; without one: format, firmware, fence.
        ignore: codes of findings to leave out, in addition to those that the scenario ignores.

    Returns:
        Errors before warnings, items in their order.

    Raises:
        BadInput: a code in `ignore` is unknown, or a crash may follow from its finding; the mission is of another
            place than the scenario.

    Example:
        >>> from ipoa_mission import check_mission, read_mission, read_scenario
        >>> low = read_mission("missions/sitl.plan").with_parameters({"RTL_RETURN_ALT": 30.0})  # the mast is higher
        >>> for finding in check_mission(low, read_scenario("missions/sitl.toml")):
        ...     print(finding.severity, finding.code, finding.seq)
        warning return-too-near 4
    """
    return check(Forecast(mission, scenario), ignore)


def check(forecast: Forecast, ignore: Iterable[str] = (), read: Iterable[Finding] = ()) -> tuple[Finding, ...]:
    """Return the findings; `read` has those of reading the file."""
    mission = forecast.mission_as_read
    scenario = forecast.scenario
    ignored = expect_ignorable(ignore) | (frozenset() if scenario is None else scenario.safety.ignored)
    positions = tuple(check_positions(mission))
    version = firmware.check_version(mission.autopilot, mission.firmware_version, mission.unmeasured_version)
    findings = [*read, *version, *firmware.check_firmware(mission), *positions]
    if mission.vehicle_type in NO_AIRCRAFT:
        message = f"the mission is for {mission.other_vehicle}, which does not fly: only flights are judged"
        findings.append(Finding("no-aircraft", Severity.ERROR, None, message))
    elif mission.other_vehicle:
        message = f"the mission is for {mission.other_vehicle}: its legs are judged as a multicopter flies them"
        findings.append(Finding("other-vehicle", Severity.WARNING, None, message))
    elsewhere = None if scenario is None else scenario.why_elsewhere(mission.home)
    if elsewhere is not None:
        findings.append(Finding("another-place", Severity.ERROR, 0, str(elsewhere), elsewhere.hint))
    is_sound = not unsound(positions)
    if is_sound and mission.vehicle_type not in NO_AIRCRAFT:
        findings += firmware.check_known_path(forecast)

    flown = None if elsewhere else sound_part(forecast, positions)
    if flown is not None:
        findings += firmware.check_passing(flown)
        if flown.mission.fence:
            from ipoa_mission.checks.fence import check_fence

            findings += check_fence(flown)
        if scenario is not None:
            from ipoa_mission.checks.world_check import check_world

            findings += check_world(flown, is_sound and not firmware.is_too_long(mission), findings)
        elif mission.landing_ground is not None:
            findings += check_landings(flown)
    findings = [finding for finding in findings if finding.code not in ignored]
    return tuple(sorted(findings, key=lambda finding: (finding.severity is Severity.WARNING, finding.seq or 0)))


def sound_part(forecast: Forecast, positions: Iterable[Finding]) -> Forecast | None:
    """Return the flight without wrong items, None if home is wrong; a take-off without a place is one from home."""
    mission = forecast.mission_as_read
    wrong = {finding.seq for finding in unsound(positions)}
    if 0 in wrong:
        return None
    if not wrong:
        return forecast
    if None in wrong:  # the fence, or a rally point
        mission = replace(mission, fence=(), rally=())
    left_out: set[int] = set()
    items = list(mission.items)
    for seq in wrong - {None}:
        assert seq is not None
        item = items[seq - 1]
        if item.is_takeoff and not item.has_position and 0 < mission.altitude_above_home(item) < math.inf:
            home = mission.home
            items[seq - 1] = replace(item, latitude_deg=home.latitude_deg, longitude_deg=home.longitude_deg)
        else:
            items[seq - 1] = LEFT_OUT
            left_out.add(seq)
    return forecast.with_mission(replace(mission, items=tuple(items)), frozenset(left_out))


def guarantee_if_flown(forecast: Forecast) -> "ClearanceGuarantee | None":
    mission = forecast.mission_as_read
    return None if refusals(mission) or firmware.is_too_long(mission) else forecast.guarantee_if_known
