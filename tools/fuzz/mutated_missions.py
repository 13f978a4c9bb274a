"""Change missions and parameter files: other spelling, wrapping, frame or order, a part dropped or doubled, a cut."""

import json
import random
from collections.abc import Callable, Sequence
from copy import deepcopy
from dataclasses import replace
from pathlib import Path
from typing import Any

from ipoa_mission.autopilot.known_parameters import firmware_of
from ipoa_mission.geodesy import Geodetic
from ipoa_mission.mission.items import FencePolygon, Mission
from ipoa_mission.mission.mission_io import read_mission_file
from ipoa_mission.mission.parameter_file import read_parameter_file
from tools.fuzz.outcome import Reading

HOME = [47.397742, 8.545594, 488.0]
FENCE, RALLY = "geoFence", "rallyPoints"
OTHER_KEYS = {
    FENCE: ["geofence", "geo_fence", "fence", "Fence"], RALLY: ["rally", "rally_points", "safePoints"],
    "polygons": ["polygon", "areas", "inclusionPolygons"], "circles": ["circle", "cylinders"],
    "polygon": ["path", "vertices", "points"], "points": ["rally", "positions"], "inclusion": ["include", "exclusion"],
    "center": ["middle", "position"], "radius": ["radiusFeet", "diameter"], "vehicleType": ["vehicle_type"],
    "params": ["param", "parameters"], "doJumpId": ["id", "seq"], "Altitude": ["altitude"],
    "AltitudeMode": ["altitudeMode", "altMode"], "plannedHomePosition": ["home", "plannedHome"],
}  # fmt: skip
PARAMETERS = {
    "px4": {
        "MPC_XY_CRUISE": 7.5, "MPC_Z_V_AUTO_UP": 2.5, "MPC_Z_V_AUTO_DN": 1.2, "RTL_RETURN_ALT": 40.0,
        "NAV_ACC_RAD": 3.0, "MPC_ACC_HOR": 2.0, "MPC_YAW_MODE": 1.0,
    },
    "ardupilot": {
        "WPNAV_SPEED": 750.0, "WPNAV_SPEED_UP": 220.0, "WPNAV_SPEED_DN": 130.0, "WPNAV_ACCEL": 180.0,
        "RTL_ALT": 3500.0, "WPNAV_RADIUS": 150.0, "LAND_SPEED": 40.0,
    },
}  # fmt: skip
NEWER = {"WPNAV_SPEED": "WP_SPD", "WPNAV_SPEED_UP": "WP_SPD_UP", "RTL_ALT": "RTL_ALT_M", "LAND_SPEED": "LAND_SPD_MS"}


def place(chance: random.Random) -> list[float]:
    return [HOME[0] + round(chance.uniform(-0.002, 0.002), 7), HOME[1] + round(chance.uniform(-0.003, 0.003), 7)]


def plan(chance: random.Random) -> dict[str, Any]:
    items = [_item(22, [*HOME[:2], 20.0])]
    items += [_item(16, [*place(chance), float(chance.randint(20, 60))]) for _ in range(chance.randint(2, 5))]
    if chance.random() < 0.4:
        items.append(_item(177, [2.0, 1.0], frame=2))
    items.append(_item(20, [], frame=2))
    for n, item in enumerate(items, start=1):
        item["doJumpId"] = n
    square = [[HOME[0] + 0.01 * x, HOME[1] + 0.01 * y] for x, y in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
    circles = [{"circle": {"center": place(chance), "radius": 45.5}, "inclusion": False, "version": 1}]
    mission = {
        "cruiseSpeed": 12, "firmwareType": chance.choice([3, 12]), "globalPlanAltitudeMode": 1, "hoverSpeed": 6,
        "items": items, "plannedHomePosition": list(HOME), "vehicleType": 2, "version": 2,
    }  # fmt: skip
    return {
        "fileType": "Plan", "groundStation": "QGroundControl", "mission": mission, "version": 1,
        FENCE: {
            "circles": circles if chance.random() < 0.7 else [],
            "polygons": [{"inclusion": True, "polygon": square, "version": 1}],
            "version": 2,
        },
        RALLY: {"points": [[*place(chance), 30.0] for _ in range(chance.randint(1, 2))], "version": 2},
    }  # fmt: skip


def _item(command: int, numbers: list[float], frame: int = 3) -> dict[str, Any]:
    jump, params = command == 177, [0.0] * 4
    params[:2], numbers = (numbers, []) if jump else (params[:2], numbers)
    params[3:] = [None if frame == 3 else 0.0]  # type: ignore[list-item]
    item = {"autoContinue": True, "command": command, "frame": frame, "type": "SimpleItem"}
    item["params"] = [*params, *(numbers or [0.0] * 3)]
    if frame == 3:
        item |= {"AMSLAltAboveTerrain": None, "Altitude": numbers[2], "AltitudeMode": 1}
    return item


def objects(node: Any) -> list[dict[str, Any]]:
    inner = node.values() if isinstance(node, dict) else node if isinstance(node, list) else ()
    return [*([node] if isinstance(node, dict) else []), *(child for value in inner for child in objects(value))]


# --- changes of a plan: the same in another form, or less of it


def rename(document: dict[str, Any], chance: random.Random) -> None:
    of = chance.choice([node for node in objects(document) if node])
    key = chance.choice(list(of))
    others = [*OTHER_KEYS.get(key, []), key.lower(), key.upper(), f"{key}s", f"_{key}"]
    new = chance.choice(others)
    pairs = [(new if name == key else name, value) for name, value in of.items()]
    of.clear()
    of.update(pairs)


def drop(document: dict[str, Any], chance: random.Random) -> None:
    of = chance.choice([node for node in objects(document) if node])
    del of[chance.choice(list(of))]


def reorder(document: dict[str, Any], chance: random.Random) -> None:
    for node in objects(document):
        pairs = list(node.items())
        chance.shuffle(pairs)
        node.clear()
        node.update(pairs)
    if chance.random() < 0.4:
        items = document["mission"]["items"]
        items.insert(0, items.pop(chance.randrange(1, len(items))))


def wrap(document: dict[str, Any], chance: random.Random) -> None:
    fence, rally, items = document[FENCE], document[RALLY], document["mission"]["items"]
    match chance.randrange(9):
        case 0:
            names = ("latitude", "longitude", "altitude")
            rally["points"] = [dict(zip(names, point, strict=True)) for point in rally["points"]]
        case 1:
            fence["circles"] = [circle["circle"] | {"inclusion": circle["inclusion"]} for circle in fence["circles"]]
        case 2:
            fence["polygons"] = [{"path": polygon["polygon"], "inclusion": True} for polygon in fence["polygons"]]
        case 3:
            document["mission"][FENCE] = document.pop(FENCE)
        case 4:
            document[FENCE] = [fence]
        case 5:
            document["mission"]["items"] = [items]
        case 6:
            ring = fence["polygons"][0]["polygon"]
            ring.append(list(ring[0]))
        case 7:
            for item in items:
                params = item.pop("params")
                item |= {f"param{n}": value for n, value in enumerate(params[:4], start=1)} | {"coordinate": params[4:]}
        case _:
            fence["polygon"] = fence.pop("polygons")[0]["polygon"]
            fence["version"] = 1


def convert(document: dict[str, Any], chance: random.Random) -> None:
    items = [item for item in document["mission"]["items"] if item["frame"] == 3]
    match chance.randrange(5):
        case 0:
            chance.choice(items)["frame"] = chance.choice([6, 10, 11, 5, 0])
        case 1:
            chance.choice(items)["AltitudeMode"] = chance.choice([2, 3, 4])
        case 2:
            chance.choice(items)["Altitude"] *= 3.28084
        case 3:
            chance.choice([document[FENCE], document[RALLY], *document[FENCE]["polygons"]])["units"] = "ft"
        case _:
            numbers = [node for node in objects(document) if any(isinstance(v, float | int) for v in node.values())]
            of = chance.choice(numbers)
            key = chance.choice([key for key, value in of.items() if isinstance(value, float | int)])
            of[key] = str(of[key])


def double(document: dict[str, Any], chance: random.Random) -> None:
    lists = [document["mission"]["items"], document[FENCE]["polygons"]]
    chosen = chance.choice(lists)
    at = chance.randrange(len(chosen))
    chosen.insert(at, deepcopy(chosen[at]))


def lose(document: dict[str, Any], chance: random.Random) -> None:
    """Remove an item, but not the last, whose loss is not detectable."""
    items = document["mission"]["items"]
    del items[chance.randrange(len(items) - 1)]


PLAN_CHANGES: list[Callable[[dict[str, Any], random.Random], None]] = [
    rename, rename, drop, drop, reorder, wrap, wrap, convert, double, lose,
]  # fmt: skip


def changed_plan(chance: random.Random, _: Path) -> tuple[str, str, str]:
    before = plan(chance)
    text, after = json.dumps(before, indent=1), deepcopy(before)
    if chance.random() < 0.1:
        lines = text.split("\n")
        plain = [n for n, line in enumerate(lines) if ": " in line and not line.rstrip().endswith(("{", "["))]
        at = chance.choice(plain)
        own = lines[at].rstrip(",")
        lines[at : at + 1] = [own + ",", own.replace("0", "1") + lines[at][len(own) :]]
        return "twice", text, "\n".join(lines)
    if chance.random() < 0.1:
        return "cut", text, text[: chance.randrange(len(text.rstrip()))]
    change = chance.choice(PLAN_CHANGES)
    change(after, chance)
    return change.__name__, text, json.dumps(after, indent=1)


def changed_list(chance: random.Random, _: Path) -> tuple[str, str, str]:
    items = plan(chance)["mission"]["items"]
    rows = [[0, 1, 0, 16, 0, 0, 0, 0, *HOME, 1]]
    for n, item in enumerate(items, 1):
        rows.append([n, 0, item["frame"], item["command"], *(v or 0 for v in item["params"]), 1])
    lines = ["QGC WPL 110", *("\t".join(map(str, row)) for row in rows)]
    before, after = "\n".join(lines) + "\n", list(lines)
    at = chance.randrange(1, len(lines))
    fields = lines[at].split("\t")
    change = chance.choice(["wrap", "drop", "lose", "double", "reorder", "convert", "cut", "rename", "home"])
    match change:
        case "wrap":
            ends, between = chance.choice(["\r\n", "\r", "\n\n", "\n# more\n"]), chance.choice([" ", "\t", ",", ";"])
            return change, before, ends.join(line.replace("\t", between) for line in lines) + ends
        case "drop":
            del fields[chance.randrange(len(fields))]
            after[at] = "\t".join(fields)
        case "lose":
            del after[min(at, len(lines) - 2)]
        case "double":
            after.insert(at, after[at])
        case "reorder":
            after.insert(1, after.pop(max(at, 2)))
        case "convert":
            n = chance.randrange(4, 11)
            spelled = fields[n].replace(".", ","), f"{fields[n]}m", f"{fields[n]}ft", f"{float(fields[n]):.12e}"
            fields[n] = chance.choice(spelled)
            after[at] = "\t".join(fields)
        case "rename":
            after[0] = chance.choice(["QGC WPL 120", "QGC WPL 100", "WPL 110", "QGC  WPL 110"])
        case "home":
            n, frame = chance.choice([(2, "3"), (2, "10"), (3, "0"), (3, "22")])
            after[1] = "\t".join(frame if m == n else field for m, field in enumerate(after[1].split("\t")))
        case _:
            return change, before, torn(before, chance)
    return change, before, "\n".join(after) + "\n"


def torn(text: str, chance: random.Random) -> str:
    """Return the beginning of a text that ends inside a line: the loss of whole lines is not detectable."""
    part = text[: chance.randrange(1, len(text) - 1)]
    return part.rstrip("\n")[:-1] if part.endswith("\n") or text[len(part)] == "\n" else part


def changed_parameters(chance: random.Random, _: Path) -> tuple[str, str, str]:
    """Return the change, a parameter file of a ground station, and the changed file."""
    values = PARAMETERS[chance.choice([*PARAMETERS])]
    style = chance.choice(["{},{}", "{:16} {}", "1\t1\t{}\t{}\t9"])
    lines = [style.format(name, f"{value:.6f}") for name, value in values.items()]
    before, after = "# Vehicle: Quadrotor\n" + "\n".join(lines) + "\n", list(lines)
    at = chance.randrange(len(lines))
    name = [*values][at]
    change = chance.choice(["rename", "convert", "double", "reorder", "drop", "wrap", "other vehicle", "cut", "unit"])
    end = "\n"
    match change:
        case "rename":
            names = name[1:], f"{name}X", name.replace("_", "", 1), name.lower(), name.replace("SPEED", "SPD")
            after[at] = lines[at].replace(name, chance.choice(names))
        case "convert":
            value, short = f"{values[name]:.6f}", f"{values[name]:g}"
            spelled = value.replace(".", ","), f"{value}m", f"{values[name]:e}", short, f"+{value}", f"1_{value}"
            after[at] = lines[at].replace(value, chance.choice(spelled))
        case "double":
            at = chance.randrange(len(lines))
            twice = values[[*values][at]]
            after.append(lines[at].replace(f"{twice:.6f}", chance.choice(["1.0", f"{twice:g}"])))
        case "reorder":
            chance.shuffle(after)
        case "drop":
            fields = lines[at].replace(",", " ").split()
            del fields[chance.randrange(len(fields))]
            after[at] = " ".join(fields)
        case "wrap":
            end = chance.choice(["\r\n", "\n\n", "\n# so\n", " # why\n"])
        case "other vehicle":
            after.append(chance.choice([f"2 1 {name} 1 9", f"1 100 {name} 1 9", f"2 1 {name} 1 6"]))
            after[at] = chance.choice([lines[at], lines[at] + "\n# Vehicle: Fixed Wing"])
        case "unit" if name in NEWER:
            after[at] = style.format(NEWER[name], f"{values[name] / chance.choice([1, 100]):.6f}")
            if chance.random() < 0.3:
                after.append(lines[at])
        case "cut":
            return change, before, torn(before, chance)
    return change, before, "# Vehicle: Quadrotor\n" + end.join(after) + end


def read_mission_text(path: Path) -> Reading:
    file = read_mission_file(path)
    return Reading(_told(file.mission), frozenset(map(str, file.findings)))


def _told(mission: Mission) -> dict[str, Any]:
    """Return all that is flown: heights above home; speeds from items only."""
    items = [
        (item.command, [f"{p:.6g}" for p in item.params], item.autocontinue, f"{item.latitude_deg:.8f}",
         f"{item.longitude_deg:.8f}", f"{mission.altitude_above_home(item):.3f}")
        for item in mission.items
    ]  # fmt: skip
    home = Geodetic(mission.home.latitude_deg, mission.home.longitude_deg, round(mission.home.altitude, 3))
    fence = {str(replace(p, vertices=_open(p.vertices)) if isinstance(p, FencePolygon) else p) for p in mission.fence}
    rally = sorted(map(str, mission.rally))
    return {"items": items, "home": home, "fence": sorted(fence), "rally": rally, "vehicle": mission.vehicle_type}


def _open(ring: Sequence[tuple[float, float]]) -> tuple[tuple[float, float], ...]:
    return tuple(ring[:-1] if ring[0] == ring[-1] else ring)


def read_parameter_text(path: Path) -> Reading:
    """Read a parameter file, by the oldest names and units."""
    read = read_parameter_file(path)
    flies = firmware_of(read.parameters)
    values = read.parameters if flies is None else flies.parameter_table.by_old_names(read.parameters)
    return Reading({n: round(v, 3) for n, v in values.items()}, frozenset(thing.words for thing in read.unread))
