"""Link object files to a library by a C compiler: this machine's, or that of the package `ziglang`."""

import importlib.util
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path


def link(objects: Sequence[bytes], library: Path) -> None:
    """Write a shared library of object files that call only each other and the C library; raise CalledProcessError."""
    with tempfile.TemporaryDirectory() as folder:
        parts = [Path(folder, f"{n}.o") for n in range(len(objects))]
        for part, machine_code in zip(parts, objects, strict=True):
            part.write_bytes(machine_code)
        command = [*linker(), "-shared", "-o", str(library), *map(str, parts), "-lm"]
        if sys.platform == "linux":
            command.append("-Wl,-z,defs,-s")
        subprocess.run(command, check=True)


def linker() -> list[str]:
    here = next((name for name in ("cc", "gcc", "clang") if shutil.which(name)), None)
    if here is None and importlib.util.find_spec("ziglang"):
        return [sys.executable, "-m", "ziglang", "cc"]
    return [here or "cc"]
