"""Apply the page's changes to the text of a scenario or a mission; all else stays."""

import math
from collections.abc import Iterable, MutableMapping
from dataclasses import replace
from pathlib import Path as FilePath
from typing import Any, TypeVar

import numpy as np
import tomlkit
from tomlkit.exceptions import TOMLKitError
from tomlkit.items import AoT, Array

from ipoa_mission import Item, Mission
from ipoa_mission.autopilot.autopilot import autopilot_named
from ipoa_mission.autopilot.commands import Command, Frame, plain_frame
from ipoa_mission.errors import BadInput, WrongFormat
from ipoa_mission.geodesy import Geodetic, LocalFrame, apart
from ipoa_mission.mission.item_edits import text_with, with_inserted, with_item, with_plain_items, without_item
from ipoa_mission.mission.mission_io import parse_mission
from ipoa_mission.mission.stored_mission import resolve_frames, values_of
from ipoa_mission.studio import area_edits, requests
from ipoa_mission.studio.area_edits import DEGREES, DIGITS, Move, at_path, local_of, moves_of
from ipoa_mission.studio.requests import Change
from ipoa_mission.studio.vocabulary import LngLat, Path

Placed = TypeVar("Placed", Item, Geodetic)


def parse_table(text: str) -> tomlkit.TOMLDocument:
    try:
        return tomlkit.parse(text)
    except (TOMLKitError, ValueError, RecursionError) as error:
        raise WrongFormat(f"expected TOML: {error}", hint="correct the text, or undo") from error


def changed(text: str, changes: Iterable[Change]) -> str:
    """Return a scenario's text with these changes.

    >>> from ipoa_mission.studio.requests import Put
    >>> changed("safety_distance = 2.0  # of the hull\\n", [Put(path=("safety_distance",), value=3.0)])
    'safety_distance = 3.0  # of the hull\\n'
    """
    document = parse_table(text)
    apply_changes(document, changes)
    return tomlkit.dumps(document)


def apply_changes(document: MutableMapping[str, Any], changes: Iterable[Change]) -> None:
    for change in changes:
        try:
            _apply(document, change)
        except (AttributeError, KeyError, IndexError, TypeError, ValueError, TOMLKitError) as error:
            path = ".".join(map(str, getattr(change, "path", (getattr(change, "to", ""),))))
            raise BadInput(f"expected a value or a table at this path: {error}", place=path) from error


def frame_of(table: MutableMapping[str, Any]) -> LocalFrame:
    home = table["home"]
    place = (home["latitude_deg"], home["longitude_deg"], home.get("altitude_amsl", 0.0))
    return LocalFrame(Geodetic(*map(float, place)))


def _apply(document: MutableMapping[str, Any], change: Change) -> None:
    match change:
        case requests.Put():
            _put(document, change.path, change.value)
        case requests.Take() if area_edits.is_of_area(change.path):
            area_edits.take_of_area(document, change.path)
        case requests.Take():
            parent = at_path(document, change.path[:-1])
            del parent[change.path[-1]]
            if len(change.path) > 1 and not isinstance(change.path[-1], str) and not len(parent):
                del at_path(document, change.path[:-2])[change.path[-2]]
        case requests.Shift(path=("home",)):
            _shift_home(document, change)
        case requests.Shift():
            frame = frame_of(document)
            step = np.subtract(local_of(frame, change.put_down), local_of(frame, change.taken))
            local, geodetic = moves_of(frame, frame, step)
            if area_edits.is_of_area(change.path):
                area_edits.write_in_full(document)
                area_edits.move_nested(at_path(document, change.path), local)
            else:
                _move(at_path(document, change.path), local, geodetic)
        case requests.Add():
            _add(document, change)
        case requests.DrawArea() | requests.OwnArea() | requests.MapArea() | requests.Corner():
            area_edits.change_area(document, change, frame_of(document))


def _put(document: Any, path: Path, value: Any) -> None:
    *parents, last = path
    table = document
    for step in parents:
        table = table.setdefault(step, tomlkit.table()) if isinstance(step, str) else table[step]
    before = table.get(last) if isinstance(last, str) else table[last]
    is_whole = isinstance(value, int) and not isinstance(value, bool)
    table[last] = float(value) if isinstance(before, float) and is_whole else value


def _add(document: Any, change: requests.Add) -> None:
    table: Any = dict(change.table)
    frame = frame_of(document)
    if change.place is not None:
        kind = {"kind": table.pop("kind")} if "kind" in table else {}
        east, north = local_of(frame, change.place)
        place: dict[str, Any] = {"east": east, "north": north}
        if "latitude_deg" in document.get("goal", {}):  # then all places are in degrees
            longitude, latitude = (round(degrees, DEGREES) for degrees in change.place)
            place = {"latitude_deg": latitude, "longitude_deg": longitude}
        table = kind | place | table
    if change.ring is not None:
        key = "polygon" if change.to == "fence" else "footprint"
        table[key] = [local_of(frame, corner) for corner in change.ring]
    if change.to not in document:
        document[change.to] = tomlkit.aot()
    tables = document[change.to]
    if isinstance(tables, Array):
        inline = tomlkit.inline_table()
        inline.update(table)
        table = inline
    elif isinstance(tables, AoT):
        table = tomlkit.item(table)
        table.add(tomlkit.nl())
    tables.insert(len(tables) if change.at is None else change.at, table)


def _move(tables: Any, local: Move, geodetic: Move | None) -> None:
    """Move the places of one or several tables; without `geodetic` those in degrees stay."""
    if isinstance(tables, list):
        for table in tables:
            _move(table, local, geodetic)
        return
    for (one, other), move in ((("east", "north"), local), (("latitude_deg", "longitude_deg"), geodetic)):
        if move is not None and one in tables and other in tables:
            tables[one], tables[other] = move(tables[one], tables[other])
    keys = ("footprint", "polygon", "line", "entry", "exit")
    moves: dict[str, Move | None] = dict.fromkeys(keys, local)
    moves |= {"footprint_geodetic": geodetic, "polygon_geodetic": geodetic}
    moves["holes"] = geodetic if "footprint_geodetic" in tables else local
    for key, ring_move in moves.items():
        if key in tables and ring_move is not None:
            area_edits.move_nested(tables[key], ring_move)
    for key in ("center", "peaks"):
        _move(tables.get(key, []), local, geodetic)


def _shift_home(document: MutableMapping[str, Any], change: requests.Shift) -> None:
    """Move home alone: places in meters stay on the map; beyond 20 km they move along."""
    old = frame_of(document)
    home = document["home"]
    for key, n in (("longitude_deg", 0), ("latitude_deg", 1)):
        home[key] = round(float(home[key]) + change.put_down[n] - change.taken[n], DEGREES)
    if apart(old.home, frame_of(document).home) > 20_000.0:
        return
    local, _ = moves_of(old, frame_of(document), np.zeros(2))
    for key in ("start", "goal", "via", "rally", "obstacles", "fence", "terrain", "survey"):
        _move(document.get(key, []), local, None)
    bounds = document.get("bounds", {})
    for key, step in zip(("east", "north"), local(0.0, 0.0), strict=True):
        for n, side in enumerate(bounds.get(key, ())):
            bounds[key][n] = round(float(side) + step, DIGITS)


def mission_changed(text: str, path: FilePath, changes: Iterable[Change], autopilot: str | None = None) -> str:
    file = parse_mission(path, text, None if autopilot is None else autopilot_named(autopilot))
    mission = file.mission
    for change in changes:
        mission = _with_change(mission, change)
    return text_with(mission, file, path)


def _with_change(mission: Mission, change: Change) -> Mission:
    match change:
        case requests.PutItem():
            item = _with_value(_item(mission, change.seq), change, mission)
            return with_item(mission, change.seq, _with_frame(item, mission))
        case requests.MoveItem():
            return with_item(mission, change.seq, _moved(_item(mission, change.seq), change.place))
        case requests.InsertItem():
            return with_inserted(mission, change.seq, _with_frame(_new_item(mission, change), mission))
        case requests.ItemStep():
            return (without_item if change.op == "take_item" else with_plain_items)(mission, change.seq)
        case requests.Shift(path=("home",)):
            return replace(mission, home=_moved(mission.home, change.put_down))
        case requests.Put(path=("home", "altitude_amsl")) if isinstance(change.value, int | float):
            return replace(mission, home=replace(mission.home, altitude=float(change.value)))
    words = "expected a change of a mission's items"
    raise BadInput(words, hint="this is a mission file, not a scenario", place=str(change.model_dump()["op"]))


def _item(mission: Mission, seq: int) -> Item:
    if not 1 <= seq <= len(mission.items):
        raise BadInput(f"expected a number from 1 to {len(mission.items)}", code="no-such-item", place=f"item {seq}")
    return mission.items[seq - 1]


def _moved(thing: Placed, place: LngLat) -> Placed:
    return replace(thing, latitude_deg=round(place[1], DEGREES), longitude_deg=round(place[0], DEGREES))


def _with_value(item: Item, change: requests.PutItem, mission: Mission) -> Item:
    """Keep the height, if known, when the frame changes."""
    value = math.nan if change.value is None else change.value
    if change.what in ("command", "frame"):
        if not (value.is_integer() and 0 <= value <= 65535):
            raise BadInput(f"expected a whole number, not {value:g}", place=f"item {change.seq}: {change.what}")
        if change.what == "command":
            return replace(item, command=int(value), params=(0.0, 0.0, 0.0, item.params[3]))
        height = mission.altitude_above_home(item)
        if not math.isfinite(height) or value == Frame.GLOBAL_TERRAIN_ALT:
            return replace(item, frame=int(value))
        datum = mission.home.altitude if plain_frame(int(value)) == Frame.GLOBAL else 0.0
        return replace(item, frame=int(value), altitude=round(height + datum, DIGITS))
    number = int(change.what.removeprefix("param"))
    if number > 4 and not math.isfinite(value):
        raise BadInput(f"expected a number, not {value:g}", place=f"item {change.seq}: {change.what}")
    values = [value if n == number else old for n, old in enumerate(values_of(item), start=1)]
    p1, p2, p3, p4, latitude, longitude, altitude = values
    return replace(item, params=(p1, p2, p3, p4), latitude_deg=latitude, longitude_deg=longitude, altitude=altitude)


def _new_item(mission: Mission, change: requests.InsertItem) -> Item:
    before = [item for item in mission.items[: change.seq - 1] if item.has_position and item.altitude > 0]
    model = before[-1] if before else Item(Command.NAV_WAYPOINT, Frame.GLOBAL_RELATIVE_ALT, altitude=20.0)
    home = mission.home
    firmware = mission.firmware
    is_placed = change.command in firmware.placed
    usual: dict[int, tuple[float, ...]] = {
        Command.DO_CHANGE_SPEED: (1.0, mission.cruise_speed or 5.0, -1.0),
        **dict.fromkeys((Command.DO_JUMP, Command.DO_JUMP_TAG), (1.0, 1.0)),
        **dict.fromkeys((Command.NAV_LOITER_TIME, Command.NAV_DELAY, Command.CONDITION_DELAY), (5.0,)),
        Command.NAV_LOITER_TURNS: (1.0,),
    }
    heading = math.nan if is_placed and firmware.takes_nan is None else 0.0
    p1, p2, p3 = (*usual.get(change.command, ()), 0.0, 0.0, 0.0)[:3]
    item = Item(change.command, model.frame, (p1, p2, p3, heading), altitude=model.altitude)
    if not is_placed or change.command == Command.NAV_RETURN_TO_LAUNCH:
        return replace(item, frame=int(Frame.MISSION), altitude=0.0)
    if change.command == Command.NAV_LAND:
        item = replace(item, frame=int(Frame.GLOBAL_RELATIVE_ALT), altitude=0.0)
    place = change.place or (model.longitude_deg or home.longitude_deg, model.latitude_deg or home.latitude_deg)
    return _moved(item, place)


def _with_frame(item: Item, mission: Mission) -> Item:
    framed = resolve_frames((item,), mission.autopilot)[0]
    if framed.frame == Frame.MISSION and item.command in mission.autopilot.firmware().placed:
        return replace(framed, frame=int(Frame.GLOBAL_RELATIVE_ALT))
    return framed
