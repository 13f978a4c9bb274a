"""What path and route together cost on maps of the paper's size, on each autopilot, nominal and for 99 % of flights.

    python -m tools.benchmarks.routes [MAP ...]

Prints a table in Markdown: how many of the maps are planned, seconds of CPU of `plan_flight` (median and worst of those
that are planned; worst of those that are refused), and the seconds that all planned flights are estimated to take.
Kernels are loaded before. Maps are those of `planning_benchmark`; the default is all fourteen of the paper's size.
"""

import statistics
import time

from ipoa_mission import MissionError, plan_flight
from ipoa_mission.scenario import Scenario
from ipoa_mission.vehicles.autopilot import Autopilot, registered
from tools import command_line
from tools.benchmarks.planning_benchmark.maps import PAPER_LIKE, benchmark_map

SPEED = 5.0  # [m/s]
CONFIDENCES = ("nominal", 0.99)


def on(name: str, autopilot: Autopilot, confidence: float | str) -> Scenario:
    """A map flown by an autopilot, with that share of flights to keep the clearance."""
    scenario = benchmark_map(name)
    vehicle = scenario.vehicle.model_copy(update={"autopilot": autopilot, "cruise_speed": SPEED})
    safety = scenario.safety.model_copy(update={"confidence": confidence})
    return scenario.model_copy(update={"vehicle": vehicle, "safety": safety})


def measure(maps: list[str], autopilot: Autopilot, confidence: float | str) -> str:
    """A row of the table."""
    plan_flight(on(PAPER_LIKE[0], autopilot, "nominal"))
    planned, refused, flown = list[float](), list[float](), 0.0
    for name in maps:
        started = time.process_time()
        try:
            flown += plan_flight(on(name, autopilot, confidence)).estimate.total_s
        except MissionError:
            refused.append(time.process_time() - started)
        else:
            planned.append(time.process_time() - started)
    seconds = f"{statistics.median(planned):.2f} | {max(planned):.2f}" if planned else " | "
    longest = f"{max(refused):.2f}" if refused else ""
    return f"| {autopilot} | {confidence} | {len(planned)} of {len(maps)} | {seconds} | {longest} | {flown:.0f} |"


def main() -> None:
    parser = command_line(__doc__)
    parser.add_argument("maps", nargs="*", default=list(PAPER_LIKE), metavar="MAP")
    maps = parser.parse_args().maps
    print("| autopilot | confidence | planned | CPU, median [s] | worst [s] | refused, worst [s] | flights [s] |")
    print("|---|---|---|---:|---:|---:|---:|", flush=True)
    for confidence in CONFIDENCES:
        for autopilot in registered():
            print(measure(maps, autopilot, confidence), flush=True)


if __name__ == "__main__":
    main()
