"""The walls of the house: who may import whom, and what must stay out of the pure rooms."""

import ast
from pathlib import Path

import pytest

import ipoa_mission

PACKAGE = Path(ipoa_mission.__file__).parent
#: Everyone may import these; they import nothing of ours.
GROUND = {"errors", "files", "geometry", "wind"}

#: Room by room, from the ground up: a room may import those that are named, and all of them stand above it.
MAY_IMPORT = {
    "commands": set(),
    "world": set(),
    "optimize": set(),
    "energy": set(),
    "autopilots": {"commands"},
    "maps": {"world"},
    "items": {"autopilots", "commands", "world"},
    "itinerary": {"items", "autopilots", "commands", "world"},
    "timing": {"itinerary", "items", "autopilots", "commands", "world"},
    "mission": {"items", "autopilots", "commands", "world"},
    "scenario": {"autopilots", "world", "maps", "energy"},
    "planning": {"scenario", "world", "optimize", "autopilots"},
    "tube": {"planning", "scenario", "timing", "itinerary", "items", "autopilots", "commands", "world"},
    "checks": {
        "tube",
        "timing",
        "planning",
        "scenario",
        "mission",
        "itinerary",
        "items",
        "autopilots",
        "commands",
        "world",
    },
    "routing": {
        "tube",
        "checks",
        "planning",
        "scenario",
        "timing",
        "itinerary",
        "items",
        "autopilots",
        "commands",
        "world",
    },
    "exports": {"checks", "scenario", "itinerary", "items", "autopilots", "commands", "world"},
    "link": {"checks", "mission", "items", "autopilots", "commands", "world"},
    "simulator": {"link", "mission", "items", "autopilots", "commands", "world"},
    "report": set(),
    "flight": set(),
    "experiments": set(),
}
_BELOW_THE_REPORT = set(MAY_IMPORT) - {"report", "flight", "experiments", "simulator", "optimize", "maps"}
MAY_IMPORT["report"] = _BELOW_THE_REPORT
MAY_IMPORT["flight"] = _BELOW_THE_REPORT | {"report", "maps"}
MAY_IMPORT["experiments"] = _BELOW_THE_REPORT | {"report", "simulator", "optimize"}
MAY_IMPORT["cli"] = set(MAY_IMPORT)

#: Modules that may own a socket, a clock or pymavlink; everything else is pure.
IMPURE = {
    "socket": {"link/channel.py"},
    "serial": {"link/channel.py"},
    "pymavlink": {"link/codec.py", "link/dataflash.py"},  # messages on the wire, and the format of a log
}
NO_CLOCK = GROUND - {"files"} | set(MAY_IMPORT) - {
    "link",
    "simulator",
    "report",
    "flight",
    "experiments",
    "cli",
    "exports",
}

FILES = sorted(PACKAGE.rglob("*.py"))


def room(path: Path) -> str:
    return path.relative_to(PACKAGE).parts[0].removesuffix(".py")


def imports(path: Path) -> set[str]:
    found = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module:
            assert node.level == 0, f"{path}: relative import"
            found |= {node.module} | {f"{node.module}.{alias.name}" for alias in node.names}
    return found


@pytest.mark.parametrize("path", FILES, ids=lambda p: str(p.relative_to(PACKAGE)))
def test_rooms_import_only_what_the_plan_of_the_house_allows(path: Path) -> None:
    here = room(path)
    if here in {"__init__", "__main__"}:  # the public face
        return
    allowed = MAY_IMPORT.get(here, set()) | GROUND | {here} if here not in GROUND else {here, "errors"}
    for name in imports(path):
        if name.startswith("ipoa_mission."):
            assert name.split(".")[1] in allowed, f"{path.relative_to(PACKAGE)} may not import {name}"
        assert name != "ipoa_mission", f"{path.relative_to(PACKAGE)} imports the public face"


def test_the_rooms_stand_in_order() -> None:
    """A room is listed after all that it may import, so that there is no circle."""
    listed: list[str] = []
    for name, allowed in MAY_IMPORT.items():
        assert allowed <= set(listed) | {name}, name
        listed.append(name)


@pytest.mark.parametrize("path", FILES, ids=lambda p: str(p.relative_to(PACKAGE)))
def test_sockets_serial_ports_and_pymavlink_live_in_one_module_each(path: Path) -> None:
    here = path.relative_to(PACKAGE).as_posix()
    for name in imports(path):
        owners = IMPURE.get(name.split(".")[0])
        assert owners is None or here in owners, f"{here} may not import {name}"


@pytest.mark.parametrize("path", [p for p in FILES if room(p) in NO_CLOCK], ids=lambda p: str(p.relative_to(PACKAGE)))
def test_the_pure_rooms_have_no_clock_and_no_global_randomness(path: Path) -> None:
    assert not imports(path) & {"time", "datetime", "random", "asyncio", "threading", "subprocess"}, path
