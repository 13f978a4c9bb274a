"""What the verbs cost before they do anything: seconds of CPU, beside those of `import numpy` on the same machine.

    python -m tools.benchmarks.startup [--runs 5] [--modules]

Each verb runs in a process of its own on `missions/campus.plan` (ArduPilot) and `missions/sitl.plan` (PX4, whose time
model flies a mission step by step: that is no matter of imports). `upload` puts it on the built-in autopilot, which is
not counted. The least of the runs is told: the rest is the load of the machine. `--modules` lists which large packages
each verb has imported when it ends.
"""

import argparse
import os
import resource
import socket
import subprocess
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

from tools import REPOSITORY

PLANS = {"ardupilot": str(REPOSITORY / "missions" / "campus.plan"), "px4": str(REPOSITORY / "missions" / "sitl.plan")}
PACKAGES = ("numpy", "scipy", "shapely", "pyproj", "matplotlib", "contourpy", "numba", "pydantic", "rich", "pymavlink")
VERB = (sys.executable, "-m", "ipoa_mission")
#: Tells on stderr which packages a command line has imported, whatever becomes of it.
WATCHED = """
import atexit, sys
atexit.register(lambda: sys.__stderr__.write("IMPORTED " + " ".join(p for p in {packages!r} if p in sys.modules)))
sys.argv = ["ipoa-mission", *sys.argv[1:]]
from ipoa_mission.cli.app import main
main()
"""


def cpu_s(command: Sequence[str], runs: int) -> float:
    """The least CPU of so many runs of a command [s]."""
    times = []
    for _ in range(runs):
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        subprocess.run(command, check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        times.append(after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime)
    return min(times)


def imported(arguments: Sequence[str]) -> str:
    """The large packages that a command line imports."""
    code = WATCHED.format(packages=PACKAGES)
    run = subprocess.run([sys.executable, "-c", code, *arguments], capture_output=True, text=True, check=True)
    return run.stderr.rpartition("IMPORTED ")[2]


@contextmanager
def autopilot() -> Iterator[str]:
    """The address of a built-in autopilot."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as free:
        free.bind(("127.0.0.1", 0))
        place = f"127.0.0.1:{free.getsockname()[1]}"
    command = [*VERB, "mock", "--json", "--autopilot", "px4", "--link", f"udpin:{place}"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        try:
            assert process.stdout is not None
            process.stdout.readline()
            yield f"udpout:{place}"
        finally:
            process.kill()


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--runs", type=int, default=5)
    parser.add_argument("--modules", action="store_true")
    arguments = parser.parse_args()
    os.environ["PYTHONPATH"] = str(REPOSITORY)
    numpy_s = cpu_s((sys.executable, "-c", "import numpy"), arguments.runs)
    print(f"import numpy: {numpy_s:.3f} s\n\n| verb | CPU, s | times `import numpy` |\n|---|---|---|")
    with autopilot() as link:
        verbs: list[tuple[str, ...]] = [("--help",)]
        verbs += [(verb, plan) for plan in PLANS.values() for verb in ("show", "check", "estimate")]
        verbs += [("upload", PLANS["px4"], "--link", link, "--log", os.devnull)]
        for verb in verbs:
            seconds = cpu_s((*VERB, *verb), arguments.runs)
            words = " ".join([verb[0], *(Path(one).name for one in verb[1:2])])
            print(f"| {words} | {seconds:.2f} | {seconds / numpy_s:.1f} |", flush=True)
            if arguments.modules:
                print(f"|  | {imported(verb)} |  |")


if __name__ == "__main__":
    main()
