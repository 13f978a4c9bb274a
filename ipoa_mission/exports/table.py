"""A mission as a table: for each item where it lies and the leg that leads to it."""

import math
from collections import Counter, defaultdict
from collections.abc import Iterable, Iterator
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from ipoa_mission.checks.positions import refusals
from ipoa_mission.commands import Command, Frame, command_name, plain_frame
from ipoa_mission.errors import BadInput
from ipoa_mission.exports.track import in_world
from ipoa_mission.geometry import leg_lengths
from ipoa_mission.items import Item, Mission
from ipoa_mission.itinerary.itinerary import itinerary
from ipoa_mission.itinerary.legs import Leg, flown_legs
from ipoa_mission.world.frame import Geodetic

if TYPE_CHECKING:
    from ipoa_mission.scenario import Scenario

LANDINGS = frozenset({Command.NAV_LAND, Command.NAV_VTOL_LAND})
LEAST_LEVEL = 0.5  # [m] below which a leg has no heading


@dataclass(frozen=True)
class Row:
    """One line of the table; what an item has none of is None. `seq` 0 is home. Lengths in metres.

    `length` and `climb` are of the whole way from the item before (for a return: home and down to the ground);
    `heading_deg` is clockwise from north, of its last level part.
    """

    seq: int
    command: str
    latitude_deg: float | None = None
    longitude_deg: float | None = None
    altitude_amsl: float | None = None
    height: float | None = None  # above home
    height_above_ground: float | None = None  # where the terrain is known, or the item says so
    length: float | None = None
    heading_deg: float | None = None
    climb: float | None = None
    hold_s: float | None = None
    speed: float | None = None  # [m/s] that it changes to
    detail: str = ""


def shown(value: float | None, form: str = "z.1f") -> str:
    """A number of the table for reading; nothing for what an item has none of."""
    return "" if value is None else format(value, form)


def mission_table(mission: Mission, scenario: "Scenario | None" = None) -> tuple[Row, ...]:
    """Home and every item; with a scenario, heights above its ground too.

    Where a position or height makes no sense no item has a leg: `refusals` says why.
    """
    mission, frame, ground = in_world(mission, scenario)
    legs: dict[int, list[Leg]] = defaultdict(list)
    for leg in flown_legs(mission, frame, ground) if not refusals(mission) else ():
        if not leg.alternative:
            legs[leg.seq].append(leg)
    home = Row(0, "home", mission.home.latitude_deg, mission.home.longitude_deg, mission.home.altitude, 0.0)
    items = (_row(seq, item, mission, legs[seq], scenario) for seq, item in enumerate(mission.items, start=1))
    return (home, *_repeated(items, mission))


def _repeated(rows: Iterable[Row], mission: Mission) -> Iterator[Row]:
    """The rows; of an item to which a jump leads again it is said which of its passes stands there."""
    jumps = any(item.command == Command.DO_JUMP for item in mission.items)
    passes = Counter[int]()
    if jumps and not refusals(mission):
        with suppress(BadInput):  # a jump without end
            passes.update(visit.seq for visit in itinerary(mission).visits)
    for row in rows:
        if passes[row.seq] > 1 and row.length is not None:
            words = f"leg of the first of {passes[row.seq]} passes, done with the last"
            yield replace(row, detail=", ".join(filter(None, (row.detail, words))))
        else:
            yield row


def _row(seq: int, item: Item, mission: Mission, legs: list[Leg], scenario: "Scenario | None") -> Row:
    placed = item.command in mission.autopilot.firmware().placed and item.frame != Frame.MISSION
    on_map = placed and (item.latitude_deg, item.longitude_deg) != (0.0, 0.0)
    height = mission.altitude_above_home(item) if placed else math.nan
    points = np.vstack([leg.points for leg in legs]) if legs else None
    if scenario is not None and points is not None and item.command in LANDINGS:  # down to the ground there
        height = scenario.frame.geodetic(points[-1]).altitude - mission.home.altitude
    return Row(
        seq=seq,
        command=command_name(item.command),
        latitude_deg=item.latitude_deg if on_map else None,
        longitude_deg=item.longitude_deg if on_map else None,
        altitude_amsl=_known(mission.home.altitude + height),
        height=_known(height),
        height_above_ground=_above_ground(item, mission, height, scenario) if on_map else None,
        length=None if points is None else float(leg_lengths(points).sum()),
        heading_deg=_heading(legs),
        climb=None if points is None else float(points[-1, 2] - points[0, 2]),
        hold_s=_hold(item),
        speed=item.params[1] if item.command == Command.DO_CHANGE_SPEED else None,
        detail=_detail(item),
    )


def _known(value: float) -> float | None:
    return value if math.isfinite(value) else None


def _above_ground(item: Item, mission: Mission, height: float, scenario: "Scenario | None") -> float | None:
    if plain_frame(item.frame) == Frame.GLOBAL_TERRAIN_ALT:
        return item.altitude
    if scenario is None or not math.isfinite(height):
        return None
    place = Geodetic(item.latitude_deg, item.longitude_deg, mission.home.altitude + height)
    point = scenario.frame.local(place)
    return float(point[2] - scenario.airspace.ground(point[None, :])[0])


def _heading(legs: list[Leg]) -> float | None:
    for leg in reversed(legs):
        for step in np.diff(leg.points, axis=0)[::-1]:
            if np.hypot(step[0], step[1]) > LEAST_LEVEL:
                return float(np.degrees(np.arctan2(step[0], step[1])) % 360.0)
    return None


def _hold(item: Item) -> float | None:
    holds = {Command.NAV_WAYPOINT, Command.NAV_SPLINE_WAYPOINT, Command.NAV_LOITER_TIME, Command.NAV_DELAY}
    return item.params[0] if item.command in holds and item.params[0] > 0 else None


def _detail(item: Item) -> str:
    """What the columns do not show, in words."""
    match item.command:
        case Command.DO_JUMP:
            return f"to item {item.params[0]:g}, {item.params[1]:g} times"
        case Command.NAV_LOITER_TURNS:
            return f"{item.params[0]:g} turns"
        case Command.NAV_WAYPOINT if item.params[1] > 0:
            return f"within {item.params[1]:g} m"
        case Command.NAV_WAYPOINT | Command.NAV_TAKEOFF | Command.NAV_LAND | Command.DO_CHANGE_SPEED:
            return ""
        case _:
            given = (f"param{n} {value:g}" for n, value in enumerate(item.params, 1) if value and math.isfinite(value))
            return ", ".join(given)
