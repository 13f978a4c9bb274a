"""Where recorded flights rank among those of the built-in autopilot by the clearance that they kept.

    python -m tools.benchmarks.clearance_ranks --rows FILE --flights DIR [--scenarios DIR...] [--runs 20]

FILE and DIR are those of `tools.fly.judge`. The built-in autopilot flies the mission of each recorded flight with so
many seeds; the rank is the share of its flights that kept less to an obstacle, from the end of the take-off to the last
waypoint. Of a model that is right every rank is as likely as any other.
"""

from collections import defaultdict
from pathlib import Path

import numpy as np
from scipy.stats import kstest

from ipoa_mission.vehicles.autopilot import Autopilot, autopilot_named
from tools import command_line
from tools.benchmarks.flight_ranks import rank
from tools.benchmarks.promise import flown
from tools.fly.flown import read_flown
from tools.fly.judge import read_rows, scenario_of


def main() -> None:
    parser = command_line(__doc__)
    parser.add_argument("--rows", type=Path, required=True)
    parser.add_argument("--flights", type=Path, required=True)
    parser.add_argument("--scenarios", type=Path, nargs="+", default=[Path("missions")])
    parser.add_argument("--autopilot", type=autopilot_named, default=Autopilot.PX4)
    parser.add_argument("--runs", type=int, default=20)
    given = parser.parse_args()
    recorded = defaultdict(list)
    for row in read_rows(given.rows):
        if row.autopilot == given.autopilot:
            recorded[row.scenario].append(row.least_on_the_way)
    ranks: list[float] = []
    print("| mission | flights | mean kept m | spread m | built-in mean m | spread m |\n|---|---|---|---|---|---|")
    for name, kept in sorted(recorded.items()):
        flight = read_flown(given.flights / f"{name}-{given.autopilot}__0", {})
        world = scenario_of(flight, given.scenarios).airspace
        model = np.array([world.obstacle_clearance(flown(flight.mission, n)).distance for n in range(given.runs)])
        ranks += [rank(value, model) for value in kept]
        numbers = " | ".join(f"{value:.2f}" for value in (np.mean(kept), np.std(kept), model.mean(), model.std()))
        print(f"| {name} | {len(kept)} | {numbers} |", flush=True)
    counts = " ".join(map(str, np.histogram(ranks, 5, (0.0, 1.0))[0]))
    p = kstest(ranks, "uniform").pvalue
    print(f"\n{len(ranks)} flights: mean rank {np.mean(ranks):.2f}, by fifths {counts}, Kolmogorov-Smirnov p {p:.2g}")


if __name__ == "__main__":
    main()
