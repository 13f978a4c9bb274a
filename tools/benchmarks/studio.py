"""Measure the studio's response time while a point is dragged.

    python -m tools.benchmarks.studio [--drags 100]

The goal is dragged in small steps through the planner's process, as by the page: on the campus, and in a town of 500
buildings in a GeoJSON map. Reports the time from request to answer (median and 95th percentile [ms]) and its CPU part,
which does not depend on other load.
"""

import json
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from rich.console import Console
from rich.table import Table

from ipoa_mission.world.frame import Geodetic, LocalFrame
from tools import command_line

CAMPUS = Path("missions/campus.toml")
HOME = Geodetic(47.397742, 8.545594, 488.0)
APART = 24.0  # of the buildings of a town [m]


def town(buildings: int, folder: Path) -> Path:
    """Write a scenario of `buildings` on a street grid, with its map."""
    rng, side = np.random.default_rng(buildings), int(np.ceil(np.sqrt(buildings)))
    frame, features = LocalFrame(HOME), []
    for n in range(buildings):
        middle = np.array([n % side, n // side]) * APART + (APART, APART) + rng.uniform(-2, 2, 2)
        half = rng.uniform(4, 8, 2)
        corners = middle + np.array([(-1, -1), (1, -1), (1, 1), (-1, 1), (-1, -1)]) * half
        latitude, longitude, _ = frame.to_geodetic(np.column_stack([corners, np.zeros(5)]))
        ring = np.column_stack([longitude, latitude]).round(8).tolist()
        shape = {"type": "Polygon", "coordinates": [ring]}
        tags = {"building": "yes", "height": f"{rng.uniform(8, 45):.1f}"}
        features.append({"type": "Feature", "properties": tags, "geometry": shape})
    (folder / "town.geojson").write_text(json.dumps({"type": "FeatureCollection", "features": features}))
    reach = (side + 1) * APART
    scenario = folder / "town.toml"
    scenario.write_text(
        f"""safety_distance = 1.5
[home]
latitude_deg = {HOME.latitude_deg}
longitude_deg = {HOME.longitude_deg}
altitude_amsl = {HOME.altitude}
[start]
east = 0.0
north = 0.0
up = 18.0
[goal]
east = {reach}
north = {reach}
up = 18.0
[bounds]
east = [-30.0, {reach + 30}]
north = [-30.0, {reach + 30}]
up = [0.0, 40.0]
[vehicle]
radius = 0.5
cruise_speed = 8.0
[[maps]]
kind = "buildings"
file = "town.geojson"
"""
    )
    return scenario


class Planner:
    """Run the studio's planner process as the server does."""

    def __init__(self, scenario: Path) -> None:
        self._scenario = scenario
        self._process = subprocess.Popen(
            [sys.executable, "-m", "ipoa_mission.studio.plan_worker"],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        )

    def ask(self, **order: Any) -> dict[str, Any]:
        stdin, stdout = self._process.stdin, self._process.stdout
        assert stdin is not None
        assert stdout is not None
        told = {"id": 1, "text": self._scenario.read_text(), "path": str(self._scenario), "revision": 1}
        stdin.write(json.dumps(told | order) + "\n")
        stdin.flush()
        answer = json.loads(stdout.readline())
        assert json.loads(stdout.readline()) == {"id": 1, "done": True}
        assert answer["answer"]["kind"] != "trouble", answer
        return dict(answer["answer"])

    def processor_s(self) -> float:
        fields = Path(f"/proc/{self._process.pid}/stat").read_text().rsplit(")", 1)[1].split()
        return (int(fields[11]) + int(fields[12])) / 100

    def close(self) -> None:
        self._process.terminate()
        self._process.wait()


def drags(scenario: Path, count: int) -> Iterator[tuple[float, float, bool]]:
    """Yield time to each answer [s], its CPU time [s], and whether the path was kept."""
    planner = Planner(scenario)
    world = planner.ask(job="look")
    places = {spot["name"]: spot["place"] for spot in world["spots"]}
    rng = np.random.default_rng(1)
    planner.ask(job="sketch", number=None, changes=[])
    put_down = np.array(places["goal"])
    for n in range(count):
        put_down = put_down + rng.normal(0.0, 1.0, 2) * 1e-5  # about a meter a step
        change = {"op": "shift", "path": ["goal"], "taken": places["goal"], "put_down": put_down.tolist()}
        begun, busy = time.perf_counter(), planner.processor_s()
        answer = planner.ask(job="sketch", number=n, changes=[change])
        yield time.perf_counter() - begun, planner.processor_s() - busy, bool(answer["holds"])
    planner.close()


def main() -> None:
    parser = command_line(__doc__)
    parser.add_argument("--drags", type=int, default=100)
    arguments = parser.parse_args()
    console = Console()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        table = Table("scenario", "drags", "held", "median ms", "95 % ms", "processor: median ms", "95 % ms")
        for scenario in (CAMPUS, town(500, folder)):
            waited, busy, held = zip(*drags(scenario, arguments.drags), strict=True)
            figures = [
                f"{1000 * value:.0f}"
                for times in (waited, busy)
                for value in (statistics.median(times), statistics.quantiles(times, n=20)[-1])
            ]
            table.add_row(scenario.stem, str(len(waited)), str(sum(held)), *figures)
        console.print(table)


if __name__ == "__main__":
    main()
