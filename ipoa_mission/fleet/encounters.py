"""Find the encounters of two flights, and the probability that they lose separation.

A vehicle is early or late, and off its path. With B later than A by an offset, the least distance of the expected
flights is a function of that offset. The probability is the mean, over the normally distributed offset, of the chance
that both deviations close the rest of the distance.

A vehicle waits on its pad before its departure, and remains where it landed. A pad that both use is free outside of
the flight.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache

import numpy as np
from scipy.spatial import cKDTree

from ipoa_mission.fleet.timed_flight import STEP_S, Indices, TimedFlight, within_pad
from ipoa_mission.forecast.deviation.law import DeviationLaw, Quantiles
from ipoa_mission.geometry import Points, Vector

FARTHEST_DEVIATION = 8.0  # of both vehicles towards each other [m]
MOST_OFFSET = 6.0  # standard deviations
APART_S = 20.0  # between two encounters
BATCH = 200_000  # pairs of samples
BIN = 0.05  # of closing distances [m]
ANGLES = 9  # of the line between two vehicles, from horizontal to upright


@dataclass(frozen=True, eq=False)
class Encounter:
    """Two flights near to each other.

    B's clock is `first_offset` + k samples ahead of A's. The expected flights are `separations` (k,) [m] apart then, at
    samples `of_a` (k,) of A. They lose separation with the chances `risks` (k,), constant beyond both ends.
    `deviation_s`: standard deviation of the offset [s].
    """

    a: TimedFlight
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
        return np.asarray(errors), np.asarray(weights / weights.sum())

    def _samples(self, delays_s: Vector) -> Vector:
        return np.asarray(-delays_s / STEP_S - self.first_offset)


def encounters(a: TimedFlight, b: TimedFlight, separation: float) -> Iterator[Encounter]:
    """Yield where A and B may be nearer than `separation` [m], at whatever times they depart."""
    reach = separation + FARTHEST_DEVIATION + a.longest_step + b.longest_step
    for rows in _runs(b.tree.query(a.places[:-1], distance_upper_bound=reach)[0]):
        near_a = cKDTree(a.places[rows]).query(b.places[:-1], distance_upper_bound=reach)[0]
        columns = np.flatnonzero(np.isfinite(near_a))
        offsets = np.arange(columns[0] - rows[-1] - 1, columns[-1] - rows[0] + 2)
        yield _encounter(a, b, rows, offsets, separation)
    yield from _over_pads(a, b, separation)
    yield from _over_pads(b, a, separation)


def _runs(distances: Vector) -> Iterator[Indices]:
    """Yield the samples of each approach: those at a finite distance, and between them."""
    rows = np.flatnonzero(np.isfinite(distances))
    for run in np.split(rows, np.flatnonzero(np.diff(rows) > APART_S / STEP_S) + 1):
        if len(run) > 0:
            yield np.arange(run[0], run[-1] + 1)


def _over_pads(a: TimedFlight, b: TimedFlight, separation: float) -> Iterator[Encounter]:
    """Yield where A flies near the pads of B while B waits for its departure, or after it has landed."""
    reach = separation + FARTHEST_DEVIATION + a.longest_step
    for sample in (0, len(b.places) - 1):
        away = a.places[:-1] - b.places[sample]
        distances = np.linalg.norm(away, axis=1)
        if not within_pad(a.places[[0, -1]] - b.places[sample]).any():
            for rows in _runs(np.where(distances < reach, distances, np.inf)):
                yield _over_pad(a, b, sample, rows, separation)


def _over_pad(a: TimedFlight, b: TimedFlight, sample: int, rows: Indices, separation: float) -> Encounter:
    """Return the encounter with B on its pad before its first sample, or after its last one."""
    count = len(rows) + 1
    parked = replace(
        b,
        places=np.repeat(b.places[[sample]], count + 1, axis=0),
        lifts=count,
        time_deviations=np.repeat(b.time_deviations[[sample]], count + 1),
        law=None,
    )
    if sample == 0:
        offsets = np.arange(-rows[0], -rows[0] + count + 1)
        first_offset = offsets[0] - count
    else:
        offsets = np.arange(-rows[-1] - 1, -rows[0] + 1)
        first_offset = offsets[0] + sample
    return replace(_encounter(a, parked, rows, offsets, separation), first_offset=int(first_offset))


def _encounter(a: TimedFlight, b: TimedFlight, rows: Indices, offsets: Indices, separation: float) -> Encounter:
    """Return the encounter at A's samples `rows`, with B's clock `offsets` (k,) samples ahead."""
    batches = np.array_split(offsets, 1 + len(rows) * len(offsets) // BATCH)
    parts = [_nearest(a, b, rows, batch, separation) for batch in batches]
    separations, of_a, upright, seconds = map(np.concatenate, zip(*parts, strict=True))
    nearest = int(np.argmin(separations))
    meets = round(of_a[nearest])
    meets_b = int(np.clip(meets + offsets[nearest], 0, len(b.places) - 1))
    doubts = [a.time_deviations[meets], b.time_deviations[meets_b], a.departure_deviation_s, b.departure_deviation_s]
    return Encounter(
        a=a,
        first_offset=int(offsets[0]),
        separations=separations,
        of_a=of_a,
        risks=_risks(tuple(law for law in (a.law, b.law) if law), separations - separation, upright, seconds),
        deviation_s=float(np.linalg.norm(doubts)),
    )


def _closest(away: Points, change: Points) -> tuple[Points, Vector]:
    """Return the closest point of approach to the origin on segments (..., 3) [m], and its share (...) of each."""
    squared = np.maximum((change**2).sum(axis=-1), 1e-12)
    shares = np.clip(-(away * change).sum(axis=-1) / squared, 0.0, 1.0)
    return np.asarray(away + shares[..., None] * change), np.asarray(shares)


def _nearest(
    a: TimedFlight, b: TimedFlight, rows: Indices, offsets: Indices, separation: float
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
    return np.asarray(separations), rows[least] + shares[chosen], upright, np.asarray(seconds)


def _risks(laws: tuple[DeviationLaw, ...], room: Vector, upright: Vector, seconds: Vector) -> Vector:
    """Return the chance that deviations close `room` (k,) [m], of a line that is `upright` (0 to 1), for `seconds`."""
    angles = np.rint(np.where(np.isfinite(room), upright, 0.0) * (ANGLES - 1)).astype(int)
    chances = np.zeros(len(room))
    for angle in np.unique(angles).tolist():
        closed, exceeded = _closing(laws, angle / (ANGLES - 1))
        of_angle = angles == angle
        chances[of_angle] = np.interp(room[of_angle], closed, exceeded, right=0.0)
    moments = np.maximum(seconds / min(law.decorrelation_s for law in laws), 1.0)
    return np.asarray(1.0 - (1.0 - np.clip(chances, 0.0, 1.0)) ** moments)


@lru_cache(maxsize=64)
def _closing(laws: tuple[DeviationLaw, ...], upright: float) -> tuple[Vector, Vector]:
    """Return distances [m] and the chance that all vehicles together close more than each, the first from above."""
    horizontal = float(np.sqrt(1.0 - upright**2))
    total = np.ones(1)
    least = 0.0
    heights = (law.up if n else law.down for n, law in enumerate(laws))
    for spread, share in (*((law.lateral, horizontal) for law in laws), *((height, upright) for height in heights)):
        if share > 0.0:
            mass, begin = _density(spread, share)
            total = np.convolve(total, mass)
            least += begin
    distances = least + BIN * np.arange(len(total) + 1)
    return np.asarray(distances), np.append(total[::-1].cumsum()[::-1], 0.0)


def _density(spread: Quantiles, share: float) -> tuple[Vector, float]:
    """Return the probability of each bin of `share` of a deviation, and the first bin's begin [m]."""
    begin = share * spread.distances[0]
    edges = np.arange(begin, share * spread.distance(1e-7) + BIN, BIN)
    exceeded = spread.chance(edges / share)
    exceeded[-1] = 0.0
    return -np.diff(exceeded), begin
