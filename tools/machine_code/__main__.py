"""Write the library for this machine's CPU, and the index of its kernels, into a folder.

    python -m tools.machine_code FOLDER [CPU ...]

`CPU` is one of `ipoa_mission.compiled.library.CPUS`, with one library each. Two processes compile each library at the
same time. A library that an editable install made from the same sources is copied, as is one in the folder
`IPOA_MISSION_MADE`, if set; new libraries are stored there.
"""

import gc
import hashlib
import json
import os
import platform
import shutil
import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from importlib.metadata import version
from pathlib import Path
from typing import Any

from ipoa_mission.compiled.library import INDEX, NUMBA, PACKAGE, digest_of, file_name, sources_digest, these_cpus
from tools import command_line
from tools.machine_code.linking import link

HERE = PACKAGE / "compiled"
PARTS = 2  # of the kernels, compiled at the same time
KEPT = "IPOA_MISSION_MADE"  # a cache folder for frequent builds from fresh copies of the sources


def make(folder: Path, cpu: str) -> None:
    """Write the library for one CPU and the index, each part of the kernels in its own process.

    Raises:
        SystemExit: a source was changed meanwhile.
    """
    of = {"sources": sources_digest(), "made_by": makers_digest()}
    with tempfile.TemporaryDirectory() as name, ThreadPoolExecutor(PARTS) as pool:
        told = {NUMBA: "1", "NUMBA_CPU_NAME": cpu, "NUMBA_CPU_FEATURES": "", "NUMBA_CACHE_DIR": name}
        command = [sys.executable, "-m", "tools.machine_code", name, cpu, "--part"]
        run = partial(subprocess.run, check=True, env=os.environ | told)
        list(pool.map(lambda part: run([*command, str(part)]), range(PARTS)))
        link([Path(name, f"{part}.o").read_bytes() for part in range(PARTS)], folder / file_name(cpu))
        kernels: dict[str, object] = {}
        for part in range(PARTS):
            kernels |= json.loads(Path(name, f"{part}.json").read_text(encoding="utf-8"))
    if of["sources"] != sources_digest():
        (folder / file_name(cpu)).unlink()
        sys.exit("a source of the kernels was changed while they were compiled: compile them again")
    _write_index(folder, of | {"kernels": kernels, "libraries": {file_name(cpu): digest_of(folder / file_name(cpu))}})


def _write_index(folder: Path, made: dict[str, Any]) -> None:
    """Write an index, and keep its other libraries of the same sources."""
    path = folder / INDEX
    before = json.loads(path.read_text(encoding="utf-8")) if path.is_file() else {}
    if all(before.get(key) == made.get(key) for key in ("sources", "made_by")):
        made = made | {"libraries": before.get("libraries", {}) | made["libraries"]}
    path.write_text(json.dumps(made), encoding="utf-8")


def make_part(folder: Path, cpu: str, part: int) -> None:
    """Write the object file of a part of the kernels, and its index."""
    gc.disable()  # numba makes millions of long-lived small objects: collection takes a quarter of the time
    import numba

    numba.njit = partial(numba.njit, no_cpython_wrapper=True, no_cfunc_wrapper=True)  # only Python calls the library
    from tools.machine_code import kernels
    from tools.machine_code.compile import compiled

    machine_code, index = compiled(kernels.part(part), cpu, () if part else ("release",))
    (folder / f"{part}.o").write_bytes(machine_code)
    (folder / f"{part}.json").write_text(json.dumps(index), encoding="utf-8")


def makers_digest() -> str:
    digest = hashlib.sha256(f"{platform.python_version()} {version('numba')} {version('llvmlite')}".encode())
    for path in sorted(Path(__file__).parent.glob("*.py")):
        digest.update(path.read_bytes())
    return digest.hexdigest()


def copy_made(folder: Path, cpu: str) -> bool:
    """Return whether the library and the index were cached, and are copied."""
    return any(_copy_from(here, folder, cpu) for here in (HERE, *_kept()))


def _kept() -> list[Path]:
    return [Path(os.environ[KEPT])] if os.environ.get(KEPT) else []


def _copy_from(here: Path, folder: Path, cpu: str) -> bool:
    library, index = here / file_name(cpu), here / INDEX
    if not (library.is_file() and index.is_file()):
        return False
    made = json.loads(index.read_text(encoding="utf-8"))
    if (made["sources"], made.get("made_by")) != (sources_digest(), makers_digest()):
        return False
    if made["libraries"].get(library.name) != digest_of(library):
        return False
    _copy(library, made, folder)
    return True


def _copy(library: Path, made: dict[str, Any], folder: Path) -> None:
    there = folder / library.name
    if not there.exists() or not library.samefile(there):
        shutil.copy(library, folder)
        _write_index(folder, made | {"libraries": {library.name: digest_of(library)}})


def main() -> None:
    parser = command_line(__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument("cpus", nargs="*", metavar="CPU", default=these_cpus()[:1])
    parser.add_argument("--part", type=int, choices=range(PARTS), help="only this part of the kernels, in this process")
    given = parser.parse_args()
    if given.part is not None:
        make_part(given.folder, given.cpus[0], given.part)
        return
    for cpu in given.cpus:
        if copy_made(given.folder, cpu):
            continue
        print(f"compiling the kernels for {cpu}", flush=True)
        make(given.folder, cpu)
        for kept in _kept():
            kept.mkdir(parents=True, exist_ok=True)
            made = json.loads((given.folder / INDEX).read_text(encoding="utf-8"))
            _copy(given.folder / file_name(cpu), made, kept)


if __name__ == "__main__":
    main()
