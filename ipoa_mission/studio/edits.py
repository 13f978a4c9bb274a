"""Change a scenario's text; all other bytes and comments stay."""

from collections.abc import Iterable, MutableMapping
from typing import Any

import numpy as np
import tomlkit
from tomlkit.exceptions import TOMLKitError
from tomlkit.items import AoT, Array

from ipoa_mission.errors import BadInput, WrongFormat
from ipoa_mission.studio.area_edits import (
    DEGREES,
    DIGITS,
    Move,
    change_area,
    is_of_area,
    local_of,
    move_area,
    move_survey,
    moves_of,
    take_of_area,
)
from ipoa_mission.studio.requests import Add, AddCorner, Change, DrawArea, MapArea, OwnArea, Put, PutCorner, Shift, Take
from ipoa_mission.studio.vocabulary import LngLat, Path
from ipoa_mission.world.frame import Geodetic, LocalFrame, apart

FAR_DISTANCE = 20_000.0  # beyond, everything in meters moves with home [m]
RINGS = ("footprint", "polygon")  # with the suffix `_geodetic` they are [latitude, longitude]


def parse_table(text: str) -> tomlkit.TOMLDocument:
    try:
        return tomlkit.parse(text)
    except (TOMLKitError, ValueError, RecursionError) as error:
        raise WrongFormat(f"expected TOML: {error}", hint="correct the text, or undo") from error


def changed(text: str, changes: Iterable[Change]) -> str:
    """Return the text with these changes.

    >>> from ipoa_mission.studio.requests import Put
    >>> changed("safety_distance = 2.0  # of the hull\\n", [Put(path=("safety_distance",), value=3.0)])
    'safety_distance = 3.0  # of the hull\\n'
    """
    document = parse_table(text)
    apply_changes(document, changes)
    return tomlkit.dumps(document)


def apply_changes(document: MutableMapping[str, Any], changes: Iterable[Change]) -> None:
    """Apply changes to a table in place, formatted or plain."""
    for change in changes:
        try:
            _apply(document, change)
        except (KeyError, IndexError, TypeError, ValueError, TOMLKitError) as error:
            path = ".".join(map(str, getattr(change, "path", (getattr(change, "to", ""),))))
            raise BadInput(f"expected a value or a table at this path: {error}", place=path) from error


def frame_of(table: MutableMapping[str, Any]) -> LocalFrame:
    home = table["home"]
    place = (home["latitude_deg"], home["longitude_deg"], home.get("altitude_amsl", 0.0))
    return LocalFrame(Geodetic(*map(float, place)))


def _apply(document: MutableMapping[str, Any], change: Change) -> None:
    match change:
        case Put():
            _put(document, change.path, change.value)
        case Take() if is_of_area(change.path):
            take_of_area(document, change.path)
        case Take():
            _take(document, change.path)
        case Shift(path=("home",)):
            _shift_home(document, change)
        case Shift():
            frame = frame_of(document)
            step = np.subtract(local_of(frame, change.put_down), local_of(frame, change.taken))
            if is_of_area(change.path):
                move_area(document, change.path, moves_of(frame, frame, step)[0])
            else:
                _move(_at(document, change.path), *moves_of(frame, frame, step))
        case Add():
            _add(document, change)
        case DrawArea() | OwnArea() | MapArea() | PutCorner() | AddCorner():
            change_area(document, change, frame_of(document))


def _at(document: Any, path: Path) -> Any:
    for step in path:
        document = document[step]
    return document


def _put(document: Any, path: Path, value: Any) -> None:
    *way, last = path
    here = document
    for step in way:
        if isinstance(step, str) and step not in here:
            here[step] = tomlkit.table()
        here = here[step]
    before = here.get(last) if isinstance(last, str) else here[last]
    here[last] = float(value) if isinstance(before, float) and isinstance(value, int) else value


def _take(document: Any, path: Path) -> None:
    *way, last = path
    here = _at(document, tuple(way))
    del here[last]
    if way and not isinstance(last, str) and not len(here):
        del _at(document, tuple(way[:-1]))[way[-1]]


def _add(document: Any, change: Add) -> None:
    table, frame = dict(change.table), frame_of(document)
    if change.place is not None:
        table = _placed(table, change.place, frame, _uses_degrees(document))
    if change.ring is not None:
        key = "polygon" if change.to == "fence" else "footprint"
        table[key] = [local_of(frame, corner) for corner in change.ring]
    tables = document.get(change.to)
    at = len(tables) if tables is not None and change.at is None else change.at or 0
    if tables is None:
        document[change.to] = tables = tomlkit.aot()
    if isinstance(tables, Array):
        inline = tomlkit.inline_table()
        inline.update(table)
        tables.insert(at, inline)
    else:
        tables.insert(at, _as_table(table) if isinstance(tables, AoT) else table)


def _as_table(values: dict[str, Any]) -> tomlkit.items.Table:
    table = tomlkit.table()
    for key, value in values.items():
        table.add(key, value)
    table.add(tomlkit.nl())
    return table


def _uses_degrees(document: Any) -> bool:
    return "latitude_deg" in document.get("goal", {})


def _placed(table: dict[str, Any], place: LngLat, frame: LocalFrame, in_degrees: bool) -> dict[str, Any]:
    if in_degrees:
        where = {"latitude_deg": round(place[1], DEGREES), "longitude_deg": round(place[0], DEGREES)}
    else:
        where = dict(zip(("east", "north"), local_of(frame, place), strict=True))
    kind = {"kind": table.pop("kind")} if "kind" in table else {}
    return kind | where | table


def _move(table: Any, local: Move, geodetic: Move | None) -> None:
    for keys, move in ((("east", "north"), local), (("latitude_deg", "longitude_deg"), geodetic)):
        if move is not None and all(key in table for key in keys):
            for key, value in zip(keys, move(*(table[key] for key in keys)), strict=True):
                table[key] = value
    for key in RINGS:
        for ring, move in ((table.get(key), local), (table.get(f"{key}_geodetic"), geodetic)):
            if ring is not None and move is not None:
                _move_ring(ring, move)
    for hole in table.get("holes", ()):
        hole_move = geodetic if "footprint_geodetic" in table else local
        if hole_move is not None:
            _move_ring(hole, hole_move)
    if "center" in table:
        _move(table["center"], local, geodetic)


def _move_ring(ring: Any, move: Move) -> None:
    for corner in ring:
        corner[0], corner[1] = move(corner[0], corner[1])


def _shift_home(document: MutableMapping[str, Any], change: Shift) -> None:
    """Move home alone, so that places in meters stay on the map; beyond `FAR_DISTANCE` they move along."""
    old, home = frame_of(document), document["home"]
    for key, n in (("longitude_deg", 0), ("latitude_deg", 1)):
        home[key] = round(float(home[key]) + change.put_down[n] - change.taken[n], DEGREES)
    if apart(old.home, frame_of(document).home) > FAR_DISTANCE:
        return
    local, _ = moves_of(old, frame_of(document), np.zeros(2))
    for key in ("start", "goal"):
        _move(document.get(key, {}), local, None)
    move_survey(document.get("survey", {}), local)
    for key in ("via", "rally", "obstacles", "fence"):
        for table in document.get(key, ()):
            _move(table, local, None)
    _shift_boxes(document, local)


def _shift_boxes(document: Any, local: Move) -> None:
    """Move bounds and height grids, parallel to the axes."""
    east, north = local(0.0, 0.0)
    bounds = document.get("bounds", {})
    for key, by in (("east", east), ("north", north)):
        if key in bounds:
            for n, side in enumerate(bounds[key]):
                bounds[key][n] = round(float(side) + by, DIGITS)
    terrain = document.get("terrain", {})
    for table in (terrain, *terrain.get("peaks", ())):
        if "east" in table and "north" in table:
            _move(table, local, None)
