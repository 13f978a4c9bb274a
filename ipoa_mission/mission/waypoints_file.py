"""`.waypoints` files (QGC WPL 110), written strictly, read leniently.

No terrain altitude is written: ground stations take it as AMSL. NaN is kept: PX4 turns north where param4 is 0.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from ipoa_mission.autopilot.autopilot import Autopilot, default_autopilot
from ipoa_mission.autopilot.commands import Command, Frame
from ipoa_mission.errors import BadInput, WrongFormat
from ipoa_mission.finding import Finding, Severity
from ipoa_mission.geodesy import Geodetic
from ipoa_mission.mission.items import Item, Mission, MissionFile
from ipoa_mission.mission.json_node import Node
from ipoa_mission.mission.parameter_file import NUMBER
from ipoa_mission.mission.stored_mission import CIRCLE, POLYGON, home_item, refuse_infinite, resolve_frames

FIRST_LINE = "QGC WPL 110"
TAKEOFF_LOST = "QGroundControl 4.4 loses the take-off of a .waypoints file: open the .plan there"
OTHER_LISTS = frozenset({*POLYGON, *CIRCLE, Command.NAV_FENCE_RETURN_POINT, Command.NAV_RALLY_POINT})
PARAMS = ("param1", "param2", "param3", "param4")
FIELDS = ("seq", "current", "frame", "command", *PARAMS, "latitude", "longitude", "altitude", "autocontinue")


def waypoints_text(mission: Mission) -> str:
    items = resolve_frames(mission.items, mission.autopilot)
    for number, item in enumerate((home_item(mission.home), *items)):
        _check(number, item)
    refuse_infinite(items)
    nan = math.nan if mission.autopilot.firmware().nan_holds else 0.0  # ArduPilot's ground stations read no NaN
    lines = (_line(seq, item, nan) for seq, item in enumerate((home_item(mission.home), *items)))
    return "\n".join([FIRST_LINE, *lines]) + "\n"


def lost_in_waypoints(mission: Mission) -> tuple[str, ...]:
    return (*left_out(mission), *([TAKEOFF_LOST] if any(item.is_takeoff for item in mission.items) else []))


def left_out(mission: Mission) -> tuple[str, ...]:
    fence = "a .waypoints file cannot contain the geofence"
    rally = "a .waypoints file cannot contain the rally points: its RTL flies home, by another way, time and energy"
    return (*([fence] if mission.fence else []), *([rally] if mission.rally else []))


def parse_waypoints(path: Path, text: str, autopilot: Autopilot | None = None) -> MissionFile:
    """Accept CRLF, blank lines and `#` comments; replace a home at 0, 0 by the first place."""
    autopilot = autopilot or default_autopilot()
    rows = list(_rows(path, text))
    if not rows:
        raise BadInput("expected a first item that is home, but there is none", code="home-missing", place=path)
    if rows[-1][1].command in OTHER_LISTS:
        words = "expected a mission, but the file holds a geofence or rally points"
        raise BadInput(words, hint="open the mission's file", code="not-a-mission-item", place=path)
    findings = list(_check_numbers(rows))
    (row, first), *rest = rows
    if first.command not in (Command.NAV_WAYPOINT, 0):  # 0: in files of Mission Planner
        words = f"expected 16 (item 0 is home), not {first.command}"
        hint = "a file whose first item is a take-off lost its home item: put one before it"
        raise BadInput(words, hint=hint, code="home-missing", place=f"{row.where}: command")
    if abs(first.latitude_deg) > 90:
        raise BadInput(f"expected degrees from -90 to 90, not {first.latitude_deg:g}", place=f"{row.where}: latitude")
    items = resolve_frames([item for _, item in rest], autopilot)
    home = Geodetic(first.latitude_deg, first.longitude_deg, first.altitude)
    if (home.latitude_deg, home.longitude_deg) == (0.0, 0.0) and (places := [i for i in items if i.has_position]):
        home = replace(home, latitude_deg=places[0].latitude_deg, longitude_deg=places[0].longitude_deg)
        message = "home: 0, 0 is no place: the first place of the mission is used"
        findings.append(Finding("file-home", Severity.WARNING, 0, message))
    if first.frame not in (Frame.GLOBAL, Frame.GLOBAL_INT):
        message = f"home: its altitude is taken as AMSL, but its frame is {first.frame}, not 0"
        findings.append(Finding("file-home", Severity.WARNING, 0, message))
    return MissionFile(Mission(home, items, autopilot), tuple(findings), text, ".waypoints")


def _check(number: int, item: Item) -> None:
    where = f"item {number} ({item.name})" if number else "home"
    if item.frame in (Frame.GLOBAL_TERRAIN_ALT, Frame.GLOBAL_TERRAIN_ALT_INT):
        words = "expected an altitude above home or AMSL, not above terrain: ground stations read it as AMSL"
        raise BadInput(words, hint="write a .plan file", code="frame-not-written", place=where)
    if item.command in OTHER_LISTS:
        expected = "a mission item, not one of a fence or of rally points"
        words = f"expected {expected}: readers take a file with it as such a list"
        raise BadInput(words, hint="write a .plan file", code="not-a-mission-item", place=where)
    if not all(map(math.isfinite, (item.latitude_deg, item.longitude_deg, item.altitude))):
        words = f"expected a finite position, not one with altitude {item.altitude}"
        raise BadInput(words, code="position-missing", place=where)


def _line(seq: int, item: Item, nan: float) -> str:
    params = [_number(nan if math.isnan(value) else value) for value in item.params]
    place = [_number(value, 8) for value in (item.latitude_deg, item.longitude_deg)]
    head = (seq, int(seq == 0), int(item.frame), int(item.command))
    return "\t".join(map(str, (*head, *params, *place, _number(item.altitude), int(item.autocontinue))))


def _number(value: float, least_digits: int = 6) -> str:
    return np.format_float_positional(value, unique=True, min_digits=least_digits)


def _rows(path: Path, text: str) -> Iterator[tuple[Node, Item]]:
    first, *lines = text.replace("\r\n", "\n").replace("\r", "\n").split("\n")
    if first.split() != FIRST_LINE.split():
        first_line = f'"{first[:40]}"' if text.strip() else "an empty file"
        raise WrongFormat(f'expected "{FIRST_LINE}", not {first_line}', place=f"{path}: line 1")
    for number, line in enumerate(lines, start=2):
        words = line.split()
        if not words or words[0].startswith("#"):
            continue
        place = f"{path}: line {number}"
        if len(words) != len(FIELDS):
            raise BadInput(f"expected {len(FIELDS)} fields, not {len(words)}", place=place)
        row = Node(place, "", dict(zip(FIELDS, map(_value, words), strict=True)))
        yield row, _item(row)


def _value(word: str) -> float | str:
    if not NUMBER.fullmatch(word):
        return word
    number = float(word)
    return int(number) if number.is_integer() else number


def _check_numbers(rows: Sequence[tuple[Node, Item]]) -> Iterator[Finding]:
    """Refuse wrong line numbers if there are jumps, else report them."""
    has_jump = any(item.command == Command.DO_JUMP for _, item in rows)
    for count, (row, _) in enumerate(rows):
        seq = row["seq"].whole()
        if seq != count:
            if has_jump:
                raise row["seq"].wrong(f"{count} (a jump counts on it)")
            then = "items are numbered by their lines" if count else "taken as home, which the file may lack"
            message = f"{row.where.rpartition(': ')[2]}: seq {seq} is not {count}: {then}"
            yield Finding("file-numbers", Severity.WARNING, count, message)
            return


def _item(row: Node) -> Item:
    row["current"].whole(most=3)
    frame = row["frame"].whole(most=255)
    p1, p2, p3, p4 = (_number_or_nan(row[name]) for name in PARAMS)
    latitude, longitude = (_degrees(row[name], frame) for name in ("latitude", "longitude"))
    altitude = row["altitude"].number()
    autocontinue = bool(row["autocontinue"].whole(most=1))
    return Item(row["command"].whole(), frame, (p1, p2, p3, p4), latitude, longitude, altitude, autocontinue)


def _number_or_nan(node: Node) -> float:
    return math.nan if isinstance(node.value, float) and math.isnan(node.value) else node.number()


def _degrees(node: Node, frame: int) -> float:
    value = node.number()
    if abs(value) > 180 and frame != Frame.MISSION:
        scaled = "divide it by 1e7: MISSION_ITEM_INT has units of 1e-7 degrees" if abs(value) > 1e6 else None
        raise node.wrong("degrees from -180 to 180", scaled)
    return value
