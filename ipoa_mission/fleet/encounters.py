"""Find the encounters of two flights, and the probability that they lose separation.

A vehicle is early or late, and off its path. With B later than A by an offset, the least distance of the expected
flights is a function of that offset. The probability is the mean, over the normally distributed offset, of the chance
that both deviations close the rest of the distance.

A vehicle waits on its pad before its departure, and remains where it landed. A pad that both use is free outside of
the flight.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np

from ipoa_mission.fleet.timed_flight import STEP_S, TimedFlight, within_pad
from ipoa_mission.forecast.deviation.law import DeviationLaw, Quantiles
from ipoa_mission.geometry import Points, Vector

FARTHEST_DEVIATION = 8.0  # of both vehicles towards each other [m]
MOST_OFFSET = 6.0  # standard deviations
APART_S = 20.0  # between two encounters
BATCH = 200_000  # pairs of samples
BIN = 0.05  # of closing distances [m]
ANGLES = 9  # of the line between two vehicles, from level to upright


@dataclass(frozen=True, eq=False)
class Encounter:
    """Two flights near to each other.

    B's clock is `first_offset` + k samples ahead of A's. The expected flights are `separations` (k,) [m] apart then, at
    samples `of_a` (k,) of A. They lose separation with the chances `risks` (k,), constant beyond both ends.
    `deviation_s`: standard deviation of the offset [s].
    """

    a: TimedFlight
    b: TimedFlight
    first_offset: int
    separations: Vector
    of_a: Vector
    risks: Vector
    deviation_s: float

    def probabilities(self, delays_s: Vector) -> Vector:
        """Return the probability of a loss of separation, with B departing `delays_s` (m,) [s] after A."""
        errors, weights = self._errors
        samples = self._samples(delays_s[:, None] + errors)
        risks = np.interp(samples, np.arange(len(self.risks)), self.risks)
        return np.asarray(risks @ weights)

    def likeliest(self, delay_s: float) -> tuple[float, float]:
        """Return the expected least distance [m], and A's sample at the likeliest loss, with B `delay_s` [s] later."""
        errors, weights = self._errors
        numbers = np.rint(self._samples(delay_s + errors)).clip(0, len(self.risks) - 1).astype(int)
        likeliest = numbers[np.argmax(weights * self.risks[numbers])]
        return float(self.separations[numbers[len(errors) // 2]]), float(self.of_a[likeliest])

    @cached_property
    def _errors(self) -> tuple[Vector, Vector]:
        """Return errors of the offset, and their probabilities, (k,) each [s]."""
        reach = round(MOST_OFFSET * self.deviation_s / STEP_S)
        errors = STEP_S * np.arange(-reach, reach + 1)
        weights = np.exp(-0.5 * (errors / self.deviation_s) ** 2)
        return errors, weights / weights.sum()

    def _samples(self, delays_s: Vector) -> Vector:
        return np.asarray(-delays_s / STEP_S - self.first_offset)


def encounters(a: TimedFlight, b: TimedFlight, separation: float) -> Iterator[Encounter]:
    """Yield where A and B may be nearer than `separation` [m], at whatever times they depart."""
    reach = separation + FARTHEST_DEVIATION + a.longest_step + b.longest_step
    near_b = b.tree.query(a.places[:-1], distance_upper_bound=reach)[0]
    for run in _runs(near_b):
        yield _encounter(a, b, run, separation, reach)
    for flying, standing in ((a, b), (b, a)):
        yield from _over_pads(flying, standing, separation)


def _runs(distances: Vector) -> Iterator[Vector]:
    """Yield the samples of each approach: those at a finite distance, and between them."""
    rows = np.flatnonzero(np.isfinite(distances))
    for run in np.split(rows, np.flatnonzero(np.diff(rows) > APART_S / STEP_S) + 1):
        if len(run) > 0:
            yield np.arange(run[0], run[-1] + 1)


def _over_pads(a: TimedFlight, b: TimedFlight, separation: float) -> Iterator[Encounter]:
    """Yield where A flies near the pads of B while B waits for its departure, or after it has landed."""
    steps = np.arange(len(a.places) - 1)
    in_air = ~(a.on_ground(steps) & a.on_ground(steps + 1))
    for sample in (0, len(b.places) - 1):
        pad = b.places[sample]
        if within_pad(a.places[[0, -1]] - pad).any():
            continue
        away = _closest(a.places[:-1] - pad, np.diff(a.places, axis=0))[0]
        distances = np.linalg.norm(away, axis=1)
        for run in _runs(np.where(in_air & (distances < separation + FARTHEST_DEVIATION), distances, np.inf)):
            yield _over_pad(a, b, sample, _Approach(run, away[run], separation))


@dataclass(frozen=True, eq=False)
class _Approach:
    """Samples (n,) of a flight near a place, and the way from that place (n, 3) [m]."""

    samples: Vector
    away: Points
    separation: float


def _over_pad(a: TimedFlight, b: TimedFlight, sample: int, approach: _Approach) -> Encounter:
    """Return the encounter with B on its pad before its first sample, or after its last one.

    With each further sample of offset, B leaves the pad one sample of A earlier, or is there one earlier.
    """
    waits = sample == 0
    order = slice(None) if waits else slice(None, None, -1)
    samples = approach.samples[order]
    away = approach.away[order]
    distances = np.linalg.norm(away, axis=1)
    least = np.minimum.accumulate(distances)
    nearest = np.maximum.accumulate(np.where(distances <= least, np.arange(len(least)), 0))
    upright = np.abs(away[nearest, 2]) / np.maximum(least, 1e-9)
    seconds = STEP_S * np.cumsum(distances < approach.separation + 1.0)
    risks = _risks((a.law,), least - approach.separation, upright, seconds)
    back = slice(None, None, -1) if waits else slice(None)
    none = np.array([np.inf]), np.zeros(1), np.zeros(1)
    parts = (least[back], samples[nearest][back], risks[back])
    joined = [np.concatenate([part, end] if waits else [end, part]) for part, end in zip(parts, none, strict=True)]
    last = approach.samples[-1] + 1
    meets = samples[nearest[-1]]
    return Encounter(
        a=a,
        b=b,
        first_offset=int(-last if waits else len(b.places) - last),
        separations=joined[0],
        of_a=joined[1],
        risks=joined[2],
        deviation_s=_deviation_s((a, int(meets)), (b, sample)),
    )


def _deviation_s(*met: tuple[TimedFlight, int]) -> float:
    """Return the standard deviation of the offset of flights that meet at these samples [s]."""
    return float(np.linalg.norm([(flight.time_deviations[n], flight.departure_deviation_s) for flight, n in met]))


def _encounter(a: TimedFlight, b: TimedFlight, rows: Vector, separation: float, reach: float) -> Encounter:
    near_a = a.part(rows).query(b.places[:-1], distance_upper_bound=reach)[0]
    columns = np.flatnonzero(np.isfinite(near_a))
    offsets = np.arange(columns[0] - rows[-1] - 1, columns[-1] - rows[0] + 2)
    parts = [
        _nearest(a, b, rows, batch, separation)
        for batch in np.array_split(offsets, 1 + len(rows) * len(offsets) // BATCH)
    ]
    separations, of_a, upright, seconds = map(np.concatenate, zip(*parts, strict=True))
    meets = int(np.argmin(separations))
    meets_b = int(np.clip(round(of_a[meets]) + offsets[meets], 0, len(b.places) - 1))
    risks = _risks((a.law, b.law), separations - separation, upright, seconds)
    risks[[0, -1]] = 0.0  # out of reach
    return Encounter(
        a=a,
        b=b,
        first_offset=int(offsets[0]),
        separations=separations,
        of_a=of_a,
        risks=risks,
        deviation_s=_deviation_s((a, round(of_a[meets])), (b, meets_b)),
    )


def _closest(away: Points, change: Points) -> tuple[Points, Vector]:
    """Return the closest point of approach to the origin on segments (..., 3) [m], and its share (...) of each."""
    squared = np.maximum((change**2).sum(axis=-1), 1e-12)
    shares = np.clip(-(away * change).sum(axis=-1) / squared, 0.0, 1.0)
    return np.asarray(away + shares[..., None] * change), np.asarray(shares)


def _nearest(
    a: TimedFlight, b: TimedFlight, rows: Vector, offsets: Vector, separation: float
) -> tuple[Vector, Vector, Vector, Vector]:
    """Return by offset (k,): least distance [m], A's sample, vertical share of the distance, seconds so near.

    Two vehicles on the ground are apart, unless on one pad.
    """
    of_b = rows[:, None] + offsets
    flown = (of_b >= 0) & (of_b < len(b.places) - 1)
    of_b = np.where(flown, of_b, 0)
    away = a.places[rows][:, None] - b.places[of_b]
    flown &= ~(a.on_ground(rows)[:, None] & b.on_ground(of_b)) | within_pad(away)
    change = (a.places[rows + 1] - a.places[rows])[:, None] - (b.places[of_b + 1] - b.places[of_b])
    nearest, shares = _closest(away, change)
    distances = np.where(flown, np.linalg.norm(nearest, axis=2), np.inf)
    least = distances.argmin(axis=0)
    chosen = least, np.arange(len(offsets))
    separations = distances[chosen]
    upright = np.abs(nearest[chosen][:, 2]) / np.maximum(separations, 1e-9)
    seconds = STEP_S * (distances < separation + 1.0).sum(axis=0)
    return separations, rows[least] + shares[chosen], upright, seconds


def _risks(laws: Sequence[DeviationLaw], room: Vector, upright: Vector, seconds: Vector) -> Vector:
    """Return the chance that deviations close `room` (k,) [m], of a line that is `upright` (0 to 1), for `seconds`."""
    angles = np.rint(np.where(np.isfinite(room), upright, 0.0) * (ANGLES - 1)).astype(int)
    chances = np.zeros(len(room))
    for angle in np.unique(angles).tolist():
        closed, exceeded = _closing(tuple(laws), angle / (ANGLES - 1))
        of_angle = angles == angle
        chances[of_angle] = np.interp(room[of_angle], closed, exceeded, right=0.0)
    moments = np.maximum(seconds / min(law.decorrelation_s for law in laws), 1.0)
    return np.asarray(1.0 - (1.0 - np.clip(chances, 0.0, 1.0)) ** moments)


@lru_cache(maxsize=64)
def _closing(laws: tuple[DeviationLaw, ...], upright: float) -> tuple[Vector, Vector]:
    """Return distances [m] and the chance that all vehicles together close more than each, the first from above."""
    level = float(np.sqrt(1.0 - upright**2))
    total = np.ones(1)
    least = 0.0
    heights = (law.up if n else law.down for n, law in enumerate(laws))
    for spread, share in (*((law.level, level) for law in laws), *((height, upright) for height in heights)):
        if share > 0.0:
            mass, begin = _density(spread, share)
            total = np.convolve(total, mass)
            least += begin
    distances = least + BIN * np.arange(len(total) + 1)
    return distances, np.append(total[::-1].cumsum()[::-1], 0.0)


def _density(spread: Quantiles, share: float) -> tuple[Vector, float]:
    """Return the probability of each bin of `share` of a deviation, and the first bin's begin [m]."""
    begin = share * spread.distances[0]
    edges = np.arange(begin, share * spread.distance(1e-7) + BIN, BIN)
    exceeded = spread.chance(edges / share)
    exceeded[-1] = 0.0
    return -np.diff(exceeded), begin
