"""Tours of lines, and their split into flights from home or from start places."""

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from itertools import groupby, pairwise
from typing import NamedTuple

import numpy as np

from ipoa_mission.forecast.contingency.energy_budget import greatest_fitting
from ipoa_mission.geometry import Plane, Vector, polyline_length
from ipoa_mission.survey.times import LegTimes

MAX_PIECES = 64  # of a line
MAX_ESTIMATED_SHARE = 1.1  # of battery and best time


@dataclass(frozen=True, eq=False)
class Swath:
    """A straight line with the sensor on, east and north (2,) [m]."""

    begin: Vector
    end: Vector

    @property
    def ends(self) -> Plane:
        return np.array([self.begin, self.end])

    @property
    def length(self) -> float:
        return float(np.linalg.norm(self.end - self.begin))

    @property
    def ahead(self) -> Vector:
        return np.asarray((self.end - self.begin) / max(self.length, 1e-9))

    def at(self, distance: float) -> Vector:
        return np.asarray(self.begin + distance * self.ahead)


@dataclass(frozen=True, eq=False)
class Tour:
    """Lines in flight order; `transits[n]` leads from line n to the next."""

    swaths: tuple[Swath, ...]
    transits: tuple[Plane, ...]

    @property
    def path(self) -> Plane:
        """Return all corners, without repeats."""
        if not self.swaths:
            return np.empty((0, 2))
        pieces = [self.swaths[0].ends]
        for transit, swath in zip(self.transits, self.swaths[1:], strict=True):
            pieces += [transit, swath.ends]
        return without_repeats(np.concatenate(pieces))

    def part(self, first: int, last: int) -> "Tour":
        return Tour(self.swaths[first:last], self.transits[first : last - 1])

    def moved(self, move: Callable[[Plane], Plane]) -> "Tour":
        return Tour(tuple(Swath(*move(s.ends)) for s in self.swaths), tuple(map(move, self.transits)))


@dataclass(frozen=True, eq=False)
class Sortie:
    """The lines of one flight; `start` is the index of its place, or None for home."""

    tour: Tour
    start: int | None = None


def without_repeats(path: Plane) -> Plane:
    return np.asarray(path[np.concatenate([[True], (np.diff(path, axis=0) != 0.0).any(axis=1)])])


class RouteCost(NamedTuple):
    """A flight's cost: share of its limit (at most 1 can be flown), and seconds."""

    share: float
    seconds: float

    @property
    def fits(self) -> bool:
        return self.share <= 1.0


@dataclass(frozen=True, eq=False)
class StartSites:
    """Start places; `forecast_cost` tries a flight; cut lines have an `overlap` [m]."""

    places: Plane
    times: LegTimes
    forecast_cost: Callable[[Sortie], RouteCost]
    overlap: float
    _costs: dict[tuple[tuple[Swath, ...], int | None], RouteCost] = field(default_factory=dict, init=False, repr=False)

    def cost(self, part: Sortie) -> RouteCost:
        key = part.tour.swaths, part.start
        if key not in self._costs:
            self._costs[key] = self.forecast_cost(part)
        return self._costs[key]

    def can_fly(self, tour: Tour) -> bool:
        return any(self.cost(Sortie(tour, start)).fits for start in range(len(self.places)))


class Unreached(Exception):
    """No piece of a line fits into a flight."""

    def __init__(self, swath: Swath) -> None:
        super().__init__()
        self.swath = swath


def fewest_parts(tour: Tour, fits: Callable[[Tour], bool], overlap: float, guess: int = 1) -> Iterator[Tour]:
    """Yield the fewest parts that fit; the first is tried with `guess` lines.

    Lines that do not fit are cut with `overlap` [m].

    Raises:
        Unreached: no piece of a line fits.
    """
    rest = tour
    while rest.swaths:
        count = greatest_fitting(lambda n, rest=rest: fits(rest.part(0, n)), len(rest.swaths), guess)  # type: ignore[misc]
        if count == 0:
            rest = _first_line_cut(rest, fits, overlap)
            continue
        yield rest.part(0, count)
        rest = rest.part(count, len(rest.swaths))
        guess = count


def _first_line_cut(tour: Tour, fits: Callable[[Tour], bool], overlap: float) -> Tour:
    """Cut the first line into the fewest pieces that fit."""
    swath = tour.swaths[0]

    def cut(count: int) -> list[Swath]:
        ends = swath.length * np.arange(count + 1) / count
        begins = [0.0, *np.maximum(ends[1:-1] - overlap, 0.0)]
        return [Swath(swath.at(begin), swath.at(end)) for begin, end in zip(begins, ends[1:], strict=True)]

    def fit(pieces: list[Swath]) -> bool:
        return all(fits(Tour((piece,), ())) for piece in (pieces[0], pieces[-1]))

    if not fit(cut(MAX_PIECES)):
        raise Unreached(swath)
    pieces = next(filter(fit, map(cut, range(2, MAX_PIECES + 1))))
    between = tuple(np.array([before.end, after.begin]) for before, after in pairwise(pieces))
    return Tour((*pieces, *tour.swaths[1:]), (*between, *tour.transits))


def parts_of_equal_length(tour: Tour, count: int) -> tuple[Tour, ...]:
    """Return `count` parts, the longest as short as possible, transits from and to home included."""
    lines = np.array([swath.length for swath in tour.swaths])
    transits = np.array([0.0, *(polyline_length(transit) for transit in tour.transits)])
    upto = np.concatenate([[0.0], np.cumsum(lines + transits)])
    there = np.array([np.linalg.norm(swath.begin) for swath in tour.swaths]) - transits
    back = np.array([np.linalg.norm(swath.end) for swath in tour.swaths])
    total = len(lines)

    def cuts(longest: float) -> list[int]:
        borders = [0]
        while borders[-1] < total and len(borders) <= count:
            first = borders[-1]
            lengths = upto[first + 1 :] - upto[first] + there[first] + back[first:]
            parts_left = count - len(borders)  # have a line each
            fitting = int(np.argmax(lengths > longest)) if (lengths > longest).any() else len(lengths)
            borders.append(first + max(min(fitting, total - first - parts_left), 1))
        return borders

    low = 0.0
    high = float(upto[-1] + there.max() + back.max() + transits.sum())
    for _ in range(60):
        middle = (low + high) / 2
        low, high = (low, middle) if cuts(middle)[-1] >= total else (middle, high)
    return tuple(tour.part(first, after) for first, after in pairwise(cuts(high)))


def nearest_parts(tour: Tour, sites: StartSites) -> Iterator[Sortie]:
    """Assign each line to the nearest start place, in few flights."""
    nearest = [int(np.argmin(np.linalg.norm(sites.places - (s.begin + s.end) / 2, axis=1))) for s in tour.swaths]
    first = 0
    for start, same in groupby(nearest):
        last = first + len([*same])
        parts = fewest_parts(tour.part(first, last), lambda p, n=start: sites.cost(Sortie(p, n)).fits, sites.overlap)  # type: ignore[misc]
        yield from (Sortie(part, start) for part in parts)
        first = last


def quickest_parts(
    tour: Tour, sites: StartSites, max_seconds: float = math.inf
) -> tuple[tuple[Sortie, ...], float] | None:
    """Return the flights from start places that fly a tour in the least time, and their seconds.

    The best cuts and starts by `sites.times` are tried until all fit. Return None above `max_seconds`.

    Raises:
        Unreached: no piece of a line fits.
    """
    while True:
        trials = _Trials(tour, sites)
        best = trials.best()
        while best is not None:
            estimate = trials.seconds_of(best)
            if estimate > MAX_ESTIMATED_SHARE * max_seconds:
                return None
            costs = [trials.try_flight(*flight) for flight in best]
            is_confirmed = trials.seconds_of(best) <= 1.002 * estimate
            if all(cost.fits for cost in costs) and is_confirmed:
                parts = tuple(Sortie(tour.part(first, last), start) for first, last, start in best)
                return parts, trials.seconds_of(best)
            best = trials.best()
        for line in trials.unreachable()[::-1]:
            cut = _first_line_cut(tour.part(line, len(tour.swaths)), sites.can_fly, sites.overlap)
            tour = Tour((*tour.swaths[:line], *cut.swaths), (*tour.transits[:line], *cut.transits))


class _Trials:
    """Costs by (first line, one after the last, start place)."""

    def __init__(self, tour: Tour, sites: StartSites) -> None:
        self._tour = tour
        self._cost = sites.cost
        speed = sites.times.speed
        self._known = dict[tuple[int, int, int], RouteCost]()
        begins = np.array([swath.begin for swath in tour.swaths])
        ends = np.array([swath.end for swath in tour.swaths])
        there, back = (np.linalg.norm(each[None] - sites.places[:, None], axis=2) / speed for each in (begins, ends))
        # [start, first, last]
        self._seconds = there[:, :, None] + _seconds_within(tour, sites.times)[None] + back[:, None, :]
        count = len(tour.swaths)
        self._failed = np.broadcast_to(np.tri(count, count, -1, dtype=bool), self._seconds.shape).copy()
        self._share_per_second = np.zeros(len(sites.places))
        for start in range(len(sites.places)):
            nearest = int(there[start].argmin())
            estimate = self._seconds[start, nearest, nearest]
            trial = self.try_flight(nearest, nearest + 1, start)
            if math.isfinite(trial.seconds):
                self._seconds[start] += max(trial.seconds - estimate, 0.0)
                self._seconds[start, nearest, nearest] = trial.seconds
            self.try_flight(0, count, start)

    def try_flight(self, first: int, last: int, start: int) -> RouteCost:
        """Try a flight; update the estimates of longer and similar ones."""
        key = first, last, start
        if key not in self._known:
            self._known[key] = trial = self._cost(Sortie(self._tour.part(first, last), start))
            if not trial.fits:
                self._failed[start, : first + 1, last - 1 :] = True
            if math.isfinite(trial.share) and math.isfinite(trial.seconds):
                self._share_per_second[start] = trial.share / trial.seconds
                self._seconds[start, first, last - 1] = trial.seconds
        return self._known[key]

    def best(self) -> list[tuple[int, int, int]] | None:
        """Return the quickest flights, by dynamic programming."""
        count = len(self._tour.swaths)
        is_excluded = self._seconds * self._share_per_second[:, None, None] > MAX_ESTIMATED_SHARE
        is_excluded[:, np.arange(count), np.arange(count)] = False
        for first, last, start in self._known:
            is_excluded[start, first, last - 1] = False
        costs = np.where(self._failed | is_excluded, np.inf, self._seconds)
        least = costs.min(axis=0)
        quickest_start = costs.argmin(axis=0)
        upto = np.full(count + 1, np.inf)
        cut = np.zeros(count + 1, int)
        upto[0] = 0.0
        for last in range(1, count + 1):
            totals = upto[:last] + least[:last, last - 1]
            cut[last] = int(totals.argmin())
            upto[last] = totals[cut[last]]
        if not math.isfinite(upto[count]):
            return None
        flights = list[tuple[int, int, int]]()
        last = count
        while last:
            first = int(cut[last])
            flights.insert(0, (first, last, int(quickest_start[first, last - 1])))
            last = first
        return flights

    def seconds_of(self, flights: Sequence[tuple[int, int, int]]) -> float:
        return sum(float(self._seconds[start, first, last - 1]) for first, last, start in flights)

    def unreachable(self) -> list[int]:
        alone = np.arange(len(self._tour.swaths))
        return [int(n) for n in np.flatnonzero(self._failed[:, alone, alone].all(axis=0))]


def _seconds_within(tour: Tour, times: LegTimes) -> Vector:
    """Return the times from each line's begin to each other's end (n, n) [s]."""
    begun = list[float]()
    ended = list[float]()
    path = tour.swaths[0].begin[None]
    for n, swath in enumerate(tour.swaths):
        if n:
            path = np.concatenate([path, tour.transits[n - 1]])
        begun.append(times.seconds(without_repeats(path)))
        path = np.concatenate([path, swath.ends])
        ended.append(times.seconds(without_repeats(path)))
    return np.asarray(np.array(ended)[None] - np.array(begun)[:, None])
