"""The walls of the house: who may import whom, and what must stay out of the pure rooms."""

import ast
import re
from collections.abc import Iterator
from functools import cache
from itertools import chain
from pathlib import Path

import pytest

import ipoa_mission
from ipoa_mission.cli.app import VERBS

PACKAGE = Path(ipoa_mission.__file__).parent
#: Everyone may import these; they import nothing of ours.
GROUND = {"centimeters", "errors", "files", "finding", "rules", "geometry", "progress", "unread", "wind"}

#: Room by room, from the ground up: a room may import those that are named, and all of them stand above it.
_MISSION = {"mission/commands", "mission/items", "vehicles", "world"}  # what all above a mission know
_FLOWN = {"forecast/itinerary", "forecast/timing", *_MISSION}
_PLANNED = {"forecast", "forecast/deviation", "planning", "scenario", *_FLOWN}
MAY_IMPORT = {
    "compiled": set(),
    "mission/commands": set(),
    "world": {"compiled"},
    "optimize": set(),
    "survey/area": set(),
    "vehicles/energy": set(),
    "vehicles": {"mission/commands"},
    "maps": {"world"},
    "mission/items": _MISSION - {"mission/items"},
    "forecast/itinerary": _MISSION,
    "forecast/timing": _FLOWN - {"forecast/timing"},
    "mission": _MISSION,
    "scenario": {"vehicles", "vehicles/energy", "world", "maps", "survey/area"},
    "planning": {"compiled", "scenario", "world", "optimize", "vehicles"},
    "forecast/deviation": {"planning", "scenario", *_FLOWN},
    "forecast": {"forecast/deviation", "planning", "scenario", "mission", "vehicles/energy", *_FLOWN},
    "checks": {"mission", *_PLANNED},
    "routing": {"checks", "compiled", "mission", *_PLANNED},
    "survey": {"survey/area", "checks", "compiled", "mission", "routing", "vehicles/energy", *_PLANNED},
    "link": {"checks", "forecast", "mission", *_MISSION},
    "logs": {"link", "mission", *_MISSION},
    "logs/learn": {"logs", "link", "forecast", "vehicles/energy", *_FLOWN},
    "simulator": {"link", "mission", "forecast", "forecast/itinerary", *_MISSION},
    "report/exports": {"forecast", "checks", "scenario", "mission", "forecast/itinerary", *_MISSION},
}
#: A vehicle's own folder may lean on every room that asks it; nobody but the register looks into it.
VEHICLES = ("vehicles/arducopter", "vehicles/px4_multicopter")
_ASKING = {"forecast/timing", "forecast/deviation", "simulator", "link", "logs"}
for vehicle in VEHICLES:
    MAY_IMPORT[vehicle] = {"compiled", "forecast/itinerary", "mission", *_MISSION, *_ASKING}
_BELOW_THE_REPORT = set(MAY_IMPORT) - {"logs/learn", "simulator", "optimize", "maps", *VEHICLES}
MAY_IMPORT["report"] = _BELOW_THE_REPORT
MAY_IMPORT["flight"] = _BELOW_THE_REPORT | {"report", "maps"}
MAY_IMPORT["paper"] = _BELOW_THE_REPORT | {"report", "simulator", "optimize"}
MAY_IMPORT["studio"] = set(MAY_IMPORT) - {"paper", "optimize", *VEHICLES}
MAY_IMPORT["cli"] = set(MAY_IMPORT) - set(VEHICLES)

#: Modules that may own a socket, a clock or pymavlink; everything else is pure.
IMPURE = {
    "socket": {"link/channel.py", "studio/web_server.py"},
    "serial": {"link/channel.py"},
    "pymavlink": {"link/definitions.py"},
}
NO_CLOCK = GROUND - {"files"} | set(MAY_IMPORT) - {
    "link",
    "simulator",
    "report",
    "report/exports",
    "flight",
    "studio",
    "paper",
    "cli",
}

REPOSITORY = PACKAGE.parent
FILES = sorted(PACKAGE.rglob("*.py"))
TOOLS = sorted((REPOSITORY / "tools").rglob("*.py"))


def room(path: Path) -> str:
    """The room of a file; a part of a room with walls of its own is one."""
    return room_of("ipoa_mission." + ".".join(path.relative_to(PACKAGE).with_suffix("").parts))


def room_of(name: str) -> str:
    """The room of a module."""
    own = "/".join(name.split(".")[1:3])
    return own if own in MAY_IMPORT else name.split(".")[1]


def module(path: Path) -> str:
    return ".".join(path.relative_to(PACKAGE.parent).with_suffix("").parts).removesuffix(".__init__")


@cache
def tree(path: Path) -> ast.Module:
    return ast.parse(path.read_text(encoding="utf-8"))


@cache
def nodes(path: Path) -> tuple[ast.AST, ...]:
    return tuple(ast.walk(tree(path)))


@cache
def imports(path: Path) -> set[str]:
    found = set()
    for node in nodes(path):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module:
            assert node.level == 0, f"{path}: relative import"
            found |= {node.module} | {f"{node.module}.{alias.name}" for alias in node.names}
    return found


def allowed(here: str) -> set[str]:
    """What a room may import, itself among it."""
    return {here, "errors"} if here in GROUND else MAY_IMPORT.get(here, set()) | GROUND | {here}


def test_rooms_import_only_what_the_plan_of_the_house_allows() -> None:
    faces = {PACKAGE / "__init__.py", PACKAGE / "__main__.py", PACKAGE / "vehicles/__init__.py"}
    inside = [path for path in FILES if path not in faces]
    wrong = {
        f"{path.relative_to(PACKAGE)} imports {name}"
        for path in inside
        for name in imports(path)
        if name == "ipoa_mission" or (name.startswith("ipoa_mission.") and room_of(name) not in allowed(room(path)))
    }
    assert len(inside) > 200
    assert not wrong


def test_no_room_names_an_autopilot() -> None:
    """A vehicle is an object that rooms ask: outside its folder and the register nobody tells one from another."""
    named = re.compile(r"Autopilot\.(PX4|ARDUPILOT)\b|is_(ardupilot|px4)|[\"'](px4|ardupilot)[\"']")
    found = {
        f"{path.relative_to(PACKAGE)}: {line.strip()}"
        for path in FILES
        if path.relative_to(PACKAGE).parts[0] != "vehicles"
        for line in code_of(path)
        if named.search(line)
    }
    assert found == set()


@pytest.mark.parametrize("name", ["itinerary", "times_of", "flown_legs", "return_ways", "promise_of"])
def test_a_flight_is_worked_out_in_one_place(name: str) -> None:
    """Whoever asks for legs, times or a promise asks a forecast, which keeps them."""
    callers = {
        path.relative_to(PACKAGE).as_posix()
        for path in FILES
        for node in nodes(path)
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id == name
    }
    assert callers == {"forecast/forecast.py"}


def test_a_vehicle_is_known_before_its_flight_is() -> None:
    """What the register imports leans on no room above it: models and stand-ins are loaded when they are asked for."""
    modules, reached, ahead = {module(path): path for path in FILES}, set[str](), ["ipoa_mission.vehicles"]
    while ahead:
        name = ahead.pop()
        if name not in reached and name in modules:
            reached.add(name)
            ahead += imports(modules[name])
    rooms = {room_of(name) for name in reached if name != "ipoa_mission"}
    assert rooms - GROUND == {"vehicles", "mission/commands", *VEHICLES}


def test_the_rooms_stand_in_order() -> None:
    """A room is listed after all that it may import, so that there is no circle."""
    listed: list[str] = []
    for name, allowed in MAY_IMPORT.items():
        assert allowed <= set(listed) | {name}, name
        listed.append(name)


def code_of(path: Path) -> list[str]:
    """The lines of a file without its strings that are documentation and without comments."""
    whole = path.read_text(encoding="utf-8")
    lines = whole.splitlines()
    for node in nodes(path):
        if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant) and isinstance(node.value.value, str):
            for number in range(node.lineno - 1, node.end_lineno or node.lineno):
                lines[number] = ""
    return [line.split("  #")[0] for line in lines if not line.lstrip().startswith("#")]


def test_the_readme_has_every_room() -> None:
    text = (REPOSITORY / "README.md").read_text(encoding="utf-8")
    table = text[text.index("| room | what it knows |") : text.index("`tests/test_architecture.py` says")]
    named = re.findall(r"`(\w+)/?`", "\n".join(re.findall(r"^\| (.*?) \|", table, re.MULTILINE)))
    assert sorted(named) == sorted({name.split("/")[0] for name in MAY_IMPORT})


#: Where names are somebody else's: MAVLink's messages, and what the studio and its page tell each other.
VOCABULARIES = {"link/messages.py", "studio/answers.py", "studio/flight_answers.py", "studio/requests.py"}


def test_one_word_is_one_thing() -> None:
    """No two classes have one name; vehicles have parts of the same names, as they answer the same questions."""
    where = dict[str, set[str]]()
    for path in FILES:
        here = path.relative_to(PACKAGE)
        own = here.parts[0] == "vehicles" and f"vehicles/{here.parts[1]}" in VEHICLES
        for node in tree(path).body:
            if isinstance(node, ast.ClassDef) and not node.name.startswith("_") and str(here) not in VOCABULARIES:
                where.setdefault(node.name, set()).add("a vehicle's" if own else here.as_posix())
    assert not {name for name, places in where.items() if len(places) > 1}


def test_no_files_import_each_other_in_a_circle() -> None:
    """Not even inside a function, or for types only."""
    modules = {module(path): path for path in FILES}
    onward = {name: (imports(path) & modules.keys()) - {name} for name, path in modules.items()}
    while settled := {name for name, others in onward.items() if not others & onward.keys()}:
        for name in settled:
            del onward[name]
    assert not onward


def test_no_scripts_of_the_page_import_each_other_in_a_circle() -> None:
    scripts = {path.stem: path.read_text(encoding="utf-8") for path in (PACKAGE / "studio/web").glob("*.ts*")}
    onward = {name: set(re.findall(r'from "\./([\w-]+)"', text)) - {name} for name, text in scripts.items()}
    assert sum(map(len, onward.values())) > 50
    while settled := {name for name, others in onward.items() if not others & onward.keys()}:
        for name in settled:
            del onward[name]
    assert not onward


def test_sockets_serial_ports_and_pymavlink_live_in_one_module_each() -> None:
    owners = {path: path.relative_to(PACKAGE).as_posix() for path in FILES}
    wrong = {
        f"{here} imports {name}"
        for path, here in owners.items()
        for name in imports(path)
        if here not in IMPURE.get(name.split(".")[0], {here})
    }
    assert not wrong


def test_the_pure_rooms_have_no_clock_and_no_global_randomness() -> None:
    pure = [path for path in FILES if room(path) in NO_CLOCK and not path.stem.startswith("pilot")]  # of stand-ins
    unsteady = {"time", "datetime", "random", "asyncio", "threading", "subprocess"}
    assert len(pure) > 100
    assert not {path: imports(path) & unsteady for path in pure if imports(path) & unsteady}


LINES_OF_A_FILE, LINES_OF_A_FUNCTION, PARAMETERS = 400, 80, 8
OF_A_VERB = 12  # options, or groups of them, that a verb of the command line takes


def functions(files: list[Path]) -> Iterator[tuple[str, ast.FunctionDef | ast.AsyncFunctionDef]]:
    """Every function by file and name."""
    for path in files:
        for node in nodes(path):
            if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
                yield f"{path.relative_to(REPOSITORY).as_posix()}:{node.name}", node


def is_verb(name: str) -> bool:
    """Whether it is a verb of the command line: its parameters are its options, its docstring is its help."""
    return any(f"{verb.__code__.co_filename}:{verb.__name__}".endswith(f"/{name}") for verb in chain(*VERBS.values()))


def test_files_are_of_a_size_that_one_reads() -> None:
    long = {path for path in FILES + TOOLS if len(path.read_text(encoding="utf-8").splitlines()) > LINES_OF_A_FILE}
    assert long == set()


def test_functions_are_of_a_size_that_one_sees() -> None:
    long = set()
    for name, node in functions(FILES + TOOLS):
        first = node.body[1].lineno if is_verb(name) else node.lineno
        if (node.end_lineno or 0) - first >= LINES_OF_A_FUNCTION:
            long.add(name)
    assert long == set()


def test_functions_take_what_one_can_keep_in_mind() -> None:
    many = set()
    for name, node in functions(FILES + TOOLS):
        given = [*node.args.posonlyargs, *node.args.args, *node.args.kwonlyargs]
        most = OF_A_VERB if is_verb(name) else PARAMETERS
        if len([one for one in given if one.arg not in {"self", "cls"}]) > most:
            many.add(name)
    assert many == set()


def test_tools_use_what_is_public() -> None:
    private = {
        f"{path.relative_to(REPOSITORY)}: {name}"
        for path in TOOLS
        for name in imports(path)
        if name.startswith("ipoa_mission.") and any(part.startswith("_") for part in name.split("."))
    }
    assert not private


def called(path: Path) -> set[str]:
    """The names of the methods that a file calls."""
    return {
        node.func.attr for node in nodes(path) if isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute)
    }


#: Programs that another tool starts and speaks to, one of them by an interpreter that has nothing of ours.
STARTED = {"link_benchmark/clients.py", "link_benchmark/speed_clients.py", "planning_benchmark/mealpy_poa.py"}


def test_a_tool_tells_of_itself_before_it_writes_anything() -> None:
    """`--help`, or a word that it does not know, is never taken for a folder to write to, or passed over."""
    programs = [path for path in TOOLS if '__name__ == "__main__"' in path.read_text(encoding="utf-8")]
    deaf = {"/".join(path.parts[-2:]) for path in programs if "parse_args" not in called(path)}
    assert deaf == STARTED


def test_no_room_imports_tools_or_tests() -> None:
    roots = {name.split(".")[0] for path in FILES for name in imports(path)}
    assert "ipoa_mission" in roots
    assert not roots & {"tools", "tests"}


def test_only_the_command_line_imports_the_paper() -> None:
    """What reproduces the paper is a program of its own, told of by one verb."""
    users = {path for path in FILES if any(name.startswith("ipoa_mission.paper") for name in imports(path))}
    assert {path.relative_to(PACKAGE).as_posix() for path in users if room(path) != "paper"} == {"cli/reproducing.py"}
