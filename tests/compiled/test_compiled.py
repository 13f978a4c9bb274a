import ast
import ctypes
import json
import os
import pickle
import struct
import subprocess
import sys
import tomllib
from importlib import import_module
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ipoa_mission.compiled import called_by, library, njit
from ipoa_mission.compiled.library import _struct
from ipoa_mission.vehicles.arducopter.dynamics.steps import fly_leg
from ipoa_mission.vehicles.px4_multicopter.dynamics.flight import fly
from tools import REPOSITORY
from tools.machine_code.build_hook import NEEDED

#: Every compiled function has a part in it.
PLANNED = """
import json, sys
from pathlib import Path
from ipoa_mission import plan_flight, read_scenario
from ipoa_mission.compiled.library import shipped
from tests.quick_search import search_quickly
search_quickly()
texts = {}
for autopilot in ("px4", "ardupilot"):
    scenario = Path("missions/sitl.toml").read_text().replace('autopilot = "px4"', f'autopilot = "{autopilot}"')
    there = Path(sys.argv[1]) / f"{autopilot}.toml"
    there.write_text(scenario)
    for file in plan_flight(read_scenario(there), seed=3).write(sys.argv[1]):
        texts[file.name] = file.read_text()
print(json.dumps([shipped() is not None, "numba" in sys.modules, texts]))
"""


def planned(folder: Path, **environment: str) -> tuple[bool, bool, dict[str, str]]:
    folder.mkdir()
    run = subprocess.run(
        [sys.executable, "-c", PLANNED, str(folder)],
        capture_output=True, text=True, check=True, cwd=REPOSITORY, env=os.environ | environment, timeout=400,
    )  # fmt: skip
    native, numba, files = json.loads(run.stdout.splitlines()[-1])
    return native, numba, files


def test_kernels_are_compiled_with_the_packages_that_a_build_has() -> None:
    """A wheel had no machine code when a kernel's module imported pydantic."""
    words = (
        "import sys; from tools.machine_code import kernels; print(*{name.partition('.')[0] for name in sys.modules})"
    )
    run = subprocess.run([sys.executable, "-c", words], capture_output=True, text=True, cwd=REPOSITORY)
    assert run.returncode == 0, run.stderr
    project = tomllib.loads((REPOSITORY / "pyproject.toml").read_text())["project"]
    packages = {requirement.partition(">")[0] for requirement in project["dependencies"]}
    assert packages & {name.partition(".")[0] for name in run.stdout.split()} <= set(NEEDED)


@pytest.mark.long
@pytest.mark.skipif(library.shipped() is None, reason="no machine code was made of these sources")
def test_a_plan_is_the_same_bytes_by_machine_code_and_by_numba(tmp_path: Path) -> None:
    native, imported, files = planned(tmp_path / "native")
    assert (native, imported) == (True, False)
    native, imported, again = planned(tmp_path / "numba", **{library.NUMBA: "1"})
    assert (native, imported) == (False, True)
    assert files == again
    assert len(files) >= 6


def test_all_that_a_kernel_is_made_of_counts_for_its_hash() -> None:
    def name(path: Path) -> str:
        return path.relative_to(library.PACKAGE).with_suffix("").as_posix().replace("/", ".")

    counted = {name(path) for pattern in library.SOURCES for path in library.PACKAGE.glob(pattern)}
    written = {path: path.read_text(encoding="utf-8") for path in library.PACKAGE.rglob("*.py")}
    modules = {part.__module__ for function in (fly_leg, fly) for part in (function, *called_by(function))}
    rooms = {".".join(module.split(".")[1:3]) for module in modules}
    assert rooms == {"vehicles.arducopter", "vehicles.px4_multicopter", "geometry", "wind"}
    kernels = [path for path, text in written.items() if "@njit" in text or f"ipoa_mission.{name(path)}" in modules]
    assert {name(path) for path in kernels} <= counted
    imported = {
        node.module.removeprefix("ipoa_mission.")
        for path in kernels
        for node in ast.walk(ast.parse(written[path]))
        if isinstance(node, ast.ImportFrom) and node.module and node.module.startswith("ipoa_mission.")
    }
    besides = {"compiled", "errors", "vehicles.arducopter.dynamics", "vehicles.px4_multicopter.dynamics"}
    assert imported - counted <= besides
    assert len(counted) > 20


def test_other_sources_are_not_what_was_compiled(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    before = library.sources_digest()
    source = tmp_path / "planning" / "_kernels.py"
    source.parent.mkdir()
    source.write_text("x = 1\n")
    monkeypatch.setattr(library, "PACKAGE", tmp_path)
    digest = library.sources_digest()
    source.write_text("x = 2\n")
    assert len({before, digest, library.sources_digest()}) == 3


def test_error_without_machine_code_and_numba_names_the_remedy() -> None:
    code = """
import sys
sys.modules["numba"] = None
from ipoa_mission.errors import MissionError
try:
    import ipoa_mission.planning._kernels
except MissionError as error:
    print(error, error.hint)
"""
    run = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True, env=os.environ | {library.NUMBA: "1"}
    )
    assert "expected machine code for these sources and this system, or numba pip install numba" in run.stdout


@pytest.mark.parametrize("made_of", ["no library", "a library without kernels"])
def test_a_library_that_does_not_load_here_is_none(made_of: str, tmp_path: Path) -> None:
    """As one of another system, or without exported names; then numba compiles."""
    import _ctypes

    library_bytes = b"MZ" if made_of == "no library" else Path(_ctypes.__file__).read_bytes()
    for cpu in library.these_cpus():
        (tmp_path / library.file_name(cpu)).write_bytes(library_bytes)
    index = {"sources": library.sources_digest(), "kernels": {"planning.survey": [["int"], "float"]}}
    (tmp_path / library.INDEX).write_text(json.dumps(index))
    assert library.load(tmp_path) is None


def test_a_library_of_another_index_is_none(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    made = library.PACKAGE / "compiled"
    if library.load(made) is None:
        pytest.skip("no machine code of these sources")
    file = next(file for cpu in library.these_cpus() if (file := made / library.file_name(cpu)).is_file())
    (tmp_path / file.name).write_bytes(file.read_bytes())
    index = json.loads((made / library.INDEX).read_text())
    for digest, is_loaded in ((library.digest_of(file), True), ("0" * 64, False)):
        index["libraries"] = {file.name: digest}
        (tmp_path / library.INDEX).write_text(json.dumps(index))
        assert (library.load(tmp_path) is not None) is is_loaded


def test_a_cache_of_other_module_names_is_compiled_again(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Numba would unpickle the index before it sees that sources have changed."""
    numba = pytest.importorskip("numba")
    (tmp_path / "renamed_kernel.py").write_text("def more(x):\n    return x + 1\n")
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.setattr("ipoa_mission.compiled.shipped", lambda: None)
    kernel = njit(cache=True)(import_module("renamed_kernel").more)
    index = Path(kernel._cache._cache_file._index_path)
    index.parent.mkdir(parents=True, exist_ok=True)
    index.write_bytes(pickle.dumps(numba.__version__) + b"cgone_module\nKernel\n.")
    assert kernel(2) == 3


KINDS = st.recursive(st.sampled_from(["float", "int", "bool"]), lambda kinds: st.lists(kinds, min_size=1, max_size=4))
C_TYPES = {"float": ctypes.c_double, "int": ctypes.c_int64, "bool": ctypes.c_bool}


def c_type(kind: Any) -> Any:
    """Return a type as a C struct, which has a number so that it is aligned."""
    if isinstance(kind, str):
        return C_TYPES[kind]
    fields = [(f"field{n}", c_type(part)) for n, part in enumerate([*kind, "int"])]
    return type("Result", (ctypes.Structure,), {"_fields_": fields})


def with_number(kind: Any) -> Any:
    return kind if isinstance(kind, str) else [*map(with_number, kind), "int"]


@given(kind=st.lists(KINDS, min_size=1, max_size=5))
def test_a_result_has_the_layout_of_a_c_struct(kind: Any) -> None:
    values = struct.Struct("@" + _struct(with_number(kind)))
    expected = c_type(kind)
    assert values.size == ctypes.sizeof(expected)
    for n, part in enumerate(kind):
        before = struct.Struct("@" + "".join(map(_struct, map(with_number, kind[:n]))) + _struct(with_number(part)))
        offset: int = getattr(expected, f"field{n}").offset
        assert before.size == offset + ctypes.sizeof(c_type(part))
