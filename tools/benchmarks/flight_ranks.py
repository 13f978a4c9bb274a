"""Where PX4's recorded flights rank among the model's own runs: is it off, or does PX4 only differ from itself?

python -m tools.benchmarks.flight_ranks [RUNS]    print what docs/lab/flight-time.md says (by default 200 runs each)

At the end: how many of all recorded items keep to the estimate's intervals, those of tests/flights and those of
tests/landings.

Of a model that is right every rank is as likely as any other, so that the ranks of all flights are uniform.
"""

from pathlib import Path

import numpy as np
from scipy.stats import kstest

from ipoa_mission.forecast.forecast import estimate
from ipoa_mission.forecast.itinerary.itinerary import itinerary
from ipoa_mission.vehicles.autopilot import Autopilot, registered
from ipoa_mission.vehicles.px4_multicopter.timing import Flights
from tests.recorded_flights import FLIGHTS, LANDINGS, Recorded, read_flights
from tools import command_line


def model_runs(flight: Recorded, runs: int) -> list[dict[int, float]]:
    """The mission flown so often by the model: when each item was done [s]."""
    parameters = {name: float(value) for name, value in flight.parameters.items()}
    flights = Flights(itinerary(flight.mission), parameters)
    once = flights.prepared(noisy=True, fast=True)
    found = (once(seed)[0] for seed in range(1001, 1001 + runs))
    return [{visit.seq: at for visit, at in zip(flights.route.visits, done, strict=True)} for done in found]


def rank(value: float, among: np.ndarray) -> float:
    """The share of `among` that is less."""
    return (float((among < value).sum()) + 0.5) / (len(among) + 1)


def kept(autopilot: Autopilot, folder: Path) -> str:
    """How many of the items recorded there were done within their intervals, and how wide these are.

    The width needed is the one that holds nine in ten of the items when it is the same for all.
    """
    inside, widths, off = [], [], []
    for flight in read_flights(autopilot, folder):
        for item in estimate(flight.mission, flight.parameters, fast=True).items:
            for run in flight.runs:
                if item.seq in run:
                    inside.append(item.low_s <= run[item.seq] <= item.high_s)
                    widths.append(item.high_s - item.low_s)
                    off.append(abs(run[item.seq] - item.done_s))
    needed = 2.0 * float(np.quantile(off, 0.9))
    return (
        f"{autopilot}, {folder.name}: {100 * np.mean(inside):.1f} % of {len(inside)} items in their intervals, "
        f"mean width {np.mean(widths):.2f} s, needed {needed:.2f} s"
    )


def main() -> None:
    parser = command_line(__doc__)
    parser.add_argument("runs", type=int, nargs="?", default=200)
    runs = parser.parse_args().runs
    ranks: dict[str, list[float]] = {"take-off": [], "mission": [], "single flights": []}
    off, within = [], []
    for flight in read_flights(Autopilot.PX4):
        model = model_runs(flight, runs)
        spans = np.array([done[flight.last] - done[flight.first] for done in model])
        begun = np.array([done[flight.first] for done in model])
        for run in flight.runs:
            span = run[flight.last] - run[flight.first]
            ranks["take-off"].append(rank(run[flight.first], begun))
            ranks["mission"].append(rank(span, spans))
            if len(flight.runs) == 1:
                ranks["single flights"].append(rank(span, spans))
            off.append((span - spans.mean()) / spans.std())
            within.append(np.quantile(spans, 0.05) <= span <= np.quantile(spans, 0.95))
    for name, found in ranks.items():
        counts = " ".join(map(str, np.histogram(found, 5, (0.0, 1.0))[0]))
        print(
            f"{name}: {len(found)} flights, mean rank {np.mean(found):.2f}, by fifths {counts}, "
            f"Kolmogorov-Smirnov p {kstest(found, 'uniform').pvalue:.2f}"
        )
    print(f"off by {np.mean(off):+.2f} standard deviations of the model's runs on average, spread {np.std(off):.2f}")
    print(f"{100 * np.mean(within):.0f} % of the flights lie between the 5 and the 95 in 100 of the runs")
    for autopilot in registered():
        for folder in (FLIGHTS, LANDINGS):
            print(kept(autopilot, folder))


if __name__ == "__main__":
    main()
