"""Write the library for this machine's CPU, and the index of its kernels, into a folder.

    python -m tools.machine_code FOLDER [CPU ...]

`CPU`: which of `ipoa_mission.compiled.library.CPUS`, one library each. Each is made in a process of its own, in which
numba is told to compile for it. What an editable install has made of the same sources, in the same way, is copied;
so is what lies in the folder `IPOA_MISSION_MADE`, where that is set, and what was compiled is then left there.
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
from functools import partial
from importlib.metadata import version
from pathlib import Path

from ipoa_mission.compiled.library import INDEX, NUMBA, PACKAGE, file_name, sources_digest, these_cpus
from tools import command_line

HERE = PACKAGE / "compiled"
KEPT = "IPOA_MISSION_MADE"  # a folder, for those who build often, each time from a fresh copy of the sources


def make(folder: Path, cpu: str) -> None:
    """Write the library for one CPU, and the index."""
    gc.disable()  # numba makes millions of small objects that live on: to count them took a quarter of the time
    import numba

    numba.njit = partial(numba.njit, no_cpython_wrapper=True, no_cfunc_wrapper=True)  # Python calls the library only
    from tools.machine_code.compile import compiled, link
    from tools.machine_code.kernels import kernels

    machine_code, index = compiled(kernels(), cpu)
    link(machine_code, folder / file_name(cpu))
    text = json.dumps({"sources": sources_digest(), "made_by": makers_digest(), "kernels": index})
    (folder / INDEX).write_text(text, encoding="utf-8")


def makers_digest() -> str:
    """A hash of what compiles."""
    digest = hashlib.sha256(f"{platform.python_version()} {version('numba')} {version('llvmlite')}".encode())
    for path in sorted(Path(__file__).parent.glob("*.py")):
        digest.update(path.read_bytes())
    return digest.hexdigest()


def copy_made(folder: Path, cpu: str) -> bool:
    """Copy the library and the index from where they are as they would be made; whether they are there."""
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
    _copy((library, index), folder)
    return True


def _copy(files: tuple[Path, Path], folder: Path) -> None:
    for file in files:
        if not (folder / file.name).exists() or not file.samefile(folder / file.name):
            shutil.copy(file, folder)


def main() -> None:
    parser = command_line(__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument("cpus", nargs="*", metavar="CPU", default=these_cpus()[:1])
    given = parser.parse_args()
    folder, names = given.folder, given.cpus
    if names and os.environ.get("NUMBA_CPU_NAME") == names[0]:
        make(folder, names[0])
        return
    for cpu in names:
        if copy_made(folder, cpu):
            continue
        print(f"compiling the kernels for {cpu}", flush=True)
        with tempfile.TemporaryDirectory() as cache:
            told = {NUMBA: "1", "NUMBA_CPU_NAME": cpu, "NUMBA_CPU_FEATURES": "", "NUMBA_CACHE_DIR": cache}
            command = [sys.executable, "-m", "tools.machine_code", str(folder), cpu]
            subprocess.run(command, check=True, env=os.environ | told)
        for kept in _kept():
            kept.mkdir(parents=True, exist_ok=True)
            _copy((folder / file_name(cpu), folder / INDEX), kept)


if __name__ == "__main__":
    main()
