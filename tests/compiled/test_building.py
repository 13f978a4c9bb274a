import ctypes
import importlib.util
import json
import os
import shutil
import subprocess
import sys
import tarfile
import zipfile
from pathlib import Path

import pytest

from tests.sources import copy_sources

PAGE = ("ipoa_mission/studio/web/dist/index.html", "ipoa_mission/studio/web/dist/studio.js")
BUILD = "import sys, hatchling.build as build; print(build.{call})"


def built(folder: Path, call: str, **environment: str) -> str:
    command = [sys.executable, "-c", BUILD.format(call=call)]
    variables = os.environ | {"IPOA_MISSION_NO_PAGE": "1"} | environment
    run = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=True, env=variables)
    return run.stdout.splitlines()[-1]


@pytest.fixture(scope="module")
def clone(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Copy the sources as git knows them, with stray files; a test may add a page, and break the linker."""
    there = copy_sources(tmp_path_factory.mktemp("building") / "clone")
    subprocess.run(["git", "init", "--quiet"], cwd=there, check=True)
    subprocess.run(["git", "add", "."], cwd=there, check=True)
    for name in ("notes.txt", "ipoa_mission/tried.py", "missions/se[c]ret*.toml"):
        (there / name).write_text("mine\n", encoding="utf-8")
    return there


def test_a_source_distribution_holds_what_git_knows_and_nothing_else(clone: Path, tmp_path: Path) -> None:
    for file in PAGE:
        (clone / file).parent.mkdir(exist_ok=True)
        (clone / file).write_text("made of the sources, as by npm")
    name = built(clone, f"build_sdist({str(tmp_path)!r})")
    with tarfile.open(tmp_path / name) as packed:
        files = {member.name.partition("/")[2] for member in packed if member.isfile()}
    tracked = subprocess.run(["git", "ls-files"], cwd=clone, capture_output=True, text=True, check=True).stdout.split()
    assert files - {"PKG-INFO", *PAGE} <= set(tracked)
    assert files >= set(PAGE)
    assert {"tools/machine_code/build_hook.py", "tools/machine_code/compile.py", "missions/campus.toml"} <= files


def test_build_without_a_c_compiler_asks_for_one_from_pip(clone: Path) -> None:
    assert "ziglang" in built(clone, "get_requires_for_build_wheel()", PATH="")
    if shutil.which("cc"):
        assert "ziglang" not in built(clone, "get_requires_for_build_wheel()")
    assert built(clone, "get_requires_for_build_sdist()") == "[]"


@pytest.mark.parametrize(
    "compiler",
    [
        pytest.param("cc", marks=pytest.mark.skipif(not shutil.which("cc"), reason="no C compiler")),
        pytest.param("zig", marks=pytest.mark.skipif(not importlib.util.find_spec("ziglang"), reason="no ziglang")),
    ],
)
def test_an_object_is_linked_to_a_library_that_loads(
    compiler: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    llvm = pytest.importorskip("llvmlite.binding")
    from tools.machine_code.compile import RUNTIME
    from tools.machine_code.linking import link, linker

    if compiler == "zig":
        monkeypatch.setattr(shutil, "which", lambda name: None)
        assert linker()[-2:] == ["ziglang", "cc"]
    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()
    machine = llvm.Target.from_default_triple().create_target_machine(reloc="pic")
    sine = RUNTIME.replace("declare void @NRT_decref(i8*)", "define void @NRT_decref(i8*) { ret void }")
    sine += "declare double @atan2(double, double)\n"
    sine += "define double @angle(double %y) { %a = call double @atan2(double %y, double 1.0)\n ret double %a }\n"
    module = llvm.parse_assembly(sine)
    module.verify()
    link([machine.emit_object(module)], tmp_path / "small.bin")
    library = ctypes.CDLL(str(tmp_path / "small.bin"))
    library.angle.restype, library.angle.argtypes = ctypes.c_double, [ctypes.c_double]
    assert library.angle(1.0) == pytest.approx(0.7853981633974483)
    assert [path.name for path in tmp_path.iterdir()] == ["small.bin"]
    needs_python = "declare void @Py_DecRef(i8*)\ndefine void @no(i8* %o) { call void @Py_DecRef(i8* %o)\n ret void }\n"
    missing = machine.emit_object(llvm.parse_assembly(sine + needs_python))
    with pytest.raises(subprocess.CalledProcessError):
        link([missing], tmp_path / "wrong.bin")


def test_wheel_without_machine_code_is_pure_and_requires_numba(clone: Path) -> None:
    (clone / "tools" / "machine_code" / "__main__.py").write_text("raise SystemExit('no such linker')\n")
    name = built(clone, "build_wheel('.')")
    assert name.endswith("py3-none-any.whl")
    with zipfile.ZipFile(clone / name) as wheel:
        files = wheel.namelist()
        (metadata,) = (wheel.read(file).decode() for file in files if file.endswith("/METADATA"))
    assert "Requires-Dist: numba>=0.60\n" in metadata
    assert not [file for file in files if "kernels-" in file]


def test_compiled_kernels_serve_other_copies_of_the_same_sources(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    from ipoa_mission.compiled import library
    from tools.machine_code import __main__ as maker

    def compile_there(command: list[str], **_: object) -> None:
        folder, part = Path(command[-4]), command[-1]
        (folder / f"{part}.o").write_bytes(f"object {part}, ".encode())
        (folder / f"{part}.json").write_text(json.dumps({part: []}))

    def build(name: str) -> str:
        """Build the library from a copy of the sources; return the output."""
        (tmp_path / name).mkdir()
        monkeypatch.setattr(sys, "argv", ["machine_code", str(tmp_path / name), "x86-64"])
        maker.main()
        assert (tmp_path / name / library.file_name("x86-64")).read_bytes() == b"object 0, object 1, "
        assert list(json.loads((tmp_path / name / library.INDEX).read_text())["kernels"]) == ["0", "1"]
        return capsys.readouterr().out

    monkeypatch.setattr(maker, "HERE", tmp_path / "nothing is made here")
    monkeypatch.setattr(subprocess, "run", compile_there)
    monkeypatch.setattr(maker, "link", lambda objects, library: library.write_bytes(b"".join(objects)))
    monkeypatch.delenv(maker.KEPT, raising=False)
    assert build("unkept") == "compiling the kernels for x86-64\n"
    monkeypatch.setenv(maker.KEPT, str(tmp_path / "kept"))
    assert build("first") == "compiling the kernels for x86-64\n"
    assert build("second") == ""
    monkeypatch.setattr(maker, "makers_digest", lambda: "another numba")
    assert build("third") == "compiling the kernels for x86-64\n"
    assert json.loads((tmp_path / "third" / library.INDEX).read_text())["libraries"] == {
        library.file_name("x86-64"): library.digest_of(tmp_path / "third" / library.file_name("x86-64"))
    }
    digests = iter(("before", "after"))
    monkeypatch.setattr(maker, "sources_digest", lambda: next(digests))
    with pytest.raises(SystemExit, match="changed while they were compiled"):
        maker.make(tmp_path / "third", "x86-64")
    assert not (tmp_path / "third" / library.file_name("x86-64")).exists()


def test_tool_for_machine_code_shows_its_usage_and_writes_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    from tools.machine_code import __main__ as maker

    monkeypatch.chdir(tmp_path)
    for word, code in (("--help", 0), ("--folder", 2)):
        monkeypatch.setattr(sys, "argv", ["machine_code", word])
        with pytest.raises(SystemExit) as ended:
            maker.main()
        assert ended.value.code == code
    captured = capsys.readouterr()
    assert "python -m tools.machine_code FOLDER [CPU ...]" in captured.out
    assert "the following arguments are required: folder" in captured.err
    assert list(tmp_path.iterdir()) == []
