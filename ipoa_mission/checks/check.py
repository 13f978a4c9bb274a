"""Find the errors and risks of a mission before it flies."""

from collections.abc import Iterable, Iterator
from typing import TYPE_CHECKING

from ipoa_mission.autopilot.mav_types import NO_AIRCRAFT
from ipoa_mission.checks.firmware_check import check_firmware, check_version, is_too_long
from ipoa_mission.checks.positions import check_positions, unsound
from ipoa_mission.checks.sound import sound_part
from ipoa_mission.checks.way import check_way
from ipoa_mission.finding import Finding, Severity
from ipoa_mission.mission.items import Mission
from ipoa_mission.rules import expect_ignorable

if TYPE_CHECKING:
    from ipoa_mission.forecast.deviation.promise import Promise
    from ipoa_mission.forecast.forecast import Forecast
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
    from ipoa_mission.forecast.forecast import Forecast

    return check(Forecast(mission, scenario), ignore)


def check(forecast: "Forecast", ignore: Iterable[str] = (), read: Iterable[Finding] = ()) -> tuple[Finding, ...]:
    """Return the findings; `read` has those of reading the file."""
    mission, scenario = forecast.given, forecast.scenario
    ignored = expect_ignorable(ignore) | (frozenset() if scenario is None else scenario.safety.ignored)
    positions = tuple(check_positions(mission))
    version = check_version(mission.autopilot, mission.firmware_version, mission.unmeasured_version)
    findings = [*read, *version, *check_firmware(mission), *positions]
    if mission.vehicle_type in NO_AIRCRAFT:
        message = f"the mission is for {mission.other_vehicle}, which does not fly: only flights are judged"
        findings.append(Finding("no-aircraft", Severity.ERROR, None, message))
    elif mission.other_vehicle:
        message = f"the mission is for {mission.other_vehicle}: its legs are judged as a multicopter flies them"
        findings.append(Finding("other-vehicle", Severity.WARNING, None, message))
    elsewhere = None if scenario is None else scenario.why_elsewhere(mission.home)
    if elsewhere is not None:
        findings.append(Finding("another-place", Severity.ERROR, 0, str(elsewhere), elsewhere.hint))
    if not unsound(positions) and mission.vehicle_type not in NO_AIRCRAFT:
        findings += check_way(forecast)
    flown = None if elsewhere else sound_part(forecast, positions)
    if flown is not None:
        from ipoa_mission.checks.way import check_passing

        findings += check_passing(flown)
        if flown.mission.fence:
            from ipoa_mission.checks.fence import check_fence

            findings += check_fence(flown)
        if scenario is None and mission.landing_ground is not None:
            from ipoa_mission.checks.ground_check import check_landings

            findings += check_landings(flown)
        if scenario is not None:
            from ipoa_mission.checks.energy_check import check_energy, check_wind
            from ipoa_mission.checks.failsafe_return import check_failsafe_landing, check_failsafe_return

            is_flown = not unsound(positions) and not is_too_long(mission)
            promise = flown.promise_if_known if is_flown else None
            findings += [*_check_world(flown, promise), *(check_wind(flown) if is_flown else ())]
            findings += () if promise is None else check_energy(flown)
            if promise is not None and not any(finding.severity is Severity.ERROR for finding in findings):
                findings += (*check_failsafe_return(flown), *check_failsafe_landing(flown))
    findings = [finding for finding in findings if finding.code not in ignored]
    return tuple(sorted(findings, key=lambda finding: (finding.severity is Severity.WARNING, finding.seq or 0)))


def _check_world(forecast: "Forecast", promise: "Promise | None") -> Iterator[Finding]:
    from ipoa_mission.checks.airspace_check import check_airspace
    from ipoa_mission.checks.clearance import check_clearance, check_passed_over
    from ipoa_mission.checks.ground_check import check_ground
    from ipoa_mission.checks.unread_check import check_unread

    findings = [*check_airspace(forecast)]
    judged = {finding.seq for finding in findings}
    yield from findings
    if promise is not None:
        clearances = check_clearance(forecast.mission, forecast.world, promise)
        yield from (finding for finding in clearances if finding.seq not in judged)
    yield from check_unread(forecast.world.unread)
    yield from check_passed_over(forecast)
    yield from check_ground(forecast)
