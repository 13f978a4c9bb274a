"""Predicted probabilities of a loss of separation, against flights of the real firmware in its simulator.

PX4 1.18 and ArduCopter 4.8 flew ten crossing pairs of missions two or three times each. Nothing was fitted to them.
"""

import csv
from collections import defaultdict
from itertools import pairwise
from pathlib import Path

import numpy as np

from ipoa_mission import Forecast
from ipoa_mission.fleet.fleet import timed_flight
from ipoa_mission.geometry import Matrix
from tools.fly.crossing_pairs import AUTOPILOTS, FRAME, crossing_pairs
from tools.fly.judge_pairs import FlownPair, at_delays
from tools.fly.separation_check import Sample

DATA = Path(__file__).parents[1] / "data" / "crossing_flights.csv"


def tracks() -> dict[int, list[tuple[Matrix, Matrix]]]:
    """Return by pair both tracks of each flight: seconds after arming, true east, north and up (n, 4)."""
    rows: dict[tuple[int, str, str], list[list[float]]] = defaultdict(list)
    with DATA.open(newline="") as file:
        for row in csv.DictReader(file):
            place = [float(row[name]) for name in ("second", "east", "north", "up")]
            rows[int(row["pair"]), row["departures"], row["autopilot"]].append(place)
    by_pair = defaultdict(list)
    for (pair, departures, autopilot), places in rows.items():
        if autopilot == "px4":
            by_pair[pair].append((np.array(places), np.array(rows[pair, departures, "ardupilot"])))
    return by_pair


def test_probabilities_are_within_5_points_of_flights_of_the_firmware() -> None:
    flown = tracks()
    samples = list[Sample]()
    for n, pair in enumerate(crossing_pairs(len(flown), seed=1)):
        forecasts = [Forecast(mission) for mission in pair.missions]
        first, second = (timed_flight(name, each, FRAME) for name, each in zip(AUTOPILOTS, forecasts, strict=True))
        samples += at_delays([FlownPair({"pair": n}, (first, second), both) for both in flown[n]])
    assert sum(each.flights for each in samples) > 10_000
    for low, high in pairwise((0.0, 0.05, 0.25, 0.5, 0.75, 0.95, 1.001)):
        inside = [each for each in samples if low <= each.predicted < high]
        predicted, seen = (np.mean([getattr(each, name) for each in inside]) for name in ("predicted", "seen"))
        assert abs(predicted - seen) < 0.05, (low, high)
