"""Fly a folder of scenarios on a running simulation by the command line, and write the table of what became of them.

    python -m tools.fly.scenarios FOLDER --autopilot px4 --link udpin:127.0.0.1:14540 --out DIR [--times N]
    python -m tools.fly.scenarios FOLDER ... --start "COMMAND {latitude} {longitude} {altitude}"

A scenario is flown where its home is: a simulation that stands elsewhere is passed over, unless `--start` says how one
is started at a home; it is stopped again after the last flight of each scenario. Route: from the end of the take-off to
the last waypoint. Flown clearance: of the autopilot's own position, between the same two. One line of JSON a flight
goes to DIR/flights.jsonl, the table to standard output.
"""

import argparse
import json
import os
import shlex
import signal
import subprocess
import sys
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ipoa_mission.logs.flight_log import read_flight
from ipoa_mission.mission.files import read_mission
from ipoa_mission.scenario import Scenario, read_scenario
from tools import command_line

COLUMNS = (
    "scenario",
    "completed",
    "estimated s",
    "flown s",
    "total",
    "route",
    "landing",
    "required m",
    "promised m",
    "flown m",
)
PATIENCE_S = 1800.0


@dataclass(frozen=True)
class Row:
    """One flight: times [s], and least distances to obstacles [m]; NaN where it did not come to that."""

    scenario: str
    completed: bool
    error: str = ""
    estimated_s: float = np.nan
    flown_s: float = np.nan
    estimated_route_s: float = np.nan
    route_s: float = np.nan
    estimated_landing_s: float = np.nan
    landing_s: float = np.nan
    required_m: float = np.nan
    promised_m: float = np.nan
    flown_m: float = np.nan

    def cells(self) -> tuple[str, ...]:
        """Its line of the table."""
        if not self.completed:
            return (self.scenario, f"no: {self.error}", *[""] * 8)
        return (
            self.scenario,
            "yes",
            f"{self.estimated_s:.1f}",
            f"{self.flown_s:.1f}",
            _share(self.estimated_s, self.flown_s),
            _share(self.estimated_route_s, self.route_s),
            _share(self.estimated_landing_s, self.landing_s),
            *(f"{metres:.2f}" for metres in (self.required_m, self.promised_m, self.flown_m)),
        )


def _share(estimated: float, flown: float) -> str:
    return f"{100 * (estimated / flown - 1):+.1f} %"


def fly(path: Path, given: argparse.Namespace, out: Path) -> Row:
    """One flight by the command line, and what its files tell."""
    out.mkdir(parents=True, exist_ok=True)
    options = ["--autopilot", given.autopilot, "--link", given.link, "--out", str(out), "--json", "--set-params"]
    command = [sys.executable, "-m", "ipoa_mission", "fly", str(path), *options]
    ended = subprocess.run(command, capture_output=True, text=True, timeout=PATIENCE_S, check=False)
    (out / "fly.json").write_text(ended.stdout, encoding="utf-8")
    told = json.loads(ended.stdout or "{}")
    if ended.returncode != 0:
        return Row(path.stem, False, str(told.get("error", ended.stderr.strip())))
    scenario = read_scenario(path)
    plan = json.loads((out / f"{scenario.name}.json").read_text(encoding="utf-8"))
    promise = plan.get("clearance") or {"kept_m": np.nan, "required_m": np.nan}
    times = {item["seq"]: item["done_s"] for item in told["items"]}
    estimated = {item["seq"]: item["done_s"] for item in told["estimate"]["items"]}
    last = max(seq for seq in times if seq < max(times))
    return Row(
        path.stem,
        True,
        "",
        told["estimate"]["total_s"],
        told["flown_s"],
        estimated[last] - estimated[1],
        times[last] - times[1],
        told["estimate"]["total_s"] - estimated[last],
        told["flown_s"] - times[last],
        promise["required_m"],
        promise["kept_m"],
        flown_clearance(scenario, out / scenario.name, times[1], times[last]),
    )


def flown_clearance(scenario: Scenario, files: Path, begin_s: float, end_s: float) -> float:
    """The least distance to obstacles between two times of the flight, along straight lines between positions [m]."""
    record = read_flight(files.with_suffix(".tlog"), read_mission(files.with_suffix(".plan")))
    route = [at for at in record.path if begin_s <= at.time_s <= end_s]
    if not scenario.airspace.obstacles or len(route) < 2:
        return float("nan")
    latitude, longitude, height = (
        np.array([getattr(at, name) for at in route]) for name in ("latitude_deg", "longitude_deg", "height")
    )
    points = scenario.frame.to_local(latitude, longitude, scenario.frame.home.altitude + height)
    return float(scenario.airspace.obstacle_clearance(points).distance)


@contextmanager
def simulation(command: str | None, scenario: Scenario) -> Iterator[None]:
    """A simulation at the scenario's home, where it is said how one is started."""
    if command is None:
        yield
        return
    home = scenario.frame.home
    words = command.format(latitude=home.latitude_deg, longitude=home.longitude_deg, altitude=home.altitude)
    running = subprocess.Popen(shlex.split(words), start_new_session=True)
    try:
        time.sleep(3.0)
        yield
    finally:
        os.killpg(running.pid, signal.SIGTERM)
        running.wait(timeout=30.0)


def table(rows: list[Row]) -> Iterator[str]:
    """The rows as Markdown."""
    yield f"| {' | '.join(COLUMNS)} |"
    yield f"|{'---|' * len(COLUMNS)}"
    for row in rows:
        yield f"| {' | '.join(row.cells())} |"


def main(arguments: list[str]) -> None:
    parser = command_line(__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--autopilot", required=True, choices=["px4", "ardupilot"])
    parser.add_argument("--link", required=True)
    parser.add_argument("--out", required=True, type=Path)
    parser.add_argument("--times", type=int, default=1)
    parser.add_argument("--start")
    given = parser.parse_args(arguments)
    paths = sorted(given.folder.glob("*.toml")) if given.folder.is_dir() else [given.folder]
    rows: list[Row] = []
    given.out.mkdir(parents=True, exist_ok=True)
    with (given.out / "flights.jsonl").open("a", encoding="utf-8") as lines:
        for path in paths:
            for n in range(given.times):
                with simulation(given.start, read_scenario(path)):
                    row = fly(path, given, given.out / f"{path.stem}-{given.autopilot}-{n}")
                rows.append(row)
                lines.write(json.dumps(_plain(asdict(row))) + "\n")
                lines.flush()
                print(f"{path.stem}: {' '.join(row.cells()[1:])}", file=sys.stderr, flush=True)
    print("\n".join(table(rows)))


def _plain(row: Mapping[str, Any]) -> dict[str, Any]:
    return {name: None if isinstance(value, float) and np.isnan(value) else value for name, value in row.items()}


if __name__ == "__main__":
    main(sys.argv[1:])
