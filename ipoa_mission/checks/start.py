"""Check a flight that begins away from home, or later."""

import math
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from ipoa_mission.autopilot.commands import JUMPS
from ipoa_mission.errors import BadInput, MissionError
from ipoa_mission.finding import Severity
from ipoa_mission.forecast.forecast import Forecast
from ipoa_mission.geodesy import Geodetic, apart
from ipoa_mission.mission.items import LEFT_OUT, Mission, takeoff
from ipoa_mission.mission.program import jump_target

if TYPE_CHECKING:
    from ipoa_mission.scenario import Scenario

HOME_RADIUS = 1.5  # below the error of satellite positioning [m]


class NotAtStart(MissionError):
    """The flight may not begin where the vehicle is."""


def begun_at(mission: Mission, first: int, there: Geodetic | None = None) -> Mission:
    """Return the mission as flown from a place on the ground, from item `first`; items keep their numbers.

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
        if item.command in JUMPS and (target := jump_target(mission.items, n)) is not None and target < first:
            words = f"cannot begin at item {first + 1}: item {n + 1} jumps back to item {target + 1}"
            raise BadInput(words, place="--from")
    climb = max(height, 2.5)  # [m], at least this from the ground
    beginning = (LEFT_OUT,) * (first - 1) + (takeoff(home, climb),)
    return replace(mission, home=home, items=beginning + mission.items[first:])


def check_start(mission: Mission, scenario: "Scenario | None", first: int, there: Geodetic) -> tuple[str, ...]:
    """Return remarks on a vehicle `there` that begins with item `first`.

    Raises:
        NotAtStart: the way from there is not clear, or unknown and far from home; or another start place is nearer.
    """
    distance = apart(there, mission.home)
    if distance <= HOME_RADIUS and first == 0:
        return ()
    where = f"the vehicle is {distance:.1f} m from the mission's home"
    if scenario is None:
        if distance > 10.0:  # [m]
            raise NotAtStart(
                f"{where}; without a scenario the way from there cannot be checked",
                hint="bring it there, or plan from its place: `fly SCENARIO` checks the way",
            )
        return (f"{where}: without a scenario the way from there was not checked",)
    from ipoa_mission.checks.world_check import check_airspace

    frame = scenario.frame
    place = frame.local(Geodetic(there.latitude_deg, there.longitude_deg, mission.home.altitude))
    starts = ((name, start) for name, section in scenario.added.items() for start in section.start_places)
    for name, start in starts:
        if math.hypot(*start) <= HOME_RADIUS or math.dist(place[:2], start) >= np.hypot(*place[:2]):
            continue
        raise NotAtStart(
            f"{where}, and nearer to another of the {name}'s start places",
            hint=f"bring it to {mission.home.latitude_deg:.6f}, {mission.home.longitude_deg:.6f}, or fly the flight "
            "that begins there",
        )
    ground = float(scenario.airspace.ground(place[None, :])[0])
    home = Geodetic(there.latitude_deg, there.longitude_deg, mission.home.altitude + ground)
    begun = Forecast(begun_at(mission, first, home), scenario)
    errors = [finding for finding in check_airspace(begun) if finding.severity is Severity.ERROR]
    if errors:
        words = f"{where}; from there: {errors[0].message}"
        raise NotAtStart(words, hint="bring it to the mission's home, or plan from its place")
    return (f"{where}: the way from there was checked and is clear",)
