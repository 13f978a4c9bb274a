"""The walls of the house: who may import whom, and what must stay out of the pure rooms."""

import ast
from pathlib import Path

import pytest

import ipoa_mission

PACKAGE = Path(ipoa_mission.__file__).parent
#: Everyone may import these; they import nothing of ours.
GROUND = {"errors", "files", "geometry", "touchdown", "vehicle", "wind"}

MAY_IMPORT = {
    "world": set(),
    "optimize": set(),
    "maps": {"world"},
    "energy": set(),
    "scenario": {"world", "maps", "energy"},
    "planning": {"scenario", "world", "optimize"},
    "mission": {"scenario", "world", "planning", "timing"},
    "timing": {"mission", "world"},
    "link": {"mission", "world"},
    "simulator": {"link", "mission", "world"},
    "experiments": {"optimize", "planning", "scenario", "world", "mission", "timing", "simulator", "link", "report"},
    "flight": {"scenario", "maps", "world", "planning", "mission", "timing", "link", "energy", "report"},
    "report": {"scenario", "world", "planning", "mission", "timing", "link", "energy"},
}
#: `mission` and `timing` meet in data only: timing may know these files of mission and no others.
TIMING_KNOWS_OF_MISSION = {"ipoa_mission.mission.items"}

#: Modules that may own a socket, a clock or pymavlink; everything else is pure.
IMPURE = {
    "socket": {"link/channel.py"},
    "serial": {"link/channel.py"},
    "pymavlink": {"link/codec.py", "link/dataflash.py"},  # messages on the wire, and the format of a log
}
NO_CLOCK = {
    "world",
    "maps",
    "energy",
    "optimize",
    "planning",
    "mission",
    "timing",
    "geometry",
    "scenario",
    "touchdown",
    "vehicle",
    "wind",
    "errors",
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
    if here in {"cli", "__init__", "__main__"}:
        return
    allowed = MAY_IMPORT.get(here, set()) | GROUND | {here} if here not in GROUND else {here, "errors"}
    for name in imports(path):
        if name.startswith("ipoa_mission."):
            assert name.split(".")[1] in allowed, f"{path.relative_to(PACKAGE)} may not import {name}"
        assert name != "ipoa_mission", f"{path.relative_to(PACKAGE)} imports the public face"


@pytest.mark.parametrize("path", [p for p in FILES if room(p) == "timing"], ids=lambda p: p.name)
def test_timing_knows_only_the_items_of_a_mission(path: Path) -> None:
    known = {name for name in imports(path) if name.startswith("ipoa_mission.mission")}
    assert all(any(name == ok or name.startswith(ok + ".") for ok in TIMING_KNOWS_OF_MISSION) for name in known), known


@pytest.mark.parametrize("path", FILES, ids=lambda p: str(p.relative_to(PACKAGE)))
def test_sockets_serial_ports_and_pymavlink_live_in_one_module_each(path: Path) -> None:
    here = path.relative_to(PACKAGE).as_posix()
    for name in imports(path):
        owners = IMPURE.get(name.split(".")[0])
        assert owners is None or here in owners, f"{here} may not import {name}"


@pytest.mark.parametrize("path", [p for p in FILES if room(p) in NO_CLOCK], ids=lambda p: str(p.relative_to(PACKAGE)))
def test_the_pure_rooms_have_no_clock_and_no_global_randomness(path: Path) -> None:
    assert not imports(path) & {"time", "datetime", "random", "asyncio", "threading", "subprocess"}, path
