"""Write the library for this machine's CPU, and the index of its kernels, into a folder.

    python -m tools.machine_code FOLDER [CPU ...]

`CPU`: which of `ipoa_mission.compiled.library.CPUS`, one library each. Each is made in a process of its own, in which
numba is told to compile for it.
"""

import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path

from ipoa_mission.compiled.library import INDEX, NUMBA, file_name, sources_digest, these_cpus


def make(folder: Path, cpu: str) -> None:
    """Write the library for one CPU, and the index."""
    from tools.machine_code.compile import compiled, link
    from tools.machine_code.kernels import kernels

    machine_code, index = compiled(kernels(), cpu)
    link(machine_code, folder / file_name(cpu))
    text = json.dumps({"sources": sources_digest(), "kernels": index})
    (folder / INDEX).write_text(text, encoding="utf-8")


def main() -> None:
    folder, names = Path(sys.argv[1]), sys.argv[2:] or these_cpus()[:1]
    if names and os.environ.get("NUMBA_CPU_NAME") == names[0]:
        make(folder, names[0])
        return
    for cpu in names:
        with tempfile.TemporaryDirectory() as cache:
            told = {NUMBA: "1", "NUMBA_CPU_NAME": cpu, "NUMBA_CPU_FEATURES": "", "NUMBA_CACHE_DIR": cache}
            command = [sys.executable, "-m", "tools.machine_code", str(folder), cpu]
            subprocess.run(command, check=True, env=os.environ | told)


if __name__ == "__main__":
    main()
