"""Compare predicted and seen probabilities of a loss of separation, with noisy flights of the built-in autopilots.

python -m tools.fly.separation_check --pairs 60 --flights 8 --out FILE.csv

Each of a pair's two missions is flown several times. Every two of these flights, at several delays and with normally
distributed errors of the departures, are one sample. The delays lie evenly about the middle of the predicted losses.
Prints a reliability table.
"""

import csv
from collections.abc import Iterator
from itertools import pairwise, product
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ipoa_mission import Forecast, Mission
from ipoa_mission.fleet.encounters import Encounters, PlannedDeparture
from ipoa_mission.fleet.fleet import timed_flight
from ipoa_mission.geodesy import LocalFrame
from ipoa_mission.geometry import Matrix, Vector
from ipoa_mission.simulator.simulated_flight import SimulatedFlight
from ipoa_mission.simulator.situation import Conditions
from ipoa_mission.terminal import progress_bar
from tools import command_line
from tools.fly.crossing_pairs import FRAME, crossing_pairs

SEPARATION = 10.0  # [m]
DEPARTURE_DEVIATION_S = 1.0
EVERY_S = 0.1  # between samples of a track
COMBINATIONS = (("px4", "ardupilot"), ("px4", "px4"), ("ardupilot", "ardupilot"))
DELAYS_S = (-12.0, -8.0, -6.0, -4.0, -3.0, -2.0, -1.0, 0.0, 1.0, 2.0, 3.0, 4.0, 6.0, 8.0, 12.0)
BINS = (0.0, 0.05, 0.25, 0.5, 0.75, 0.95, 1.0)


class Sample(NamedTuple):
    """A pair of missions at one delay: predicted probability, and the share of its flights that lost separation."""

    pair: int
    autopilots: str
    delay_s: float
    predicted: float
    seen: float
    flights: int


def flown(mission: Mission, seed: int, frame: LocalFrame = FRAME) -> Matrix:
    """Return seconds after arming, east, north and up in the frame, (n, 4), of a flight with noise."""
    conditions = Conditions(version=mission.firmware_version, seed=seed)
    flight = SimulatedFlight(mission.autopilot, mission.home, mission.parameters, conditions)
    flight.load(mission.items)
    flight.arm()
    flight.start()
    rows = list[tuple[float, ...]]()
    begin = flight.time_s
    while flight.armed:
        rows.append((flight.time_s - begin, *flight.place))
        flight.advance(flight.time_s + EVERY_S)
    track = np.array(rows)
    places = frame.to_local(*LocalFrame(mission.home).to_geodetic(track[:, 1:]))
    return np.column_stack([track[:, 0], places])


def least_distance(a: Matrix, b: Matrix, delay_s: float) -> float:
    """Return the least distance of two flown tracks, B `delay_s` after A, of vehicles that remain on their pads [m]."""
    seconds = np.arange(min(0.0, delay_s), max(a[-1, 0], b[-1, 0] + delay_s), EVERY_S)
    places = (
        np.column_stack([np.interp(seconds - later, track[:, 0], axis) for axis in track[:, 1:].T])
        for track, later in ((a, 0.0), (b, delay_s))
    )
    return float(np.linalg.norm(next(places) - next(places), axis=1).min())


def delays_about_losses(a: PlannedDeparture, b: PlannedDeparture, met: Encounters) -> Vector:
    """Return the delays of B to judge at [s]."""
    tried = np.arange(-60.0, 60.0, 0.5)
    lost = met.probabilities(a, b, tried)
    return np.asarray(np.round((lost * tried).sum() / lost.sum()) + np.array(DELAYS_S))


def samples_of(
    n: int, autopilots: tuple[str, str], missions: tuple[Mission, Mission], flights: int
) -> Iterator[Sample]:
    """Yield one sample for each delay."""
    met = Encounters(SEPARATION)
    planned = [
        PlannedDeparture(timed_flight(str(k), Forecast(mission), FRAME), 0.0) for k, mission in enumerate(missions)
    ]
    tracks = [[flown(mission, 100 * n + seed) for seed in range(flights)] for mission in missions]
    chance = np.random.default_rng(n)
    delays = delays_about_losses(planned[0], planned[1], met)
    predicted = met.probabilities(planned[0], planned[1], delays)
    for delay, probability in zip(delays.tolist(), predicted.tolist(), strict=True):
        errors = np.sqrt(2.0) * DEPARTURE_DEVIATION_S * chance.standard_normal(flights**2)
        lost = [
            least_distance(a, b, delay + error) < SEPARATION
            for (a, b), error in zip(product(*tracks), errors.tolist(), strict=True)
        ]
        yield Sample(n, "+".join(autopilots), delay, probability, float(np.mean(lost)), len(lost))


def reliability(samples: list[Sample]) -> list[str]:
    """Return a table in Markdown: by predicted probability, what was seen."""
    rows = ["| predicted | cases | flights | mean predicted | seen |", "|---|--:|--:|--:|--:|"]
    for low, high in pairwise(BINS):
        inside = [each for each in samples if low <= each.predicted < high or (high == 1.0 and each.predicted >= 1.0)]
        if inside:
            means = [np.mean([getattr(each, name) for each in inside]) for name in ("predicted", "seen")]
            flights = sum(each.flights for each in inside)
            rows.append(f"| {low:.0%} to {high:.0%} | {len(inside)} | {flights} | {means[0]:.1%} | {means[1]:.1%} |")
    return rows


def main() -> None:
    parser = command_line(__doc__)
    parser.add_argument("--pairs", type=int, default=60)
    parser.add_argument("--flights", type=int, default=8)
    parser.add_argument("--seed", type=int, default=3)
    parser.add_argument("--out", type=Path)
    options = parser.parse_args()
    samples = list[Sample]()
    with progress_bar("pairs") as progress:
        for n in range(options.pairs):
            autopilots = COMBINATIONS[n % len(COMBINATIONS)]
            *_, pair = crossing_pairs(n + 1, options.seed, autopilots)
            samples += samples_of(n, autopilots, pair.missions, options.flights)
            progress((n + 1) / options.pairs, f"{n + 1} of {options.pairs}")
    if options.out is not None:
        with options.out.open("w", newline="", encoding="utf-8") as file:
            writer = csv.writer(file)
            writer.writerows([Sample._fields, *samples])
    print("\n".join(reliability(samples)))


if __name__ == "__main__":
    main()
