"""Keep files that are dropped on the page."""

import math
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from ipoa_mission import FencePolygon, Item, Mission, read_mission
from ipoa_mission.autopilot.commands import WAYPOINTS, Command
from ipoa_mission.errors import BadInput, TooFar, WrongSuffix
from ipoa_mission.files import MISSIONS, unused, write_atomically
from ipoa_mission.geodesy import REACH, Geodetic, apart
from ipoa_mission.scenario.map_sections import MapFile
from ipoa_mission.studio.edits import parse_table
from ipoa_mission.studio.requests import Change, Put, Shift

LARGEST = 200_000_000  # [bytes]
MODELS = (".tif", ".tiff", ".hgt")
LOGS = (".tlog", ".bin", ".ulg")


def keep(
    name: str, content: bytes, folder: Path, suffixes: Sequence[str] = (*MapFile.suffixes, *MODELS, *MISSIONS, *LOGS)
) -> Path:
    """Write a dropped file next to the scenario, never over another."""
    bare = Path("".join(letter for letter in name.replace("\\", "/").rpartition("/")[2] if letter.isprintable()))
    stem = bare.stem.encode()[:200].decode(errors="ignore")  # valid on any system
    suffix = bare.suffix.lower()
    if not stem or stem.startswith(".") or suffix not in suffixes:
        raise WrongSuffix(f"expected a file that ends in {', '.join(suffixes)}", place=stem + bare.suffix or "the file")
    target = folder / f"{stem}{bare.suffix}"
    if not target.exists() or target.read_bytes() != content:
        target = unused(target)
        write_atomically(target, content)
    return target


def use_of(file: Path, scenario: str) -> dict[str, Any]:
    """Return a `map`, `elevation` model, `log`, or `mission` with its `changes`."""
    suffix = file.suffix.lower()
    if suffix in MISSIONS:
        changes = changes_of(read_mission(file), scenario)
        return {"kind": "mission", "file": file.name, "changes": [change.model_dump(mode="json") for change in changes]}
    kind = "elevation" if suffix in MODELS else "log" if suffix in LOGS else "map"
    return {"kind": kind, "file": file.name, "changes": []}


def changes_of(mission: Mission, scenario: str) -> list[Change]:
    """Return changes to a mission's home, places and fence; obstacles stay. Raises BadInput."""
    flown_to = (*WAYPOINTS, Command.NAV_TAKEOFF, Command.NAV_LAND)
    items = [item for item in mission.items if item.has_position and item.command in flown_to]
    if len(items) > 1 and items[-1].command == Command.NAV_LAND:
        *_, last, landing = items
        if abs(last.latitude_deg - landing.latitude_deg) + abs(last.longitude_deg - landing.longitude_deg) < 1e-6:
            items.pop()
    if len(items) < 2:
        raise BadInput("the mission has no two places to fly between", code="empty")
    table = parse_table(scenario)
    home = mission.home
    scenario_home = (float(table["home"]["longitude_deg"]), float(table["home"]["latitude_deg"]))
    distance = apart(home, Geodetic(scenario_home[1], scenario_home[0]))
    has_ground = table.get("terrain", {}).get("kind", "flat") != "flat"
    if distance > REACH and (table.get("obstacles") or table.get("maps") or has_ground):
        raise TooFar(
            f"expected within {REACH / 1000:g} km of the scenario's, not {distance / 1000:.0f} km away",
            hint="the obstacles on this map do not move: open a new scenario for this mission",
            place="home",
        )
    changes: list[Change] = [
        Shift(path=("home",), taken=scenario_home, put_down=(home.longitude_deg, home.latitude_deg)),
        Put(path=("home", "altitude_amsl"), value=round(home.altitude, 2)),
        Put(path=("start",), value=_place(items[0], mission)),
        Put(path=("goal",), value=_place(items[-1], mission)),
        Put(path=("via",), value=[_place(item, mission) for item in items[1:-1]]),
    ]
    fences = list(fences_of(mission))
    return [*changes, Put(path=("fence",), value=fences)] if fences else changes


def _place(item: Item, mission: Mission) -> dict[str, float]:
    place = {"latitude_deg": round(item.latitude_deg, 7), "longitude_deg": round(item.longitude_deg, 7)}
    height = mission.altitude_above_home(item)
    if math.isnan(height):
        return place | {"height_above_ground": round(item.altitude, 2)}
    return place | {"altitude_amsl": round(mission.home.altitude + height, 2)}


def fences_of(mission: Mission) -> Iterator[dict[str, Any]]:
    for fence in mission.fence:
        if isinstance(fence, FencePolygon):
            corners = [[round(lat, 7), round(lon, 7)] for lat, lon in fence.vertices]
            yield {"inclusion": fence.inclusion, "polygon_geodetic": corners}
        else:
            latitude, longitude, *_ = fence.center
            center = {"latitude_deg": round(latitude, 7), "longitude_deg": round(longitude, 7)}
            yield {"inclusion": fence.inclusion, "center": center, "radius": fence.radius}
