import dataclasses
import doctest
import inspect
import re
import socket
import threading
from collections.abc import Callable, Iterator
from enum import Enum
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import Any

import pytest
from pydantic import BaseModel

import ipoa_mission
from ipoa_mission.autopilot.autopilot import Autopilot
from ipoa_mission.flight.flight import plan_flight
from ipoa_mission.geodesy import Geodetic
from ipoa_mission.link.channel import open_channel
from ipoa_mission.planning.path_problem import PathTask
from ipoa_mission.planning.planner import Plan, plan_path
from ipoa_mission.report.exports import EXPORTS
from ipoa_mission.scenario import Scenario, read_scenario
from ipoa_mission.simulator.built_in_autopilot import BuiltInAutopilot
from ipoa_mission.simulator.station import Server, Station
from tests.quick_link import hurry
from tests.quick_search import QUICK, search_quickly

REPOSITORY = Path(__file__).parents[2]
TEXT = (REPOSITORY / "docs" / "api.md").read_text(encoding="utf-8")
PORT = "14550"


@pytest.fixture
def vehicle_at() -> Iterator[str]:
    """Serve the built-in autopilot on a port, a hundred times as fast as real."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    channel = open_channel(f"udpout:127.0.0.1:{port}")
    station = Station(BuiltInAutopilot(Autopilot.PX4, Geodetic(47.397742, 8.545594, 488.0)), 1)
    enough = threading.Event()
    thread = threading.Thread(target=Server(channel, station, speedup=100.0).run, args=(enough.is_set,))
    thread.start()
    yield str(port)
    enough.set()
    thread.join()
    channel.close()


@cache
def planned(plan: Callable[..., Any], name: str, seed: int) -> Any:
    return plan(read_scenario(REPOSITORY / "missions" / f"{name}.toml"), seed=seed)


@pytest.fixture
def quickly(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A folder with the shipped missions, planned quickly and once."""

    def quick_path(task: PathTask, **options: Any) -> Plan:
        return plan_path(task, strategy=QUICK, **options)

    def once(plan: Callable[..., Any]) -> Callable[..., Any]:
        def planned_once(task: PathTask, **options: Any) -> Any:
            if isinstance(task, Scenario) and options == {"seed": 7}:
                return planned(plan, task.name, 7)
            return plan(task, **options)

        return planned_once

    search_quickly(monkeypatch.setattr)
    monkeypatch.setattr("ipoa_mission.plan_path", once(quick_path))
    monkeypatch.setattr("ipoa_mission.plan_flight", once(plan_flight))
    hurry(monkeypatch.setattr)
    monkeypatch.chdir(tmp_path)
    Path("missions").symlink_to(REPOSITORY / "missions")


@pytest.mark.usefixtures("quickly")
def test_the_examples_run_one_after_the_other(vehicle_at: str, capsys: pytest.CaptureFixture[str]) -> None:
    names: dict[str, Any] = {}
    flown = list[ipoa_mission.FlightRecord]()
    for example in re.findall(r"```python\n(.*?)```", TEXT, re.DOTALL):
        exec(compile(example.replace(PORT, vehicle_at), "docs/api.md", "exec"), names)
        if "record" in names and names["record"] not in flown:
            flown.append(names["record"])
    output = capsys.readouterr().out
    assert re.search(r"^-\d+\.\d+ mast \(", output, re.MULTILINE)
    assert re.search(r"^1 px4 Geodetic\(latitude_deg=47\.3977", output, re.MULTILINE)
    assert "nothing.plan: cannot be read" in output
    assert names["record"].completed
    assert names["later"].total_s == pytest.approx(flown[0].total_s, abs=0.5)
    assert [item.command for item in names["same"].items] == [item.command for item in names["mission"].items]
    assert names["best"].cost < 1000.0
    for file in ("sitl.plan", "sitl.waypoints", "sitl.kml", "sitl.tlog", "sitl.html", "sitl.png", "vehicle.tlog"):
        assert Path(file).stat().st_size > 300


def test_the_page_names_all_that_is_public() -> None:
    table = TEXT[TEXT.index("## All names") :]
    assert set(re.findall(r"`(\w+)[(`]", "\n".join(re.findall(r"^\| (.*?) \|", table, re.MULTILINE)))) == set(
        ipoa_mission.__all__
    )
    assert dir(ipoa_mission) == ipoa_mission.__all__ == sorted(ipoa_mission.__all__)
    for name in ipoa_mission.__all__:
        assert callable(public := getattr(ipoa_mission, name))
        assert isinstance(public, type) == (name in TYPES)
    assert re.fullmatch(r"\d+\.\d+\.\d+\S*", ipoa_mission.__version__)


@pytest.mark.parametrize("name", [*ipoa_mission.__all__])
def test_errors_of_public_docstrings_have_public_names(name: str) -> None:
    public = getattr(ipoa_mission, name)
    members = [public, *(vars(public).values() if isinstance(public, type) else ())]
    for docstring in filter(None, (getattr(member, "__doc__", None) for member in members)):
        _, raises, promised = docstring.partition("Raises:")
        for error in re.findall(r"[A-Z][a-z]+[A-Za-z]*", promised.partition("\n\n")[0]) if raises else ():
            kind = getattr(ipoa_mission, error, None)
            is_word = not re.search(rf"(^|, |\n *){error}(, |\.|:)", promised)
            assert is_word or (isinstance(kind, type) and issubclass(kind, Exception)), f"{name} raises {error}"


WITH_EXAMPLES = [
    path for path in sorted(Path(ipoa_mission.__file__).parent.rglob("*.py")) if ">>> " in path.read_text()
]


@pytest.mark.parametrize(
    "module", [".".join(path.relative_to(REPOSITORY).with_suffix("").parts) for path in WITH_EXAMPLES]
)
@pytest.mark.usefixtures("quickly")
def test_the_examples_in_docstrings_run(module: str, request: pytest.FixtureRequest) -> None:
    runner = doctest.DocTestRunner()
    for test in doctest.DocTestFinder().find(import_module(module)):
        if PORT in (test.docstring or ""):
            vehicle_at = request.getfixturevalue("vehicle_at")
            for example in test.examples:
                example.source = example.source.replace(PORT, vehicle_at)
        runner.run(test)
    assert runner.tries > 0
    assert runner.failures == 0


def sections(documented: object) -> dict[str, str]:
    """Split a docstring by headings: Args, Attributes, Returns, Raises, Example."""
    text = inspect.getdoc(documented) or ""
    parts = re.split(r"^(Args|Attributes|Returns|Raises|Example):\n", text, flags=re.MULTILINE)
    assert len(parts[1::2]) == len(set(parts[1::2]))
    return {"": parts[0], **dict(zip(parts[1::2], parts[2::2], strict=True))}


def entries(part: str) -> set[str]:
    return {name for names in re.findall(r"^ {4}(\w[\w, ]*): ", part, re.MULTILINE) for name in names.split(", ")}


def parameters_of(public: Callable[..., Any]) -> list[str]:
    return [name for name in inspect.signature(public).parameters if name not in ("self", "cls")]


TYPES = [name for name in ipoa_mission.__all__ if name[0].isupper()]
FUNCTIONS = [name for name in ipoa_mission.__all__ if name not in TYPES]


@pytest.mark.parametrize("name", FUNCTIONS)
def test_help_on_a_function_has_parameters_results_and_an_example(name: str) -> None:
    function = getattr(ipoa_mission, name)
    parts = sections(function)
    assert list(parts) == [part for part in ("", "Args", "Returns", "Raises", "Example") if part in parts]
    assert entries(parts["Args"]) == set(parameters_of(function))
    assert ("Returns" in parts) == (inspect.signature(function).return_annotation is not None)
    assert ">>> " in parts["Example"]


@cache
def returned() -> set[str]:
    """Return types that functions return; their examples show them."""
    signatures = [inspect.signature(getattr(ipoa_mission, function)) for function in FUNCTIONS]
    annotations = " ".join(str(signature.return_annotation) for signature in signatures)
    return {name for name in TYPES if re.search(rf"\b{name}\b", annotations)}


#: Internal methods.
INSIDE = {"Autopilot"}


@pytest.mark.parametrize("name", TYPES)
def test_help_on_a_type_has_each_field_and_each_parameter_of_its_methods(name: str) -> None:
    public = getattr(ipoa_mission, name)
    parts = sections(public)
    if issubclass(public, Exception | Enum):
        return
    if dataclasses.is_dataclass(public):
        assert entries(parts["Attributes"]) == {field.name for field in dataclasses.fields(public)}
    elif (
        not issubclass(public, BaseModel)
        and name not in returned() | INSIDE
        and not getattr(public, "_is_protocol", False)
    ):
        assert entries(parts["Args"]) == set(parameters_of(public))
    assert name in returned() or ">>> " in parts["Example"]
    methods = {name: function for name, function in vars(public).items() if inspect.isfunction(function)}
    for method, function in methods.items() if name not in INSIDE else ():
        inherited = any(hasattr(base, method) for base in public.__mro__[1:])
        if not method.startswith("_") and not inherited and len(parameters := parameters_of(function)) > 1:
            parts = sections(function)
            named = entries(parts.get("Args", "")) | set(re.findall(r"`(\w+)`", parts[""])) | {"progress"}
            assert set(parameters) <= named, method


DOCS = [REPOSITORY / "README.md", *(REPOSITORY / "docs").glob("*.md"), *(REPOSITORY / "docs" / "how-to").glob("*.md")]


def test_the_docs_use_what_is_public() -> None:
    for page in DOCS:
        for block in re.findall(r"```python\n(.*?)```", page.read_text(encoding="utf-8"), re.DOTALL):
            assert not re.search(r"\bipoa_mission\.(?!__version__)\w+", block), page.name
            for names in re.findall(r"^from ipoa_mission import (.*)$", block, re.MULTILINE):
                assert set(names.split(", ")) <= {*ipoa_mission.__all__}, page.name


def test_the_page_of_files_names_every_suffix_of_an_export() -> None:
    page = (REPOSITORY / "docs" / "file-formats.md").read_text(encoding="utf-8")
    assert not [suffix for suffix in EXPORTS if f"`{suffix}`" not in page]


def test_the_index_names_every_page() -> None:
    index = (REPOSITORY / "docs" / "README.md").read_text(encoding="utf-8")
    pages = {path.name for path in (REPOSITORY / "docs").glob("*.md")} - {"README.md"}
    assert pages <= set(re.findall(r"\]\(([\w-]+\.md)\)", index))
