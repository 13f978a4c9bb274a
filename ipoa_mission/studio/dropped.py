import math
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from ipoa_mission.autopilot.commands import WAYPOINTS, Command
from ipoa_mission.errors import BadInput, TooFar, WrongSuffix
from ipoa_mission.files import MISSIONS, write_atomically
from ipoa_mission.maps.map_reader import READERS
from ipoa_mission.mission.items import FencePolygon, Item, Mission
from ipoa_mission.mission.mission_io import read_mission
from ipoa_mission.studio.edits import parse_table
from ipoa_mission.studio.requests import Change, Put, Shift
from ipoa_mission.world.frame import REACH, Geodetic, apart

LARGEST = 200_000_000  # [bytes]
LONGEST = 200  # without the suffix [bytes]
MODELS = (".tif", ".tiff", ".hgt")
LOGS = (".tlog", ".bin", ".ulg")
KEPT_SUFFIXES = (*READERS, *MODELS, *MISSIONS, *LOGS)
PLACES = (*WAYPOINTS, Command.NAV_TAKEOFF, Command.NAV_LAND)


def keep(name: str, content: bytes, folder: Path, suffixes: Sequence[str] = KEPT_SUFFIXES) -> Path:
    """Write a dropped file next to the scenario, never over another."""
    plain = _plain(name)
    stem, suffix = Path(plain).stem, Path(plain).suffix.lower()
    if not plain or plain.startswith(".") or suffix not in suffixes:
        raise WrongSuffix(f"expected a file that ends in {', '.join(suffixes)}", place=plain or "the file")
    number, target = 1, folder / plain
    while target.exists() and target.read_bytes() != content:
        number += 1
        target = folder / f"{stem}-{number}{suffix}"
    if not target.exists():
        write_atomically(target, content)
    return target


def log_named(name: str) -> str:
    if Path(name).suffix.lower() not in LOGS:
        raise WrongSuffix(f"expected a log of a flight: {', '.join(LOGS)}", place=Path(name).name)
    return Path(name).name


def _plain(name: str) -> str:
    path = Path("".join(letter for letter in name.replace("\\", "/").rpartition("/")[2] if letter.isprintable()))
    return path.stem.encode()[:LONGEST].decode(errors="ignore") + path.suffix


def use_of(file: Path, scenario: str) -> dict[str, Any]:
    """Return a `map`, `elevation` model, `log`, or `mission` with its `changes`."""
    suffix = file.suffix.lower()
    if suffix in MISSIONS:
        changes = changes_of(read_mission(file), scenario)
        return {"kind": "mission", "file": file.name, "changes": [change.model_dump(mode="json") for change in changes]}
    kind = "elevation" if suffix in MODELS else "log" if suffix in LOGS else "map"
    return {"kind": kind, "file": file.name, "changes": []}


def changes_of(mission: Mission, scenario: str) -> list[Change]:
    """Return changes to a mission's home, places and fence; obstacles stay."""
    items = [item for item in mission.items if item.has_position and item.command in PLACES]
    if len(items) > 1 and items[-1].command == Command.NAV_LAND and _same_place(items[-2], items[-1]):
        items.pop()
    if len(items) < 2:
        raise BadInput("the mission has no two places to fly between", code="empty")
    table, home = parse_table(scenario), mission.home
    there = table["home"]
    taken = (float(there["longitude_deg"]), float(there["latitude_deg"]))
    away = apart(home, Geodetic(taken[1], taken[0]))
    if away > REACH and _stays(table):
        raise TooFar(
            f"expected within {REACH / 1000:g} km of the scenario's, not {away / 1000:.0f} km away",
            hint="the obstacles on this map do not move: open a new scenario for this mission",
            place="home",
        )
    changes: list[Change] = [
        Shift(path=("home",), taken=taken, put_down=(home.longitude_deg, home.latitude_deg)),
        Put(path=("home", "altitude_amsl"), value=round(home.altitude, 2)),
        Put(path=("start",), value=_place(items[0], mission)),
        Put(path=("goal",), value=_place(items[-1], mission)),
        Put(path=("via",), value=[_place(item, mission) for item in items[1:-1]]),
    ]
    fences = list(fences_of(mission))
    return [*changes, Put(path=("fence",), value=fences)] if fences else changes


def _stays(table: dict[str, Any]) -> bool:
    return bool(table.get("obstacles") or table.get("maps")) or table.get("terrain", {}).get("kind", "flat") != "flat"


def _place(item: Item, mission: Mission) -> dict[str, float]:
    where = {"latitude_deg": round(item.latitude_deg, 7), "longitude_deg": round(item.longitude_deg, 7)}
    height = mission.altitude_above_home(item)
    if math.isnan(height):
        return where | {"height_above_ground": round(item.altitude, 2)}
    return where | {"altitude_amsl": round(mission.home.altitude + height, 2)}


def _same_place(one: Item, other: Item) -> bool:
    apart = abs(one.latitude_deg - other.latitude_deg) + abs(one.longitude_deg - other.longitude_deg)
    return apart < 1e-6


def fences_of(mission: Mission) -> Iterator[dict[str, Any]]:
    for fence in mission.fence:
        if isinstance(fence, FencePolygon):
            corners = [[round(lat, 7), round(lon, 7)] for lat, lon in fence.vertices]
            yield {"inclusion": fence.inclusion, "polygon_geodetic": corners}
        else:
            center = dict(
                zip(("latitude_deg", "longitude_deg"), (round(degrees, 7) for degrees in fence.center), strict=True)
            )
            yield {"inclusion": fence.inclusion, "center": center, "radius": fence.radius}
