"""Refuse a mission with errors, a scenario with unread content, or an unclear start."""

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from ipoa_mission.autopilot.commands import Command
from ipoa_mission.checks.firmware_check import check_version
from ipoa_mission.checks.landings import check_unread
from ipoa_mission.errors import BadInput, MissionError, Unsafe
from ipoa_mission.finding import Finding, Severity
from ipoa_mission.forecast.forecast import Forecast
from ipoa_mission.geodesy import Geodetic, apart
from ipoa_mission.mission.items import LEFT_OUT, Mission, takeoff
from ipoa_mission.mission.program import jump_target

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


def refuse_unread(scenario: "Scenario | None") -> None:
    if scenario is not None and "not-read" not in scenario.safety.ignored:
        refuse_errors([*check_unread(scenario.unread)])


def expect_plannable(scenario: "Scenario") -> None:
    """Raise Unsafe if the version was not measured, or content that may limit the flight was not read."""
    vehicle = scenario.vehicle
    refuse_errors([*check_version(vehicle.autopilot, vehicle.version, vehicle.unmeasured_version)])
    refuse_unread(scenario)


HOME_RADIUS = 1.5  # below the error of satellite positioning [m]


class NotAtStart(MissionError, code="not-at-start"):
    """The vehicle is elsewhere."""


def begun_at(mission: Mission, first: int, there: Geodetic | None = None) -> Mission:
    """Return the mission flown from a place on the ground and item `first`; items keep their numbers.

    Raises:
        BadInput: there is no such item, it has no position, or a jump leads back to before it.
    """
    home = mission.home if there is None else there
    if first == 0:
        return replace(mission, home=home)
    if not 0 < first < len(mission.items):
        raise BadInput(f"expected an item from 1 to {len(mission.items)}, not {first + 1}", place="--from")
    height = mission.altitude_above_home(mission.items[first])
    if not (mission.items[first].has_position and np.isfinite(height)):
        raise BadInput(f"expected an item with a place and a height, and item {first + 1} has none", place="--from")
    for n, item in enumerate(mission.items[first:], first):
        if item.is_jump and (target := jump_target(mission.items, n)) is not None and target < first:
            words = f"cannot begin at item {first + 1}: item {n + 1} jumps back to item {target + 1}"
            raise BadInput(words, place="--from")
    climb = max(height, 2.5)  # [m], at least this from the ground
    beginning = [LEFT_OUT] * (first - 1) + [takeoff(home, climb)]
    changes = [n for n, item in enumerate(mission.items[:first]) if item.command == Command.DO_CHANGE_SPEED]
    if changes and first > 1 and mission.autopilot.command_effects.replays_speed:
        beginning[min(changes[-1], first - 2)] = mission.items[changes[-1]]
    return replace(mission, home=home, items=(*beginning, *mission.items[first:]))


def begun_forecast(forecast: Forecast, first: int, there: Geodetic | None = None) -> Forecast:
    """Return the forecast from a place on the ground and item `first`."""
    mission = forecast.mission_as_read
    if there is None or apart(there, mission.home) <= HOME_RADIUS:
        return forecast if first == 0 else forecast.with_mission(begun_at(mission, first))
    altitude = mission.home.altitude
    scenario = forecast.scenario
    if scenario is not None:
        place = scenario.frame.local(replace(there, altitude=altitude))
        altitude = scenario.frame.home.altitude + float(scenario.airspace.ground(place[None, :])[0])
    return forecast.with_mission(begun_at(mission, first, replace(there, altitude=altitude)))


def check_start(mission: Mission, scenario: "Scenario | None", first: int, there: Geodetic) -> tuple[str, ...]:
    """Return remarks on a vehicle `there` that begins with item `first`; raise NotAtStart if its way is unclear."""
    distance = apart(there, mission.home)
    if distance <= HOME_RADIUS and first == 0:
        return ()
    begun = begun_forecast(Forecast(mission, scenario), first, there)
    where = f"the vehicle is {distance:.1f} m from the mission's home"
    if distance > HOME_RADIUS:
        with suppress(MissionError):
            where += f" ({begun.estimate.total_s:.1f} s are estimated from there)"
    if scenario is None:
        if distance > 10.0:  # [m]
            words = f"{where}; without a scenario the way from there cannot be checked"
            raise NotAtStart(words, hint="bring it there, or plan from its place: `fly SCENARIO` checks the way")
        return (f"{where}: without a scenario the way from there was not checked",)
    from ipoa_mission.checks.world_check import check_airspace, check_clearance

    guarantee = begun.guarantee_if_known
    known = () if guarantee is None else check_clearance(begun.mission, scenario, guarantee)
    errors = [finding for finding in (*check_airspace(begun), *known) if finding.severity is Severity.ERROR]
    if errors:
        words = f"{where}; from there: {errors[0].message}"
        raise NotAtStart(words, hint="bring it to the mission's home, or plan from its place")
    unknown = "the predicted way from there is clear; what clearance flights keep is unknown"
    return (f"{where}: {unknown if guarantee is None else 'the way from there was checked and is clear'}",)
