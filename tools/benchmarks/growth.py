"""Measure how the CPU of a plan grows with via points, obstacles and length, and print the exponents.

    python -m tools.benchmarks.growth --autopilot px4

A row has the CPU [s] of `plan_flight`, also in imports of numpy, the time of flight, and the number of items. The
exponent is the slope of a straight line through the logarithms of size and CPU.
"""

import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
from rich.console import Console
from rich.progress import track
from rich.table import Table

from ipoa_mission import MissionError, plan_flight
from ipoa_mission.scenario.scenario_file import scenario_of
from tools import command_line

HOME = {"latitude_deg": 47.4, "longitude_deg": 8.5, "altitude_amsl": 400.0}
GAP = 6.5  # of a tree to the given places [m]


def scene(places: list[tuple[float, float]], trees: int, margin: float = 20.0) -> dict[str, Any]:
    """Return a flight at 6 m over `places`, among random trees up to `margin` [m] from it."""
    chance, given = np.random.default_rng(trees), np.array(places)
    lower, upper = given.min(axis=0) - margin, given.max(axis=0) + margin
    bodies = list[dict[str, Any]]()
    while len(bodies) < trees:
        place = chance.uniform(lower, upper)
        if np.linalg.norm(given - place, axis=1).min() > GAP:
            size = {"radius": round(chance.uniform(0.8, 1.8), 2), "height": round(chance.uniform(4.0, 11.0), 2)}
            at = {"east": round(float(place[0]), 2), "north": round(float(place[1]), 2)}
            bodies.append({"kind": "cylinder", "name": f"tree {len(bodies)}", **at, **size})
    start, *via, goal = ({"east": east, "north": north, "up": 6.0} for east, north in places)
    bounds = {"east": (lower[0] - 30, upper[0] + 30), "north": (lower[1] - 30, upper[1] + 30), "up": (0.0, 60.0)}
    return {
        "home": HOME, "start": start, "via": via, "goal": goal, "bounds": bounds, "safety_distance": 1.5,
        "vehicle": {"radius": 0.4, "cruise_speed": 5.0}, "route": {"ending": "land"}, "obstacles": bodies,
    }  # fmt: skip


def via_points(count: int) -> dict[str, Any]:
    """Return a lawn of lines of 150 m, 15 m apart, with six trees for each via point."""
    ends = [(30.0 + 15 * line, 20.0 + 150 * (end ^ line & 1)) for line in range(count // 2) for end in (0, 1)]
    return scene([(0.0, 0.0), *ends, (10.0, -12.0)], 6 * count)


def obstacles(count: int) -> dict[str, Any]:
    """Return 600 m among obstacles, one in 500 m^2."""
    margin = (np.sqrt(600**2 + 4 * 500 * count) - 600) / 4
    return scene([(0.0, 0.0), (600.0, 0.0)], count, max(float(margin), 20.0))


def meters(length: int) -> dict[str, Any]:
    return scene([(0.0, 0.0), (float(length), 0.0)], max(2, length // 20))


SERIES: dict[str, tuple[Callable[[int], dict[str, Any]], tuple[int, ...]]] = {
    "via points": (via_points, (2, 4, 10, 20, 40, 80)),
    "obstacles": (obstacles, (10, 100, 1000, 10000)),
    "length [m]": (meters, (100, 300, 1000, 3000, 10000)),
}


def rows(make: Callable[[int], dict[str, Any]], sizes: tuple[int, ...], autopilot: str) -> Iterator[tuple[Any, ...]]:
    for size in track(sizes, "planning", console=Console(stderr=True), transient=True):
        table = make(size)
        table["vehicle"]["autopilot"] = autopilot
        begin = time.process_time()
        try:
            flight = plan_flight(scenario_of(table, Path("growth.toml")))
            result = f"{flight.estimate.total_s:.0f}", str(len(flight.mission.items))
        except MissionError as error:
            result = error.code or "refused", ""
        yield size, time.process_time() - begin, *result


def main() -> int:
    parser = command_line(__doc__)
    parser.add_argument("--autopilot", default="px4")
    autopilot = parser.parse_args().autopilot
    begin = time.monotonic()
    subprocess.run([sys.executable, "-c", "import numpy"], check=True)
    unit = time.monotonic() - begin
    for name, (make, sizes) in SERIES.items():
        measured = [*rows(make, sizes, autopilot)]
        slope = np.polyfit(np.log([size for size, *_ in measured]), np.log([cpu for _, cpu, *_ in measured]), 1)[0]
        table = Table(name, "CPU [s]", "imports of numpy", "flight [s]", "items", title=f"exponent {slope:.2f}")
        for size, cpu, *result in measured:
            table.add_row(f"{size}", f"{cpu:.1f}", f"{cpu / unit:.0f}", *result)
        Console().print(table)
    return 0


if __name__ == "__main__":
    sys.exit(main())
