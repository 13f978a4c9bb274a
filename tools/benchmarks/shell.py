"""Compare the CPU and memory of shell commands with those of another commit, both installed fresh, in turns.

    python -m tools.benchmarks.shell --against REF --rounds 5

CPU is the median of the rounds, user and system together, also in imports of numpy. The first round is left out: it
fills caches. `pip install .` is measured once.
"""

import os
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from itertools import product
from pathlib import Path
from statistics import median
from typing import NamedTuple

from rich.progress import track

from tools import REPOSITORY, command_line

SCENARIOS = "campus", "sitl", "downtown", "mountains", "oldtown"
VERBS = {
    "--help": ["--help"],
    "show": ["show", "missions/campus.plan"],
    "estimate": ["estimate", "missions/campus.plan"],
    "check contingencies": ["check", "missions/campus.plan", "--scenario", "missions/campus.toml", "--contingencies"],
    **{f"plan {name}": ["plan", f"missions/{name}.toml", "--out", "planned", "--force"] for name in SCENARIOS},
}


class Cost(NamedTuple):
    """CPU [s] and peak memory [MB]."""

    cpu: float
    memory: float


def cost(command: Sequence[str | Path], folder: Path) -> Cost:
    process = subprocess.Popen(command, cwd=folder, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    _, status, used = os.wait4(process.pid, 0)
    if os.waitstatus_to_exitcode(status) not in (0, 1):  # 1: a check has findings
        raise SystemExit(f"{' '.join(map(str, command))} failed")
    return Cost(used.ru_utime + used.ru_stime, used.ru_maxrss / 1024)


@contextmanager
def checked_out(ref: str, folder: Path) -> Iterator[Path]:
    place = folder / ref.replace("/", "-")
    subprocess.run(["git", "worktree", "add", "--detach", place, ref], cwd=REPOSITORY, check=True, capture_output=True)
    try:
        yield place
    finally:
        subprocess.run(["git", "worktree", "remove", "--force", place], cwd=REPOSITORY, check=True)


def main() -> None:
    parser = command_line(__doc__)
    parser.add_argument("--against", required=True, help="the other commit")
    parser.add_argument("--rounds", type=int, default=5)
    wanted = parser.parse_args()
    with (
        tempfile.TemporaryDirectory() as name,
        checked_out(wanted.against, Path(name)) as other,
        checked_out("HEAD", Path(name)) as new,
    ):
        costs: dict[tuple[str, Path], list[Cost]] = {}
        spelled: dict[Path, dict[str, str]] = {}
        for tree in track((other, new), "installing"):
            subprocess.run([sys.executable, "-m", "venv", tree / ".venv"], check=True)
            install: list[str | Path] = [tree / ".venv/bin/python", "-m", "pip", "install", "--quiet", "."]
            costs["pip install .", tree] = [cost(install, tree)]
            cost([*install[:-1], "rasterio"], tree)  # the elevation model of oldtown
            listed = subprocess.check_output([tree / ".venv/bin/ipoa-mission", "check", "--help"])
            spelled[tree] = {"--contingencies": "--endings"} if b"--endings" in listed else {}  # until 0.4
        runs = list(product(range(wanted.rounds + 1), VERBS.items(), (other, new)))
        for number, (verb, arguments), tree in track(runs, "running"):
            used = cost([tree / ".venv/bin/ipoa-mission", *(spelled[tree].get(each, each) for each in arguments)], tree)
            if number:
                costs.setdefault((verb, tree), []).append(used)
        imports = [cost([new / ".venv/bin/python", "-c", "import numpy"], new).cpu for _ in range(wanted.rounds + 1)]
        numpy = median(imports[1:])
        print(f"`import numpy` takes {numpy:.3f} s of CPU")
        print(f"{'':20}{wanted.against[:10]:>12}{'HEAD':>12}{'ratio':>8}{'imports':>9}{'memory':>8}")
        for verb in ("pip install .", *VERBS):
            then, now = (median(used.cpu for used in costs[verb, tree]) for tree in (other, new))
            memory = costs[verb, new][-1].memory / costs[verb, other][-1].memory
            print(f"{verb:20}{then:10.2f} s{now:10.2f} s{now / then:8.2f}{now / numpy:9.1f}{memory:8.2f}")


if __name__ == "__main__":
    main()
