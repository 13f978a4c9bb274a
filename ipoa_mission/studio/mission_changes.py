import math
from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path
from typing import TypeVar

from ipoa_mission.autopilot.autopilot import Autopilot, autopilot_named
from ipoa_mission.autopilot.commands import Command, Frame, plain_frame
from ipoa_mission.errors import BadInput
from ipoa_mission.mission.item_edits import with_inserted, with_item, with_plain_items, without_item
from ipoa_mission.mission.items import Item, Mission
from ipoa_mission.mission.kept_whole import text_with
from ipoa_mission.mission.mission_io import parse_mission
from ipoa_mission.mission.stored_mission import settle_frames, values_of
from ipoa_mission.studio.requests import Change, InsertItem, MoveItem, PlainItems, Put, PutItem, Shift, TakeItem
from ipoa_mission.studio.vocabulary import LngLat
from ipoa_mission.world.frame import Geodetic

DEFAULT_HEIGHT = 20.0  # if no item before has a height [m]
DIGITS, DEGREES = 2, 7  # decimals of heights and of degrees
Placed = TypeVar("Placed", Item, Geodetic)


def mission_changed(text: str, path: Path, changes: Iterable[Change], autopilot: str | None = None) -> str:
    """Return the text with these changes."""
    file = parse_mission(path, text, None if autopilot is None else autopilot_named(autopilot))
    mission = file.mission
    for change in changes:
        mission = _changed(mission, change)
    return text_with(mission, file, path)


def _changed(mission: Mission, change: Change) -> Mission:
    match change:
        case PutItem():
            item = _item(mission, change.seq)
            return with_item(mission, change.seq, _settled(_put(item, change, mission), mission.autopilot))
        case MoveItem():
            item = _item(mission, change.seq)
            return with_item(mission, change.seq, _moved(item, change.place))
        case InsertItem():
            item = _settled(_new_item(mission, change), mission.autopilot)
            return with_inserted(mission, change.seq, item)
        case TakeItem():
            return without_item(mission, change.seq)
        case PlainItems():
            return with_plain_items(mission, change.seq)
        case Shift(path=("home",)):
            return replace(mission, home=_moved(mission.home, change.put_down))
        case Put(path=("home", "altitude_amsl")) if isinstance(change.value, int | float):
            return replace(mission, home=replace(mission.home, altitude=float(change.value)))
    words = "expected a change of a mission's items"
    raise BadInput(words, hint="this is a mission file, not a scenario", place=change.op)


def _item(mission: Mission, seq: int) -> Item:
    if not 1 <= seq <= len(mission.items):
        raise BadInput(f"expected a number from 1 to {len(mission.items)}", code="no-such-item", place=f"item {seq}")
    return mission.items[seq - 1]


def _moved(thing: Placed, place: LngLat) -> Placed:
    return replace(thing, latitude_deg=round(place[1], DEGREES), longitude_deg=round(place[0], DEGREES))


def _put(item: Item, change: PutItem, mission: Mission) -> Item:
    """Return the item with one value changed; a change of frame keeps its height if known."""
    value = math.nan if change.value is None else change.value
    if change.what in ("command", "frame"):
        if not (value.is_integer() and 0 <= value <= 65535):
            raise BadInput(f"expected a whole number, not {value:g}", place=f"item {change.seq}: {change.what}")
        if change.what == "command":
            return replace(item, command=int(value), params=(0.0, 0.0, 0.0, item.params[3]))
        return _in_frame(item, int(value), mission)
    number = int(change.what.removeprefix("param"))
    if number > 4 and not math.isfinite(value):
        raise BadInput("expected a number", place=f"item {change.seq}: {change.what}")
    values = [value if n == number else old for n, old in enumerate(values_of(item), start=1)]
    p1, p2, p3, p4, latitude, longitude, altitude = values
    return replace(item, params=(p1, p2, p3, p4), latitude_deg=latitude, longitude_deg=longitude, altitude=altitude)


def _in_frame(item: Item, frame: int, mission: Mission) -> Item:
    above, amsl = mission.altitude_above_home(item), plain_frame(frame) == Frame.GLOBAL
    known = math.isfinite(above) and frame != Frame.GLOBAL_TERRAIN_ALT
    altitude = round(above + (mission.home.altitude if amsl else 0.0), DIGITS) if known else item.altitude
    return replace(item, frame=frame, altitude=altitude)


def _new_item(mission: Mission, change: InsertItem) -> Item:
    before = [item for item in mission.items[: change.seq - 1] if item.has_position and item.altitude > 0]
    like = before[-1] if before else Item(Command.NAV_WAYPOINT, Frame.GLOBAL_RELATIVE_ALT, altitude=DEFAULT_HEIGHT)
    firmware = mission.autopilot.firmware(mission.firmware_version)
    own = math.nan if firmware.takes_nan is None else 0.0  # heading
    item = Item(change.command, like.frame, (0.0, 0.0, 0.0, own if change.command in firmware.placed else 0.0))
    if change.command not in firmware.placed or change.command == Command.NAV_RETURN_TO_LAUNCH:
        return _first_values(replace(item, frame=int(Frame.MISSION)), mission)
    home = mission.home
    place = change.place or (like.longitude_deg or home.longitude_deg, like.latitude_deg or home.latitude_deg)
    altitude = 0.0 if change.command == Command.NAV_LAND else like.altitude
    frame = int(Frame.GLOBAL_RELATIVE_ALT) if change.command == Command.NAV_LAND else like.frame
    return _first_values(_moved(replace(item, frame=frame, altitude=altitude), place), mission)


def _first_values(item: Item, mission: Mission) -> Item:
    match item.command:
        case Command.DO_CHANGE_SPEED:
            return replace(item, params=(1.0, mission.cruise_speed or 5.0, -1.0, 0.0))
        case Command.DO_JUMP | Command.DO_JUMP_TAG:
            return replace(item, params=(1.0, 1.0, 0.0, 0.0))
        case Command.NAV_LOITER_TIME | Command.NAV_DELAY | Command.CONDITION_DELAY:
            return replace(item, params=(5.0, *item.params[1:]))
        case Command.NAV_LOITER_TURNS:
            return replace(item, params=(1.0, *item.params[1:]))
    return item


def _settled(item: Item, autopilot: Autopilot) -> Item:
    settled = settle_frames((item,), autopilot)[0]
    if settled.frame == Frame.MISSION and item.command in autopilot.firmware().placed:
        return replace(settled, frame=int(Frame.GLOBAL_RELATIVE_ALT))
    return settled
