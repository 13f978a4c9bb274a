"""Compare the real flights of `fly_pairs` with the predicted probabilities of a loss of separation.

python -m tools.fly.judge_pairs DIR [DIR...] --out FILE.csv

Each pair is judged at its departures as flown, which are known. Then every two flights of a pair's missions are judged
at several delays, with normally distributed errors of the departures, as in `separation_check`.
"""

import csv
import json
from collections import defaultdict
from collections.abc import Iterator
from dataclasses import replace
from itertools import product
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ipoa_mission import Forecast, read_mission
from ipoa_mission.fleet.encounters import Encounters, PlannedDeparture
from ipoa_mission.fleet.fleet import TimedFlight, timed_flight
from ipoa_mission.geometry import Matrix
from tools import command_line
from tools.fly.crossing_pairs import FRAME, HOME
from tools.fly.separation_check import (
    DEPARTURE_DEVIATION_S,
    SEPARATION,
    Sample,
    delays_about_losses,
    least_distance,
    reliability,
)

DRAWS = 12  # errors of the departures


class RealPair(NamedTuple):
    """A pair as flown: departure of the second after the first, probability by that, least distance of true places."""

    folder: str
    pair: int
    change: str
    planned_delay_s: float
    delay_s: float
    predicted: float
    least_m: float


class FlownPair(NamedTuple):
    record: dict[str, Any]
    flights: tuple[TimedFlight, TimedFlight]
    tracks: tuple[Matrix, Matrix]

    def departures(self, deviation_s: float) -> tuple[PlannedDeparture, PlannedDeparture]:
        first, second = (replace(flight, departure_deviation_s=deviation_s) for flight in self.flights)
        return PlannedDeparture(first, 0.0), PlannedDeparture(second, 0.0)


def read_pair(file: Path) -> FlownPair:
    record = json.loads(file.read_text(encoding="utf-8"))
    forecasts = [Forecast(read_mission(plan)) for plan in record["files"]]
    flights = [timed_flight(str(n), forecast, FRAME) for n, forecast in enumerate(forecasts)]
    tracks = []
    for track in map(np.array, record["tracks"]):
        places = FRAME.to_local(track[:, 1], track[:, 2], HOME.altitude + track[:, 3])
        tracks.append(np.column_stack([track[:, 0], places]))
    return FlownPair(record, (flights[0], flights[1]), (tracks[0], tracks[1]))


def as_flown(pair: FlownPair, folder: str) -> RealPair:
    """Judge a pair at its departures as flown."""
    first, second = pair.record["armed_s"]
    planned = pair.record["departs_s"]
    predicted = Encounters(SEPARATION).probabilities(*pair.departures(1e-3), np.array([second - first]))
    return RealPair(
        folder=folder,
        pair=pair.record["pair"],
        change=", ".join(filter(None, pair.record["change"])),
        planned_delay_s=planned[1] - planned[0],
        delay_s=second - first,
        predicted=float(predicted[0]),
        least_m=least_distance(*pair.tracks, second - first),
    )


def at_delays(pairs: list[FlownPair]) -> Iterator[Sample]:
    """Yield samples of every two flights of the same missions at several delays."""
    chance = np.random.default_rng(pairs[0].record["pair"])
    met = Encounters(SEPARATION)
    planned = pairs[0].departures(DEPARTURE_DEVIATION_S)
    delays = delays_about_losses(*planned, met)
    predicted = met.probabilities(*planned, delays)
    firsts, seconds = zip(*(pair.tracks for pair in pairs), strict=True)
    for delay, probability in zip(delays.tolist(), predicted.tolist(), strict=True):
        lost = [
            least_distance(a, b, delay + np.sqrt(2.0) * DEPARTURE_DEVIATION_S * chance.standard_normal()) < SEPARATION
            for a, b in product(firsts, seconds)
            for _ in range(DRAWS)
        ]
        yield Sample(pairs[0].record["pair"], "real", delay, probability, float(np.mean(lost)), len(lost))


def main() -> None:
    parser = command_line(__doc__)
    parser.add_argument("folders", nargs="+", type=Path)
    parser.add_argument("--out", type=Path)
    options = parser.parse_args()
    rows = list[RealPair]()
    by_pair: dict[tuple[int, int], list[FlownPair]] = defaultdict(list)
    for folder in options.folders:
        for file in sorted(folder.glob("*.json")):
            pair = read_pair(file)
            rows.append(as_flown(pair, folder.name))
            if not rows[-1].change:
                by_pair[pair.record["seed"], rows[-1].pair].append(pair)
    print(
        "| flights | pair | change | delay planned s | delay s | predicted | least m |\n|---|--:|---|--:|--:|--:|--:|"
    )
    for row in rows:
        numbers = f"{row.planned_delay_s:.0f} | {row.delay_s:.1f} | {row.predicted:.2g} | {row.least_m:.1f}"
        print(f"| {row.folder} | {row.pair} | {row.change} | {numbers} |")
    samples = [sample for pairs in by_pair.values() for sample in at_delays(pairs)]
    print("\n".join(["", *reliability(samples)]))
    if options.out is not None:
        with options.out.open("w", newline="", encoding="utf-8") as file:
            csv.writer(file, lineterminator="\n").writerows([RealPair._fields, *rows])


if __name__ == "__main__":
    main()
