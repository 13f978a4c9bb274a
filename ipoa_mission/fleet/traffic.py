"""Flights with departure times, and the conflicts between them."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from ipoa_mission.fleet.encounters import Encounter, encounters
from ipoa_mission.fleet.timed_flight import STEP_S, TimedFlight
from ipoa_mission.geometry import Vector

SEEN = 1e-6  # a less probable conflict is not listed


@dataclass(frozen=True, eq=False)
class Conflict:
    """Two flights that may lose separation: when [s after the start of all] and where most probably.

    `distance`: the least of the expected flights [m], infinite where one is on the ground then.
    """

    pair: tuple[str, str]
    second: float
    place: Vector  # (3,) east, north, up [m]
    distance: float
    probability: float


@dataclass(frozen=True, eq=False)
class PlannedDeparture:
    """A flight and the second at which it departs."""

    flight: TimedFlight
    second: float


class Encounters:
    """The encounters of any two flights at a required `separation` [m], each pair computed once."""

    def __init__(self, separation: float) -> None:
        self.separation = separation
        self._met = dict[tuple[TimedFlight, TimedFlight], tuple[Encounter, ...]]()

    def of(self, a: TimedFlight, b: TimedFlight) -> tuple[Encounter, ...]:
        if (b, a) in self._met:
            return self._met[b, a]
        if (a, b) not in self._met:
            self._met[a, b] = tuple(encounters(a, b, self.separation))
        return self._met[a, b]

    def probabilities(self, a: PlannedDeparture, b: PlannedDeparture, delays: Vector) -> Vector:
        """Return the probability (m,) that the pair loses separation, with B `delays` (m,) [s] later than planned."""
        kept = np.ones(len(delays))
        for encounter in self.of(a.flight, b.flight):
            kept *= 1.0 - encounter.probabilities(_delays(encounter, a, b, delays))
        return np.asarray(1.0 - kept)

    def pairs(self, departures: Iterable[PlannedDeparture]) -> Mapping[tuple[str, str], float]:
        """Return the probability of each pair, by names."""
        now = np.zeros(1)
        return {
            (a.flight.name, b.flight.name): float(self.probabilities(a, b, now)[0])
            for a, b in combinations(departures, 2)
        }

    def between(self, a: PlannedDeparture, b: PlannedDeparture, seen: float = SEEN) -> Iterator[Conflict]:
        """Yield each possible conflict of a pair that is more probable than `seen`."""
        for encounter in self.of(a.flight, b.flight):
            delays = _delays(encounter, a, b, np.zeros(1))
            probability = float(encounter.probabilities(delays)[0])
            if probability > seen:
                distance, sample = encounter.likeliest(float(delays[0]))
                second = (a if encounter.a is a.flight else b).second + STEP_S * sample
                pair = (a.flight.name, b.flight.name)
                yield Conflict(pair, second, encounter.a.places[round(sample)], distance, probability)

    def conflicts(self, departures: Sequence[PlannedDeparture]) -> list[Conflict]:
        """Return the possible conflicts of all pairs, most probable first."""
        found = [conflict for a, b in combinations(departures, 2) for conflict in self.between(a, b)]
        return sorted(found, key=lambda conflict: -conflict.probability)


def _delays(encounter: Encounter, a: PlannedDeparture, b: PlannedDeparture, later: Vector) -> Vector:
    """Return by how much the encounter's B departs after its A (m,) [s], with b `later` (m,) [s] than planned."""
    delays = b.second + later - a.second
    return np.asarray(delays if encounter.a is a.flight else -delays)
