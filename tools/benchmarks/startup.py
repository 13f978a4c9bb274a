"""Measure size of the installation, first plan and CPU time of the verbs, relative to `import numpy`.

    python -m tools.benchmarks.startup [FOLDER ...] [--runs 5]

For each folder (a checkout; this one by default) the package is installed into a fresh environment and used from an
empty folder. Each has a table column: megabytes of its packages (without pip and setuptools), and CPU seconds of the
whole process tree with system calls, also as multiples of `import numpy` in the same environment. First plans are made
once, with nothing compiled. Of the others the least of alternating runs is reported. `upload` is to the built-in
autopilot, whose time is not counted. For items a second: `python -m tools.benchmarks.link --clean`.
"""

import os
import resource
import socket
import subprocess
import sys
import tempfile
import venv
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

from tools import REPOSITORY, command_line

SCENARIOS, MISSIONS = ("campus", "sitl"), REPOSITORY / "missions"
#: Environment of a fresh machine: nothing compiled, no settings.
CLEAN = {name: value for name, value in os.environ.items() if not name.startswith(("PYTHON", "NUMBA", "IPOA"))}


class Installed:
    """Install a checkout into its own environment."""

    def __init__(self, checkout: Path, there: Path) -> None:
        self._bin, self._empty = there / "environment" / "bin", there / "empty"
        venv.create(there / "environment", with_pip=True)
        self._empty.mkdir()
        subprocess.run([self._bin / "pip", "install", "--quiet", checkout.absolute()], check=True, env=CLEAN)
        (self._packages,) = (there / "environment" / "lib").glob("python*/site-packages")

    def megabytes(self) -> float:
        """Return the size without pip and setuptools [MB]."""
        kept = [path for path in self._packages.iterdir() if not path.name.startswith(("pip", "setuptools", "pkg_res"))]
        sizes = subprocess.run(["du", "-sck", *kept], capture_output=True, text=True, check=True).stdout
        return int(sizes.splitlines()[-1].split()[0]) / 1024

    def numpy_s(self) -> float:
        return self._cpu_s(self._bin / "python", "-c", "import numpy")

    def verb_s(self, *words: str) -> float:
        return self._cpu_s(self._bin / "ipoa-mission", *words)

    def forget(self) -> None:
        """Delete numba's compiled code."""
        for path in self._packages.glob("ipoa_mission/**/__pycache__/*.nb[ic]"):
            path.unlink()

    @contextmanager
    def autopilot(self) -> Iterator[str]:
        """Yield the address of a built-in autopilot."""
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as free:
            free.bind(("127.0.0.1", 0))
            place = f"127.0.0.1:{free.getsockname()[1]}"
        command = [str(self._bin / "ipoa-mission"), "mock", "--json", "--autopilot", "px4", "--link", f"udpin:{place}"]
        with subprocess.Popen(command, stdout=subprocess.PIPE, text=True, env=CLEAN, cwd=self._empty) as process:
            try:
                assert process.stdout is not None
                process.stdout.readline()
                yield f"udpout:{place}"
            finally:
                process.kill()

    def _cpu_s(self, *command: str | Path) -> float:
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        subprocess.run(command, check=True, capture_output=True, env=CLEAN, cwd=self._empty)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def measure(installed: Sequence[Installed], runs: int) -> dict[str, list[float]]:
    """Return all CPU times, one number for each environment [s]."""
    numbers: dict[str, list[float]] = {}

    def note(name: str, times: int, *words: str) -> None:
        rounds = [[one.verb_s(*words) if words else one.numpy_s() for one in installed] for _ in range(times)]
        numbers[name] = [min(column) for column in zip(*rounds, strict=True)]
        print(f"{name}: {numbers[name]}", file=sys.stderr)

    note("import numpy", 2 * runs)
    for name in SCENARIOS:
        plan = ("plan", str(MISSIONS / f"{name}.toml"), "--out", "out")
        for one in installed:
            one.forget()
        note(f"plan {name}, the first", 1, *plan)
        note(f"plan {name}, the second", runs, *plan)
    note("--help", runs, "--help")
    for name in SCENARIOS:
        for verb in ("show", "check", "estimate"):
            note(f"{verb} {name}", runs, verb, str(MISSIONS / f"{name}.plan"))
    with installed[-1].autopilot() as link:
        note("upload sitl", runs, "upload", str(MISSIONS / "sitl.plan"), "--link", link, "--log", os.devnull)
    return numbers


def main() -> None:
    parser = command_line(__doc__)
    parser.add_argument("checkouts", type=Path, nargs="*", default=[REPOSITORY], metavar="FOLDER")
    parser.add_argument("--runs", type=int, default=5)
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        installed = []
        for n, checkout in enumerate(arguments.checkouts):
            (Path(folder) / str(n)).mkdir()
            installed.append(Installed(checkout, Path(folder) / str(n)))
        sizes = [one.megabytes() for one in installed]
        numbers = measure(installed, arguments.runs)
    print("| |" + "".join(f" {checkout.absolute().name} |" for checkout in arguments.checkouts))
    print("|---|" + "---:|" * len(installed))
    print("| installed, MB |" + "".join(f" {size:.0f} |" for size in sizes))
    for name, seconds in numbers.items():
        times = [one / numpy for one, numpy in zip(seconds, numbers["import numpy"], strict=True)]
        print(f"| {name}, s |" + "".join(f" {s:.2f} ({t:.1f} x) |" for s, t in zip(seconds, times, strict=True)))


if __name__ == "__main__":
    main()
