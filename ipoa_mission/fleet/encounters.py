"""The probability that two flights, each early or late and off its path, lose separation.

It is the mean, over the offset in time of B to A, of the chance that deviations close the least distance.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from enum import Enum
from functools import cached_property, lru_cache
from itertools import combinations, product
from typing import NamedTuple

import numpy as np
from scipy.spatial import cKDTree

from ipoa_mission import DeviationLaw
from ipoa_mission.fleet.fleet import STEP_S, Indices, TimedFlight, within_pad
from ipoa_mission.geometry import Vector

#: Shares of flights, and their standard deviation of time, in that of the forecast's interval, as flown.
TIME_SPREADS = ((0.75, 0.55), (0.25, 1.8))


class Phase(Enum):
    """Of the other vehicle: on its pad, in flight, or where it landed."""

    WAITING = 0
    FLYING = 1
    LANDED = 2


@dataclass(frozen=True, eq=False)
class Encounter:
    """By `offsets` (k,) [samples] of B's clock ahead of A's: expected least distance [m], A's sample, chance of a loss.

    `deviations_s`: standard deviations of the departures, and of A's and B's time [s].
    """

    a: TimedFlight
    offsets: Indices
    separations: Vector
    of_a: Vector
    risks: Vector
    deviations_s: tuple[float, float, float]

    def probabilities(self, delays_s: Vector) -> Vector:
        """Return the probability (m,) of a loss of separation, with B departing `delays_s` (m,) after A."""
        errors, weights = self._errors
        offsets = -(delays_s[:, None] + errors) / STEP_S
        return np.asarray(np.interp(offsets, self.offsets, self.risks) @ weights)

    def likeliest(self, delay_s: float) -> tuple[float, float]:
        """Return the expected least distance [m], and A's sample at the likeliest loss."""
        errors, weights = self._errors
        numbers = np.rint(-(delay_s + errors) / STEP_S - self.offsets[0]).clip(0, len(self.risks) - 1).astype(int)
        likeliest = numbers[np.argmax(weights * self.risks[numbers])]
        return float(self.separations[numbers[len(errors) // 2]]), float(self.of_a[likeliest])

    @cached_property
    def _errors(self) -> tuple[Vector, Vector]:
        """Return errors of the offset (k,) [s], and their probabilities."""
        departures_s, a_s, b_s = self.deviations_s
        most = 6.0  # standard deviations
        mixed = [
            (p * q, float(np.linalg.norm([departures_s, of_a * a_s, of_b * b_s])))
            for (p, of_a), (q, of_b) in product(TIME_SPREADS, TIME_SPREADS)
        ]
        reach = round(most * max(width_s for _, width_s in mixed) / STEP_S)
        errors = STEP_S * np.arange(-reach, reach + 1)
        densities = [share * np.exp(-0.5 * (errors / width_s) ** 2) / width_s for share, width_s in mixed]
        weights = np.sum(densities, axis=0)
        return np.asarray(errors), np.asarray(weights / weights.sum())


def encounters(a: TimedFlight, b: TimedFlight, separation: float) -> Iterator[Encounter]:
    """Yield where A and B may be nearer than `separation` [m], for any departures."""
    for phase in Phase:
        yield from _Approach(a, b, phase, separation).encounters()
    for phase in (Phase.WAITING, Phase.LANDED):
        yield from _Approach(b, a, phase, separation).encounters()


@dataclass(frozen=True, eq=False)
class _Approach:
    """A in flight near B, which waits on its pad, flies, or remains where it landed.

    A pad of both is free outside of a flight.
    """

    a: TimedFlight
    b: TimedFlight
    phase: Phase
    separation: float

    def encounters(self) -> Iterator[Encounter]:
        a = self.a
        b = self.b
        of_phase = {Phase.WAITING: [0], Phase.FLYING: range(len(b.places) - 1), Phase.LANDED: [len(b.places) - 1]}
        columns = np.array(of_phase[self.phase])
        if self.phase is not Phase.FLYING and a.uses_pad(b.places[columns[0]]):
            return
        farthest_deviations = 8.0  # of both towards each other [m]
        apart_s = 20.0  # between two encounters
        reach = self.separation + farthest_deviations + a.longest_step + b.longest_step
        distances, _ = cKDTree(b.places[columns]).query(a.places[:-1], distance_upper_bound=reach)
        near = np.flatnonzero(np.isfinite(distances))
        for run in filter(len, np.split(near, np.flatnonzero(np.diff(near) > apart_s / STEP_S) + 1)):
            rows = np.arange(run[0], run[-1] + 1)
            away, _ = cKDTree(a.places[rows]).query(b.places[columns], distance_upper_bound=reach)
            met = columns[np.isfinite(away)]
            yield self._encounter(rows, np.arange(met[0] - rows[-1] - 1, met[-1] - rows[0] + 2))

    def _encounter(self, rows: Indices, offsets: Indices) -> Encounter:
        a = self.a
        b = self.b
        batch_size = 200_000  # pairs of samples, limited by memory
        batches = np.array_split(offsets, 1 + len(rows) * len(offsets) // batch_size)
        parts = [self._nearest(rows, batch) for batch in batches]
        separations, of_a, above, seconds = (np.concatenate(column) for column in zip(*parts, strict=True))
        closest = int(np.argmin(separations))
        meets = round(of_a[closest])
        meets_b = int(np.clip(meets + offsets[closest], 0, len(b.places) - 1))
        departures_s = float(np.hypot(a.departure_deviation_s, b.departure_deviation_s))
        laws = (a.law, b.law) if self.phase is Phase.FLYING else (a.law,)
        return Encounter(
            a=a,
            offsets=offsets,
            separations=separations,
            of_a=of_a,
            risks=_risks(laws, separations - self.separation, above, seconds),
            deviations_s=(departures_s, float(a.time_deviations[meets]), float(b.time_deviations[meets_b])),
        )

    def _nearest(self, rows: Indices, offsets: Indices) -> tuple[Vector, Vector, Vector, Vector]:
        """Return by offset (k,): least distance [m], A's sample, A's height above B as a share of it, seconds near."""
        a = self.a
        b = self.b
        last = len(b.places) - 1
        of_b = rows[:, None] + offsets
        present = np.digitize(of_b, [0, last]) == self.phase.value
        of_b = of_b.clip(0, last)
        away = a.places[rows][:, None] - b.places[of_b]
        both_on_ground = a.on_ground(rows)[:, None] & b.on_ground(of_b)
        present &= ~both_on_ground | within_pad(away)
        change = (a.places[rows + 1] - a.places[rows])[:, None]
        if self.phase is Phase.FLYING:
            change = change - (b.places[np.minimum(of_b + 1, last)] - b.places[of_b])
        squares = np.maximum((change**2).sum(axis=2), 1e-12)
        shares = np.clip(-(away * change).sum(axis=2) / squares, 0.0, 1.0)  # of the step, where they are nearest
        nearest = away + shares[..., None] * change
        distances = np.where(present, np.linalg.norm(nearest, axis=2), np.inf)
        least = distances.argmin(axis=0)
        chosen = least, np.arange(len(offsets))
        separations = distances[chosen]
        above = nearest[chosen][:, 2] / np.maximum(separations, 1e-9)
        seconds = STEP_S * (distances < self.separation + 1.0).sum(axis=0)
        return np.asarray(separations), rows[least] + shares[chosen], np.asarray(above), np.asarray(seconds)


def _risks(laws: tuple[DeviationLaw, ...], room: Vector, above: Vector, seconds: Vector) -> Vector:
    """Return the chance that deviations close `room` (k,) [m] in `seconds`; `above`: sine of the elevation."""
    steps = 8  # from horizontal to upright
    angles = np.rint(np.where(np.isfinite(room), above, 0.0) * steps).astype(int)
    chances = np.zeros(len(room))
    for angle in np.unique(angles).tolist():
        closed, exceeded = _closing(laws, angle / steps)
        of_angle = angles == angle
        chances[of_angle] = np.interp(room[of_angle], closed, exceeded, right=0.0)
    moments = np.maximum(seconds / min(law.decorrelation_s for law in laws), 1.0)
    return np.asarray(1.0 - (1.0 - np.clip(chances, 0.0, 1.0)) ** moments)


@lru_cache(maxsize=64)
def _closing(laws: tuple[DeviationLaw, ...], above: float) -> tuple[Vector, Vector]:
    """Return increasing distances [m], and the chance that the vehicles together close more than each.

    Quantiles are of deviations towards a thing: those away from it are of the opposite side.
    """
    width = 0.05  # of the distances [m]
    horizontal = float(np.sqrt(1.0 - above**2))
    total = np.ones(1)
    least = 0.0
    for law, height in zip(laws, (above, -above), strict=False):
        towards, away = (law.down, law.up) if height > 0.0 else (law.up, law.down)
        for near, far, share in ((law.lateral, law.lateral, horizontal), (towards, away, abs(height))):
            if share > 0.0:
                begin = -share * far.distance(1e-7)
                edges = np.arange(begin, share * near.distance(1e-7) + width, width)
                opened = np.where(edges < 0.0, 1.0 - far.chance(-edges / share), 0.0)
                exceeded = np.maximum(near.chance(np.maximum(edges, 0.0) / share), opened)
                exceeded[[0, -1]] = [1.0, 0.0]
                total = np.convolve(total, -np.diff(exceeded))
                least += begin
    distances = least + width * np.arange(len(total) + 1)
    return np.asarray(distances), np.append(total[::-1].cumsum()[::-1], 0.0)


class Conflict(NamedTuple):
    pair: tuple[str, str]
    second: float  # most probable, after the start of all
    place: Vector  # (3,) east, north, up [m]
    distance_m: float  # expected; infinite with one on the ground
    probability: float


class PlannedDeparture(NamedTuple):
    flight: TimedFlight
    second: float


class Encounters:
    """The encounters of any two flights at a required `separation` [m], each pair computed once."""

    def __init__(self, separation: float) -> None:
        self.separation = separation
        self._met = dict[tuple[TimedFlight, TimedFlight], tuple[Encounter, ...]]()

    def of(self, a: TimedFlight, b: TimedFlight) -> tuple[Encounter, ...]:
        pair = (b, a) if (b, a) in self._met else (a, b)
        if pair not in self._met:
            self._met[pair] = tuple(encounters(*pair, self.separation))
        return self._met[pair]

    def probabilities(self, a: PlannedDeparture, b: PlannedDeparture, delays: Vector) -> Vector:
        """Return the probability (m,) of a loss of separation, with B `delays` (m,) [s] later than planned."""
        kept = np.ones(len(delays))
        for encounter in self.of(a.flight, b.flight):
            kept *= 1.0 - encounter.probabilities(_delays(encounter, a, b, delays))
        return np.asarray(1.0 - kept)

    def between(self, a: PlannedDeparture, b: PlannedDeparture, seen: float = 1e-6) -> Iterator[Conflict]:
        """Yield the conflicts of a pair that are more probable than `seen`."""
        for encounter in self.of(a.flight, b.flight):
            delays = _delays(encounter, a, b, np.zeros(1))
            probability = float(encounter.probabilities(delays)[0])
            if probability > seen:
                distance, sample = encounter.likeliest(float(delays[0]))
                second = (a if encounter.a is a.flight else b).second + STEP_S * sample
                pair = (a.flight.name, b.flight.name)
                yield Conflict(pair, second, encounter.a.places[round(sample)], distance, probability)

    def conflicts(self, departures: Sequence[PlannedDeparture]) -> list[Conflict]:
        """Return the conflicts of all pairs, most probable first."""
        found = [conflict for a, b in combinations(departures, 2) for conflict in self.between(a, b)]
        return sorted(found, key=lambda conflict: -conflict.probability)


def _delays(encounter: Encounter, a: PlannedDeparture, b: PlannedDeparture, later: Vector) -> Vector:
    """Return by how much the encounter's B departs after its A (m,) [s]."""
    delays = b.second + later - a.second
    return np.asarray(delays if encounter.a is a.flight else -delays)
