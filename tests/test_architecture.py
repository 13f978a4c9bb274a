"""The rules of imports between rooms."""

import ast
import re
from collections.abc import Iterator
from functools import cache
from itertools import chain
from pathlib import Path

import pytest

import ipoa_mission
from ipoa_mission.cli.app import VERBS
from tests.conftest import LONGEST
from tools.census import nodes, tree

PACKAGE = Path(ipoa_mission.__file__).parent
ON_GEOMETRY = {"geodesy", "ground"}
#: Everyone may import these.
GROUND = {
    "centimeters",
    "errors",
    "files",
    "finding",
    "interrupts",
    "rules",
    "geometry",
    "progress",
    "unread",
    "wind",
    *ON_GEOMETRY,
}

#: From the ground up: the rooms that each imports, listed before it.
MAY_IMPORT: dict[str, set[str]] = {
    "compiled": set(),
    "world": {"compiled"},
    "maps": {"world"},
    "optimize": set(),
    "autopilot": set(),
    "mission": {"autopilot"},
    "scenario": {"autopilot", "maps", "world"},
    "planning": {"compiled", "optimize", "scenario", "world"},
    "forecast": {"autopilot", "mission", "planning", "scenario", "world"},
    "checks": {"autopilot", "forecast", "mission", "scenario"},
    "routing": {"autopilot", "compiled", "forecast", "mission", "planning", "scenario", "world"},
    "link": {"autopilot", "checks", "mission"},
    "logs": {"autopilot", "link", "mission"},
    "simulator": {"autopilot", "link", "mission"},
    "report": {"autopilot", "forecast", "logs", "mission", "planning", "scenario", "world"},
    "flight": {"autopilot", "checks", "forecast", "link", "mission", "planning", "report", "routing", "scenario"},
    "vehicles": {"autopilot", "compiled", "forecast", "link", "logs", "mission", "simulator"},
    "options": {"autopilot", "link", "mission"},
    "terminal": set(),
    "cli": {
        *("autopilot", "checks", "flight", "forecast", "link", "logs", "mission", "options", "report", "scenario"),
        *("simulator", "terminal"),
    },
    "paper": {"cli", "optimize", "options", "planning", "terminal"},
    "learn": {"autopilot", "forecast", "logs", "options", "terminal"},
    "fleet": {"options", "terminal"},
    "survey": {
        *("checks", "cli", "compiled", "forecast", "maps", "mission", "options", "planning", "report", "routing"),
        *("scenario", "terminal", "world"),
    },
    "studio": {
        *("autopilot", "checks", "flight", "forecast", "link", "mission", "options", "planning", "report", "scenario"),
        *("simulator", "survey", "terminal"),
    },
}
#: Rooms of plug-ins, found by entry points: no other room imports them.
PLUG_INS = {"vehicles", "paper", "learn", "survey", "studio", "fleet"}
VEHICLES = ("arducopter", "px4_multicopter")
USE_PUBLIC_API = PLUG_INS - {"vehicles"}  # they import from `ipoa_mission` where they can

#: May own a socket, a clock or pymavlink.
IMPURE = {
    "socket": {"link/channel.py", "studio/web_server.py"},
    "serial": {"link/channel.py"},
    "pymavlink": {"link/definitions.py"},
}
MAY_HAVE_A_CLOCK = {"files", "link", "simulator", "report", "flight", "survey", "studio", "paper", "cli", "learn"}

REPOSITORY = PACKAGE.parent
FILES = sorted(PACKAGE.rglob("*.py"))
TOOLS = sorted((REPOSITORY / "tools").rglob("*.py"))


def room(path: Path) -> str:
    return path.relative_to(PACKAGE).with_suffix("").parts[0]


def room_of(name: str) -> str:
    return name.split(".")[1]


def module(path: Path) -> str:
    return ".".join(path.relative_to(PACKAGE.parent).with_suffix("").parts).removesuffix(".__init__")


@cache
def imports(path: Path) -> set[str]:
    names = set()
    for node in nodes(path):
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module:
            assert node.level == 0, f"{path}: relative import"
            names |= {node.module} | {f"{node.module}.{alias.name}" for alias in node.names}
    return names


def allowed(here: str) -> set[str]:
    if here in ON_GEOMETRY:
        return {here, "geometry"}
    return {here, "errors"} if here in GROUND else MAY_IMPORT.get(here, set()) | GROUND | {here}


def test_rooms_import_the_listed_rooms() -> None:
    modules = {module(path) for path in FILES}
    found: dict[str, set[str]] = {name: set() for name in MAY_IMPORT}
    wrong = set()
    for path in FILES:
        here = room(path)
        if here in {"__init__", "__main__"}:
            continue
        for name in imports(path):
            is_public = name == "ipoa_mission" and here not in USE_PUBLIC_API
            is_inside = name in modules and name.count(".") > 0
            if is_public or (is_inside and room_of(name) not in allowed(here)):
                wrong.add(f"{path.relative_to(PACKAGE)} imports {name}")
            if is_inside and here in found:
                found[here].add(room_of(name))
    assert not wrong
    assert {name: rooms - GROUND - {name} for name, rooms in found.items()} == MAY_IMPORT


def test_no_room_names_an_autopilot() -> None:
    """A vehicle is an object that rooms ask."""
    named = re.compile(r"Autopilot\.(PX4|ARDUPILOT)\b|is_(ardupilot|px4)|[\"'](px4|ardupilot)[\"']|\bArduCopter\b")
    naming = {
        f"{path.relative_to(PACKAGE)}: {line.strip()}"
        for path in FILES
        if path.relative_to(PACKAGE).parts[0] != "vehicles"
        for line in code_of(path)
        if named.search(line)
    }
    assert naming == set()


@pytest.mark.parametrize("name", ["itinerary", "times_of", "flown_legs", "trace_returns", "clearance_guarantee_of"])
def test_a_flight_is_worked_out_in_one_place(name: str) -> None:
    """A forecast keeps legs, times and guarantees."""
    callers = {
        path.relative_to(PACKAGE).as_posix()
        for path in FILES
        for node in nodes(path)
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id == name
    }
    assert callers == {"forecast/forecast.py"}


#: Parts of rooms from the ground up: none imports a later one, nor the rest of its room.
CONTINGENCY = """
contingency_samples return_routes enlarged_airspace contingency_paths shortfalls contingencies energy_budget
contingencies_now
"""
FORECAST = "itinerary", "timing", "flight_energy", "deviation", "forecast"
PARTS = (
    tuple(f"forecast/{module}" for module in (*FORECAST, *(f"contingency/{module}" for module in CONTINGENCY.split()))),
    ("report/table", "report/exports"),
)


def test_parts_of_rooms_import_no_later_ones() -> None:
    wrong = set()
    for parts in PARTS:
        for n, part in enumerate(parts):
            own = tuple(f"ipoa_mission.{part.replace('/', '.')}" for part in parts[: n + 1])
            files = [*PACKAGE.glob(f"{part}.py"), *(PACKAGE / part).rglob("*.py")]
            assert files, part
            for path in files:
                inside = {name for name in imports(path) if name.startswith(f"ipoa_mission.{part.split('/')[0]}.")}
                wrong |= {f"{path.relative_to(PACKAGE)} imports {name}" for name in inside if not name.startswith(own)}
    assert not wrong


def test_a_vehicle_is_known_before_its_flight_is() -> None:
    """Models and mocks are loaded at first use; a kernel brakes."""
    modules, reached = {module(path): path for path in FILES}, set[str]()
    ahead = {f"ipoa_mission.vehicles.{vehicle}.vehicle" for vehicle in VEHICLES}
    while ahead:
        name = ahead.pop()
        if name not in reached and name in modules:
            reached.add(name)
            ahead |= imports(modules[name])
    rooms = {room_of(name) for name in reached if name != "ipoa_mission"}
    assert rooms - GROUND == {"autopilot", "compiled", "vehicles"}


def test_plug_ins_are_not_imported() -> None:
    """A plug-in can be taken out by deleting its folder and its lines among the entry points.

    Without the survey there is no studio.
    """
    modules = {module(path) for path in FILES}
    wrong = {
        f"{path.relative_to(PACKAGE)} imports {name}"
        for path in FILES
        for name in imports(path)
        if name in modules and name.count(".") and room_of(name) in PLUG_INS - {room(path)}
        if (room(path), room_of(name)) != ("studio", "survey")  # its panels
    }
    assert not wrong


def test_the_rooms_stand_in_order() -> None:
    """A room is listed after all that it may import."""
    listed: list[str] = []
    for name, rooms in MAY_IMPORT.items():
        assert rooms <= set(listed) | {name}, name
        listed.append(name)


def code_of(path: Path) -> list[str]:
    """Return lines without docstrings and comments."""
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
    assert sorted(named) == sorted(MAY_IMPORT)


#: MAVLink's names, and those between studio and page.
VOCABULARIES = {"link/messages.py", "studio/answers.py", "studio/flight_answers.py", "studio/requests.py"}


def test_one_word_is_one_thing() -> None:
    """No two classes have one name, except parts of vehicles."""
    where = dict[str, set[str]]()
    for path in FILES:
        here = path.relative_to(PACKAGE)
        own = here.parts[0] == "vehicles" and here.parts[1] in VEHICLES
        for node in tree(path).body:
            if isinstance(node, ast.ClassDef) and not node.name.startswith("_") and str(here) not in VOCABULARIES:
                where.setdefault(node.name, set()).add("a vehicle's" if own else here.as_posix())
    assert not {name for name, places in where.items() if len(places) > 1}


def test_no_file_imports_itself() -> None:
    assert not {path for path in FILES if module(path) in imports(path)}


def test_no_files_import_each_other_in_a_circle() -> None:
    """Not even inside a function, or for types only."""
    modules = {module(path): path for path in FILES}
    onward = {name: (imports(path) & modules.keys()) - {name} for name, path in modules.items()}
    while settled := {name for name, others in onward.items() if not others & onward.keys()}:
        for name in settled:
            del onward[name]
    assert not onward


def test_a_module_runs_as_a_program_after_its_last_definition() -> None:
    for path in FILES:
        guards = [
            n for n, node in enumerate(tree(path).body) if isinstance(node, ast.If) and "__main__" in ast.dump(node)
        ]
        assert guards in ([], [len(tree(path).body) - 1]), module(path)


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
    pure = [
        path for path in FILES if room(path) not in MAY_HAVE_A_CLOCK and not path.stem.startswith("flight_controller")
    ]  # of stand-ins
    unsteady = {"time", "datetime", "random", "asyncio", "threading", "subprocess"}
    assert len(pure) > 100
    assert not {path: imports(path) & unsteady for path in pure if imports(path) & unsteady}


LINES_OF_A_FILE, LINES_OF_A_FUNCTION, PARAMETERS = 400, 80, 8
BY_PLACE = 5  # arguments
OF_A_VERB = 12  # or groups of them


def functions(files: list[Path]) -> Iterator[tuple[str, ast.FunctionDef | ast.AsyncFunctionDef]]:
    for path in files:
        for node in nodes(path):
            if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
                yield f"{path.relative_to(REPOSITORY).as_posix()}:{node.name}", node


def is_verb(name: str) -> bool:
    """A verb's parameters are its options, its docstring is its help."""
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
        parameters = [*node.args.posonlyargs, *node.args.args, *node.args.kwonlyargs]
        most = OF_A_VERB if is_verb(name) else PARAMETERS
        if len([parameter for parameter in parameters if parameter.arg not in {"self", "cls"}]) > most:
            many.add(name)
    assert many == set()


def test_tuples_of_many_fields_are_made_by_their_names() -> None:
    tuples = {
        node.name
        for path in FILES
        for node in nodes(path)
        if isinstance(node, ast.ClassDef) and "NamedTuple" in map(ast.unparse, node.bases)
    }
    by_place = {
        f"{path.relative_to(REPOSITORY)}:{node.lineno}"
        for path in FILES
        if "dynamics" in path.parts
        for node in nodes(path)
        if isinstance(node, ast.Call) and ast.unparse(node.func).split(".")[-1] in tuples
        if len(node.args) > BY_PLACE
    }
    assert not by_place


def test_tools_use_what_is_public() -> None:
    private = {
        f"{path.relative_to(REPOSITORY)}: {name}"
        for path in TOOLS
        for name in imports(path)
        if name.startswith("ipoa_mission.") and any(part.startswith("_") for part in name.split("."))
    }
    assert not private


def called(path: Path) -> set[str]:
    return {
        node.func.attr for node in nodes(path) if isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute)
    }


def test_a_tool_tells_of_itself_before_it_writes_anything() -> None:
    """`--help`, or an unknown word, is never a folder to write to."""
    programs = [path for path in TOOLS if '__name__ == "__main__"' in path.read_text(encoding="utf-8")]
    deaf = {"/".join(path.parts[-2:]) for path in programs if "parse_args" not in called(path)}
    assert deaf == set()


def test_no_room_imports_tools_or_tests() -> None:
    roots = {name.split(".")[0] for path in FILES for name in imports(path)}
    assert "ipoa_mission" in roots
    assert not roots & {"tools", "tests"}


def test_longest_test_files_exist() -> None:
    assert not [name for name in LONGEST if not (REPOSITORY / "tests" / name).exists()]
