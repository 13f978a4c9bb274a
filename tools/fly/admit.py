r"""Fly the admission set on a simulator of a real autopilot, and judge whether its version counts as measured.

    python -m tools.fly.admit --autopilot px4 --sitl udpin:127.0.0.1:14540 --out DIR \
        --start "COMMAND {instance} {latitude} {longitude} {altitude}" --logs "FOLDER/{instance}" --jobs 2

The set: shipped scenarios, those of `--scenarios`, and random ones of `--seed` up to `--count`. Refused ones are left
out and counted. `--start` starts a simulator for each flight and stops it afterwards. Without it a running simulator
is used, which must be at each scenario's home. Instance N has the port of `--sitl` plus N (PX4) or 10 N (ArduPilot).
The true track is from the newest log in `--logs` (default `{folder}`, a folder for each instance, also for `--start`),
else from the vehicle's own position.

DIR/admission.csv has a line a flight; each has a folder, and is not flown again. `--judge` compares recorded flights
with today's forecast without flying. Exit code 0: measured; 1: not.
"""

import argparse
import csv
import io
import math
import multiprocessing
import re
import signal
import sys
from collections.abc import Iterator
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from contextlib import nullcontext
from dataclasses import asdict, dataclass, fields, replace
from itertools import chain, count
from pathlib import Path
from typing import Any, get_type_hints

import numpy as np

from ipoa_mission.autopilot.autopilot import Autopilot, autopilot_named
from ipoa_mission.autopilot.version import Version
from ipoa_mission.errors import MissionError
from ipoa_mission.files import write_atomically
from ipoa_mission.scenario import read_scenario
from tools import command_line
from tools.fly import admission_flight
from tools.fly.admission_flight import COMPLETED, FLEW_AWAY, NOT_COMPLETED, NOT_FLOWN, REFUSED, Row, Simulator, judged
from tools.fly.admission_scenes import as_flown_by, scene_name, shipped, written
from tools.fly.simulators import connected, simulation

KEPT_BY = 0.98  # share of the flights that must keep the 99 % clearance
ROUTE_MEDIAN, ROUTE_WORST = 0.015, 0.06  # error of the time to the last waypoint
ROUNDING = 0.005  # [m]
PORT_STEP = {Autopilot.PX4: 1, Autopilot.ARDUPILOT: 10}
FLOWN = (COMPLETED, FLEW_AWAY, NOT_COMPLETED)
PLANS_S = 300  # limit of the planning time [s]


@dataclass(frozen=True)
class Task:
    """Name a flight by a scenario's file, or by the number of a random scene."""

    name: str
    flight: int
    path: Path | None
    number: int = -1


@dataclass(frozen=True)
class Work:
    autopilot: Autopilot
    out: Path
    seed: int
    version: Version | None
    simulator: Simulator

    def folder(self, task: Task) -> Path:
        return self.out / f"{task.name}-{self.autopilot}__{task.flight}"

    def scenario_file(self, task: Task) -> Path:
        if task.path is not None:
            return task.path
        folder = self.folder(task)
        folder.mkdir(parents=True, exist_ok=True)
        return written(task.number, self.seed, self.autopilot, folder / f"{task.name}-{self.autopilot}.toml")


_own: list[int] = []


def _begin(instances: Any) -> None:
    _own.append(instances.get())
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(1))  # so that its simulator ends with it


def _too_long(*_: object) -> None:
    raise MissionError(f"not planned within {PLANS_S} s")


def one_flight(task: Task, work: Work) -> Row:
    simulator = replace(work.simulator, instance=_own[0], link=link_of(work.simulator.link, work.autopilot, _own[0]))
    row = Row(task.name, str(work.autopilot), task.flight, str(work.version), NOT_FLOWN)
    folder = work.folder(task)
    signal.signal(signal.SIGALRM, _too_long)
    signal.alarm(PLANS_S)
    try:
        scenario, mission = admission_flight.planned(work.scenario_file(task), work.autopilot, work.version)
    except MissionError as error:
        return replace(row, outcome=REFUSED, why=str(error))
    finally:
        signal.alarm(0)
    try:
        admission_flight.fly(scenario, mission, simulator, folder)
        return judged(folder, scenario)
    except (MissionError, OSError) as error:
        return replace(row, why=" ".join((type(error).__name__, str(error), getattr(error, "hint", "") or "")))


def link_of(link: str, autopilot: Autopilot, instance: int) -> str:
    return re.sub(r"\d+$", lambda port: str(int(port[0]) + PORT_STEP[autopilot] * instance), link)


def scenario_files(options: argparse.Namespace) -> dict[str, Path]:
    folders = ((sorted(file.glob("*.toml")) if file.is_dir() else [file]) for file in options.scenarios)
    return {path.stem: path for path in chain(shipped(), *folders)}


def tasks(options: argparse.Namespace, rows: list[Row]) -> Iterator[Task | None]:
    """Yield the flights in order; None while only a refusal could add one. `rows` grows meanwhile."""
    done = {(row.scene, row.flight) for row in rows}
    begun = sum(row.outcome != REFUSED for row in rows)
    fixed = ((name, path, -1) for name, path in scenario_files(options).items())
    random = ((scene_name(number, options.seed), None, number) for number in count())
    refused = sum(row.outcome == REFUSED for row in rows)
    for (name, path, number), flight in ((case, n) for case in chain(fixed, random) for n in range(options.times)):
        if (name, flight) in done:
            continue
        while begun - (sum(row.outcome == REFUSED for row in rows) - refused) >= options.count:
            yield None
        begun += 1
        yield Task(name, flight, path, number)


def fly_all(options: argparse.Namespace, work: Work, rows: list[Row], path: Path) -> None:
    instances = multiprocessing.Manager().Queue()
    for instance in range(options.jobs):
        instances.put(options.instance + instance)
    under_way: set[Future[Row]] = set()
    to_fly = tasks(options, rows)
    with ProcessPoolExecutor(options.jobs, initializer=_begin, initargs=(instances,)) as pool:
        while True:
            while len(under_way) < options.jobs and (task := next(to_fly)) is not None:
                under_way.add(pool.submit(one_flight, task, work))
            if not under_way:
                return
            ended, under_way = wait(under_way, return_when=FIRST_COMPLETED)
            for future in ended:
                rows.append(future.result())
                write_rows(path, rows)
                print(words(rows[-1]), flush=True)


def words(row: Row) -> str:
    if row.outcome != COMPLETED:
        kept = "" if math.isnan(row.surplus) else f"; {row.surplus:+.2f} m to what is required"
        return f"{row.scene} {row.flight}: {row.outcome}: {row.why}{kept}"
    return (
        f"{row.scene} {row.flight}: {row.outcome}; to the last waypoint {100 * row.route_off:+.1f} % of "
        f"{row.flown_route_s:.1f} s; {row.surplus:+.2f} m to what is required, {row.over_guarantee:+.2f} m to what "
        f"99 % keep of {row.to}; astray {row.astray:.1f} m; by {row.truth}"
    )


def verdict(rows: list[Row], asked: int) -> tuple[bool, list[str]]:
    flown = [row for row in rows if row.outcome in FLOWN]
    completed = [row for row in flown if row.outcome == COMPLETED]
    near = [row for row in flown if row.surplus < -ROUNDING]
    short = [row for row in completed if row.over_guarantee < -ROUNDING]
    off = np.array([abs(row.route_off) for row in completed])
    median, worst = (float(np.median(off)), float(off.max())) if len(off) else (math.nan, math.nan)
    slow = [row for row in completed if abs(row.route_off) > ROUTE_WORST]
    away, broken_off = ([row for row in flown if row.outcome == outcome] for outcome in (FLEW_AWAY, NOT_COMPLETED))
    total = sum(row.outcome == REFUSED for row in rows)
    allowed = math.floor((1.0 - KEPT_BY) * len(flown) + 1e-9)
    criteria = [
        (len(flown) >= asked, f"{len(flown)} of {asked} flights flown, {total} scenes refused", []),
        (not away, f"{len(away)} flew away", away),
        (not broken_off, f"{len(broken_off)} were not completed", broken_off),
        (not near, f"{len(near)} came nearer than required", near),
        (len(short) <= allowed, f"{len(short)} kept less than 99 % keep; {allowed} may", short),
        (median <= ROUTE_MEDIAN, f"to the last waypoint {100 * median:.2f} % off in the median", []),
        (worst <= ROUTE_WORST, f"to the last waypoint {100 * worst:.1f} % off at worst", slow),
    ]
    lines = [f"{'ok ' if holds else 'NO '} {words_of}" for holds, words_of, _ in criteria]
    lost = [row for row in rows if row.outcome == NOT_FLOWN]
    named = dict.fromkeys(words(row) for some in (*(rows for *_, rows in criteria), lost) for row in some)
    return all(holds for holds, *_ in criteria), [*lines, *(f"    {outcome}" for outcome in named)]


def read_rows(path: Path) -> list[Row]:
    """Return the rows of an earlier run, without flights that did not begin."""
    if not path.exists():
        return []
    kinds = get_type_hints(Row)
    with path.open(encoding="utf-8", newline="") as lines:
        rows = [Row(**{name: kinds[name](value) for name, value in line.items()}) for line in csv.DictReader(lines)]
    return [row for row in rows if row.outcome != NOT_FLOWN]


def write_rows(path: Path, rows: list[Row]) -> None:
    text = io.StringIO()
    lines = csv.DictWriter(text, [field.name for field in fields(Row)], lineterminator="\n")
    lines.writeheader()
    lines.writerows(asdict(row) for row in sorted(rows, key=lambda row: (row.scene, row.flight)))
    write_atomically(path, text.getvalue())


def version_on(options: argparse.Namespace, autopilot: Autopilot, simulator: Simulator) -> Version | None:
    home = read_scenario(shipped()[0]).frame.home
    start = options.start and simulator.words(options.start, home)
    link = link_of(options.sitl, autopilot, options.instance)
    with simulation(start, simulator.folder) if start else nullcontext(), connected(link) as vehicle:
        if vehicle.autopilot is not autopilot:
            raise MissionError(f"expected {autopilot} on {link}, not {vehicle.autopilot}")
        return vehicle.firmware_version()


def judge_again(options: argparse.Namespace, autopilot: Autopilot, rows: list[Row]) -> list[Row]:
    named, new = scenario_files(options), list[Row]()
    for row in rows:
        folder = options.out / f"{row.scene}-{row.autopilot}__{row.flight}"
        if row.outcome in FLOWN:
            path = named.get(row.scene, folder / f"{row.scene}-{row.autopilot}.toml")
            row = judged(folder, as_flown_by(path, autopilot))
            print(words(row), flush=True)
        new.append(row)
    return new


def main(arguments: list[str]) -> int:
    parser = command_line(__doc__)
    parser.add_argument("--autopilot", required=True, choices=[str(each) for each in PORT_STEP])
    parser.add_argument("--sitl", metavar="URL", help="the link of instance 0")
    parser.add_argument("--out", required=True, type=Path)
    parser.add_argument("--start", metavar="COMMAND", help="starts a simulator for one flight")
    parser.add_argument("--logs", metavar="FOLDER", help="where the simulator keeps its logs")
    parser.add_argument("--scenarios", type=Path, nargs="*", default=[], help="files or folders that are flown too")
    parser.add_argument("--count", type=int, default=100)
    parser.add_argument("--times", type=int, default=1, help="flights of each scene")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--jobs", type=int, default=1, help="simulators at once, each with its instance number")
    parser.add_argument("--instance", type=int, default=0, help="the first instance number")
    parser.add_argument("--judge", action="store_true", help="fly nothing")
    options = parser.parse_args(arguments)
    if not options.judge and options.sitl is None:
        parser.error("--sitl: expected the link of a simulator, like udpin:127.0.0.1:14540")
    if options.jobs > 1 and options.start is None:
        parser.error("--jobs: expected with --start, which starts each simulator")
    autopilot = autopilot_named(options.autopilot)
    options.out.mkdir(parents=True, exist_ok=True)
    rows = read_rows(path := options.out / "admission.csv")
    if options.judge:
        rows = judge_again(options, autopilot, rows)
        write_rows(path, rows)
    else:
        simulator = Simulator(options.sitl, options.instance, options.out / "work", options.start, options.logs)
        version = version_on(options, autopilot, simulator)
        print(f"{autopilot.model} {version}", flush=True)
        if versions_before := {row.version for row in rows if row.outcome != REFUSED} - {str(version)}:
            parser.error(f"{path} has flights of {', '.join(sorted(versions_before))}, and {version} is on the link")
        fly_all(options, Work(autopilot, options.out, options.seed, version, simulator), rows, path)
    is_measured, lines = verdict(rows, options.count)
    versions = ", ".join(sorted({row.version for row in rows if row.outcome != REFUSED}))
    print("\n".join([*lines, f"{autopilot.model} {versions}: {'measured' if is_measured else 'not measured'}"]))
    return 0 if is_measured else 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
