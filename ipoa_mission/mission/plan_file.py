"""`.plan` files of QGroundControl, written and read (docs/file-formats.md)."""

import json
import math
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from enum import IntEnum
from pathlib import Path
from typing import Any

from ipoa_mission.autopilot.autopilot import QUADROTOR, Autopilot, registered
from ipoa_mission.autopilot.commands import FLOWN_TO, PLAIN_FRAME, Command, Frame
from ipoa_mission.errors import BadInput
from ipoa_mission.finding import Finding, Severity
from ipoa_mission.geodesy import Geodetic
from ipoa_mission.mission.complex_items import ITEMS, TRANSECTS, as_document, complex_items_in, entries
from ipoa_mission.mission.item_words import name_items
from ipoa_mission.mission.items import FenceCircle, FencePolygon, Item, Mission, MissionFile
from ipoa_mission.mission.json_node import Node, finite, parse_document, tidy
from ipoa_mission.mission.landing_ground import landing_ground_entry
from ipoa_mission.mission.stored_mission import refuse_infinite, resolve_frames, values_of
from ipoa_mission.unread import Unread, gathered


class AltitudeMode(IntEnum):
    """QGroundControl's; with CALCULATED, `Altitude` is over the ground and `AMSLAltAboveTerrain` is flown."""

    MIXED = 0
    RELATIVE = 1
    AMSL = 2
    CALCULATED = 3
    TERRAIN = 4


ALTITUDE_MODES = {
    Frame.GLOBAL_RELATIVE_ALT: AltitudeMode.RELATIVE,
    Frame.GLOBAL: AltitudeMode.AMSL,
    Frame.GLOBAL_TERRAIN_ALT: AltitudeMode.TERRAIN,
}
GROUND_KEYS = ("latitude", "longitude", "aboveHome")
#: Keys that are not asked for, or not always; `[]`: each member.
WITHOUT_EFFECT = {
    "": {"groundStation", "UUID"},
    "mission": {"cruiseSpeed", "firmwareType", "globalPlanAltitudeMode"},
    "mission.items[]": {"type", "MISSION_ITEM_ID", "AMSLAltAboveTerrain"},
    "geoFence": {"version", "breachReturn"},
    **{key: {"version"} for key in ("geoFence.polygons[]", "geoFence.circles[]", "rallyPoints")},
}
NO_RALLY = "taken as a mission without rally points"


def plan_text(mission: Mission) -> str:
    return json.dumps(_plan(mission), indent=4, sort_keys=True, allow_nan=False) + "\n"


def parse_plan(path: Path, text: str, autopilot: Autopilot | None = None) -> MissionFile:
    """Read a `.plan` of QGroundControl, MAVSDK or this package.

    `autopilot` overrides `firmwareType` and `vehicleType`. An `Altitude` that differs from `params` is an error.
    """
    plan = parse_document(path, text)
    if plan["fileType"].text() != "Plan":
        raise plan["fileType"].wrong('"Plan"')
    plan["version"].whole("1", 1, 1)
    mission = plan["mission"]
    if version := mission.get("version"):
        version.whole("2", 2, 2)
    speed = mission.given("hoverSpeed")
    kind = mission.usual("vehicleType", "taken as a multicopter")
    ground = plan.get("landingGround")
    vehicle_type = QUADROTOR if kind is None else kind.whole("a MAV_TYPE number", 0, 255)
    autopilot = autopilot or autopilot_in(mission["firmwareType"], vehicle_type)
    listed = [entry for child in mission["items"].array() for entry in _listed(child)]
    items = resolve_frames([*_items(listed)], autopilot)
    read = Mission(
        home=_home(mission["plannedHomePosition"], items),
        items=items,
        autopilot=autopilot,
        cruise_speed=None if speed is None else _speed(speed),
        fence=_fence(plan.usual("geoFence", "taken as a mission without a fence")),
        rally=_rally(plan.usual("rallyPoints", NO_RALLY)),
        vehicle_type=vehicle_type,
        landing_ground=None if ground is None else Geodetic(*(ground[key].number() for key in GROUND_KEYS)),
        complex_items=complex_items_in([entry.part_of for entry in listed], items),
    )
    return MissionFile(read, (*plan.findings, *_check_numbers(listed), *findings_of_keys(plan)), text, ".plan")


def _plan(mission: Mission) -> dict[str, Any]:
    items = resolve_frames(mission.items, mission.autopilot)
    for number, item in enumerate(items, start=1):
        _check_written(number, item, len(items))
    refuse_infinite(items)
    header: dict[str, Any] = {
        "firmwareType": mission.autopilot.mav_autopilot,
        "globalPlanAltitudeMode": _altitude_mode(items),
        "items": [*_entries(items, mission)],
        "plannedHomePosition": _place(mission.home, "home"),
        "vehicleType": mission.vehicle_type,
        "version": 2,
    }
    if mission.cruise_speed is not None:
        (speed,) = finite("cruise_speed", mission.cruise_speed)
        if mission.cruise_speed <= 0.0:
            raise BadInput(f"expected a speed above 0, not {speed}", place="cruise_speed")
        header |= {"cruiseSpeed": speed, "hoverSpeed": speed}
    circles = list[dict[str, Any]]()
    polygons = list[dict[str, Any]]()
    for n, part in enumerate(mission.fence):
        place = f"fence[{n}]"
        entry = {"inclusion": part.inclusion, "version": 1}
        if isinstance(part, FencePolygon):
            ring = [finite(f"{place}: vertices[{k}]", *vertex) for k, vertex in enumerate(part.vertices)]
            polygons.append(entry | {"polygon": ring})
        else:
            (radius,) = finite(f"{place}: radius", part.radius)
            center = finite(f"{place}: center", *part.center)
            circles.append(entry | {"circle": {"center": center, "radius": radius}})
    ground = landing_ground_entry(mission)
    finite("landing_ground", *ground.values())
    return {
        **({"landingGround": ground} if ground else {}),
        "fileType": "Plan",
        "geoFence": {"circles": circles, "polygons": polygons, "version": 2},
        "groundStation": "QGroundControl",
        "mission": header,
        "rallyPoints": {
            "points": [_place(place, f"rally[{n}]") for n, place in enumerate(mission.rally)],
            "version": 2,
        },
        "version": 1,
    }


def _altitude_mode(items: Sequence[Item]) -> AltitudeMode:
    modes = {ALTITUDE_MODES[Frame(item.frame)] for item in items if item.frame in ALTITUDE_MODES}
    return AltitudeMode.MIXED if len(modes) > 1 else next(iter(modes), AltitudeMode.RELATIVE)


def _entries(items: Sequence[Item], mission: Mission) -> Iterator[dict[str, Any]]:
    parts = [replace(part, items=resolve_frames(part.items, mission.autopilot)) for part in mission.complex_items]
    for indices, of in entries(items, parts):
        simple = [_simple_item(index + 1, items[index]) for index in indices]
        yield simple[0] if of is None else as_document(of, indices.start + 1, simple)


def _check_written(number: int, item: Item, count: int) -> None:
    where = f"item {number} ({item.name})"
    if item.frame in ALTITUDE_MODES and not math.isfinite(item.altitude):
        raise BadInput(f"expected an altitude, not {item.altitude}", code="altitude-missing", place=where)
    if item.command == Command.DO_JUMP and item.params[0] not in range(1, count + 1):
        words = f"expected an item number from 1 to {count}, not {item.params[0]:g}"
        raise BadInput(words, code="jump-target", place=f"{where}: param1")


def _simple_item(number: int, item: Item) -> dict[str, Any]:
    written: dict[str, Any] = {
        "autoContinue": item.autocontinue,
        "command": int(item.command),
        "doJumpId": number,
        "frame": int(item.frame),
        "params": [tidy(value) for value in values_of(item)],
        "type": "SimpleItem",
    }
    if item.frame not in ALTITUDE_MODES:
        return written
    return written | {
        "AMSLAltAboveTerrain": None,
        "Altitude": tidy(item.altitude),
        "AltitudeMode": ALTITUDE_MODES[Frame(item.frame)],
    }


def _place(place: Geodetic, name: str) -> list[float | int | None]:
    numbers = (place.latitude_deg, place.longitude_deg, place.altitude)
    if not all(map(math.isfinite, numbers)):
        raise BadInput(f"expected latitude, longitude and altitude, not {numbers}", code="altitude-missing", place=name)
    return [tidy(number) for number in numbers]


def autopilot_in(node: Node, mav_type: int = QUADROTOR) -> Autopilot:
    if not isinstance(node.value, bool):
        of_firmware = [each for each in registered() if each.mav_autopilot == node.value]
        autopilot = min(of_firmware, key=lambda each: mav_type not in each.mav_types, default=None)
        if autopilot is not None:
            return autopilot
    numbers = sorted({(each.mav_autopilot, each.firmware_name) for each in registered()})
    raise node.wrong(" or ".join(f"{number} ({name})" for number, name in numbers), hint="name the plan's autopilot")


def _speed(node: Node) -> float | None:
    speed = node.number("a speed in meters per second")
    if speed > 0.0:
        return speed
    node.note(f"expected a speed above zero, not {speed:g}: ignored")
    return None


def _home(node: Node, items: Sequence[Item]) -> Geodetic:
    latitude, longitude, altitude = node.array(3, "numbers (latitude, longitude, altitude AMSL)")
    if altitude.value is not None:
        return Geodetic(latitude.degrees(90), longitude.degrees(), altitude.number("an altitude AMSL in meters"))
    amsl = [n for n, item in enumerate(items, 1) if item.frame == Frame.GLOBAL and item.command in FLOWN_TO]
    if amsl:
        altitude.note(f"expected home's altitude, which altitudes AMSL need: {name_items(amsl)}", Severity.ERROR)
    else:
        altitude.note("home has no altitude: taken as 0 m AMSL, which heights above home do not depend on")
    return Geodetic(latitude.degrees(90), longitude.degrees(), 0.0)


@dataclass(frozen=True)
class ListedItem:
    item: Item
    node: Node
    jump_id: int | None
    part_of: Node | None = None


def _items(listed: list[ListedItem]) -> Iterator[Item]:
    numbers: dict[int | None, list[int]] = {}
    for number, entry in enumerate(listed, start=1):
        numbers.setdefault(entry.jump_id, []).append(number)
    for entry in listed:
        item = entry.item
        if item.command == Command.DO_JUMP:
            target = entry.node["params"].array()[0]
            targets = numbers.get(target.whole("the doJumpId of an item"), [])
            if len(targets) != 1:
                raise target.wrong(f"the doJumpId of {'one item alone' if targets else 'an item outside surveys'}")
            item = replace(item, params=(float(targets[0]), *item.params[1:]))
        yield item


def _check_numbers(listed: list[ListedItem]) -> Iterator[Finding]:
    for due, entry in enumerate(listed, start=1):
        if entry.jump_id not in (None, due):
            words = f"item {due} has doJumpId {entry.jump_id}: an item may be missing or moved"
            yield Finding("file-numbers", Severity.WARNING, due, words)
            return


def _listed(node: Node) -> list[ListedItem]:
    whole = replace(node, asked={})  # keys of a complex item are written back
    kind = whole["type"]
    if kind.text() == "SimpleItem":
        return [read_item(node)]
    if kind.value != "ComplexItem":
        raise kind.wrong('"SimpleItem" or "ComplexItem"')
    items = (whole.get(TRANSECTS) or whole).get(ITEMS)
    if items is None or items.value == []:
        raise BadInput(
            f'expected the waypoints of the complex item "{whole["complexItemType"].text()}", but it holds none',
            place=whole.where,
            hint="open the plan in QGroundControl and save it; if it still holds none (StructureScan), upload it from "
            "there, and `ipoa-mission download` reads the waypoints",
        )
    # no jump may lead into it
    return [replace(read_item(child), jump_id=None, part_of=node) for child in items.array()]


def read_item(node: Node) -> ListedItem:
    command = node["command"].whole("a MAV_CMD number")
    frame = node["frame"].whole("a MAV_FRAME number", 0, 255)
    nodes = node["params"].array(7, "numbers")
    values = (math.nan if child.value is None else child.number("a number or null") for child in nodes)
    p1, p2, p3, p4, *place = values
    if frame != Frame.MISSION:
        may_be_here = command in (Command.NAV_TAKEOFF, Command.NAV_LAND) or command not in FLOWN_TO
        for child in nodes[4:6]:
            if not (child.value is None and may_be_here):
                child.degrees()
    _check_altitude(node, frame, place[2])
    latitude, longitude = (0.0 if math.isnan(value) else value for value in place[:2])
    altitude = 0.0 if math.isnan(place[2]) and (frame == Frame.MISSION or command not in FLOWN_TO) else place[2]
    jump_id = node.get("doJumpId")
    return ListedItem(
        Item(command, frame, (p1, p2, p3, p4), latitude, longitude, altitude, node["autoContinue"].flag()),
        node,
        None if jump_id is None else jump_id.whole("a number from 0 to 65535"),
    )


def _check_altitude(node: Node, frame: int, param7: float) -> None:
    """QGroundControl flies `AltitudeMode` and `Altitude`."""
    mode = node.given("AltitudeMode")
    altitude = node.given("Altitude")
    if mode is not None and frame != Frame.MISSION:
        frame_of: dict[int, Frame] = {mode: frame for frame, mode in ALTITUDE_MODES.items()}
        frame_of[AltitudeMode.CALCULATED] = Frame.GLOBAL
        of_mode = frame_of.get(mode.whole("a number from 0 to 5", 0, 5))
        if of_mode is not None and PLAIN_FRAME.get(frame, frame) != of_mode:
            means = f"QGroundControl flies in frame {of_mode:d}, other software in the item's frame {frame}"
            mode.note(means, Severity.ERROR)
        if mode.value == AltitudeMode.CALCULATED:
            altitude = node.given("AMSLAltAboveTerrain")
            if altitude is None:
                words = "QGroundControl flies above its own terrain, other software at params[6] AMSL"
                mode.note(f"without an AMSLAltAboveTerrain, {words}")
    if altitude is not None and not abs(altitude.number("an altitude in meters") - param7) <= 0.01:
        others = f"other software params[6], which is {json.dumps(tidy(param7))}"
        altitude.note(f"QGroundControl flies {altitude.value:g} m, {others}", Severity.ERROR)


def _fence(node: Node | None) -> tuple[FencePolygon | FenceCircle, ...]:
    if node is None:
        return ()
    polygons = node.usual("polygons", "taken as a fence without polygons")
    circles = node.usual("circles", "taken as a fence without circles")
    if not (polygons or circles):
        return ()
    if version := node.usual("version", "taken for a fence of version 2"):
        version.whole("1 or 2", 1, 2)
    if node.get("breachReturn"):
        node["breachReturn"].note("the return point is dropped")
    fence = list[FencePolygon | FenceCircle]()
    for part in _parts(polygons):
        vertices = [vertex.array(2, "numbers (latitude, longitude)") for vertex in part["polygon"].array()]
        if len(vertices) < 3:
            raise part["polygon"].wrong("three vertices or more")
        ring = tuple((latitude.degrees(), longitude.degrees()) for latitude, longitude in vertices)
        fence.append(FencePolygon(ring, part["inclusion"].flag()))
    for part in _parts(circles):
        latitude, longitude = part["circle"]["center"].array(2, "numbers (latitude, longitude)")
        radius = part["circle"]["radius"]
        if radius.number("a radius in meters") <= 0:
            raise radius.wrong("a radius above zero")
        center = (latitude.degrees(), longitude.degrees())
        fence.append(FenceCircle(center, radius.number(), part["inclusion"].flag()))
    return tuple(fence)


def _parts(listed: Node | None) -> list[Node]:
    return [] if listed is None else listed.array()


def _rally(node: Node | None) -> tuple[Geodetic, ...]:
    points = _parts(node.usual("points", NO_RALLY) if node else None)
    nodes = [point.array(3, "numbers (latitude, longitude, altitude)") for point in points]
    return tuple(Geodetic(lat.degrees(), lon.degrees(), alt.number("an altitude in meters")) for lat, lon, alt in nodes)


def findings_of_keys(plan: Node) -> Iterator[Finding]:
    for unread in gathered(_unread(plan)):
        words = unread.words.removeprefix(f"{unread.file}: ")
        if unread.may_limit:
            yield Finding("not-read", Severity.ERROR, None, words, unread.remedy)
        else:
            yield Finding("file", Severity.WARNING, None, words)


def _unread(plan: Node) -> Iterator[Unread]:
    has_limits = {"geoFence", "rallyPoints"} <= plan.value.keys()
    for place, (value, asked) in plan.asked.items():
        kind = re.sub(r"\[\d+\]", "[]", place)
        known = asked | WITHOUT_EFFECT.get(kind, set())
        for key, example in value.items():
            if key in known or example in (None, "", [], {}):
                continue
            of_a_limit = re.search("fence|rally|zone|polygon|circle|clusion", f"{kind} {key}".lower())
            may_limit = bool(of_a_limit) or (not kind and not has_limits)
            remedy = "spell it as QGroundControl does, or ignore this code where it limits no flight"
            what = f'key "{key}"'
            yield Unread(plan.file, what, place or "the file", json.dumps(example), may_limit=may_limit, remedy=remedy)
