from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from ipoa_mission import NotEnoughBattery
from ipoa_mission.geometry import Plane, Points, Vector, polyline_length
from ipoa_mission.mission.items import longest_part

MAX_PIECES = 64  # of a line


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
    """Places (n, 2) in flight order [m]; the sensor `is_on` from each to the next (n - 1,), on a straight line."""

    places: Plane
    is_on: NDArray[np.bool_]

    @classmethod
    def of(cls, swaths: Sequence[Swath], transits: Sequence[Plane]) -> "Tour":
        """`transits[n]` leads from line n to the next, both ends included."""
        places = [*swaths[0].ends]
        is_on = [True]
        for transit, swath in zip(transits, swaths[1:], strict=True):
            corners = [*transit[1:-1], swath.begin]
            if len(corners) == 1 and (swath.begin == places[-1]).all():
                corners = []
            places += [*corners, swath.end]
            is_on += [False] * len(corners) + [True]
        return cls(np.array(places), np.array(is_on))

    @property
    def lines(self) -> Points:
        """Return ends (k, 2, 2)."""
        return np.stack([self.places[:-1], self.places[1:]], axis=1)[self.is_on]

    @cached_property
    def swaths(self) -> tuple[Swath, ...]:
        return tuple(Swath(*ends) for ends in self.lines)

    @property
    def transits(self) -> list[Plane]:
        return [self.places[[a + 1, *range(a + 2, b), b]] for a, b in pairwise(np.flatnonzero(self.is_on).tolist())]

    @property
    def path(self) -> Plane:
        """Return the places without repeats."""
        return np.asarray(self.places[np.diff(self.numbers, prepend=-1) > 0])

    @property
    def numbers(self) -> NDArray[np.int64]:
        """Return each place's index in `path`."""
        moves = (np.diff(self.places, axis=0) != 0.0).any(axis=1)
        return np.concatenate([[0], np.cumsum(moves)])

    def part(self, first: int, last: int) -> "Tour":
        begin, end = np.flatnonzero(self.is_on)[[first, last - 1]].tolist()
        return Tour(self.places[begin : end + 2], self.is_on[begin : end + 1])

    def detour(self, leg: int, via: Plane) -> tuple["Tour", Plane]:
        """Return the tour by `via` from a leg (-1: before the path, last: after it), and those lines."""
        begin = max(leg, 0)
        line = np.concatenate([self.places[begin : leg + 1], via, self.places[leg + 1 : leg + 2]])
        places = np.concatenate([self.places[: leg + 1], via, self.places[leg + 1 :]])
        is_on = np.concatenate([self.is_on[:begin], np.ones(len(line) - 1, bool), self.is_on[leg + 1 :]])
        return Tour(places, is_on), line


def fewest_parts(tour: Tour, fits: Callable[[Tour], bool], overlap: float, guess: int = 1) -> Iterator[Tour]:
    """Yield the fewest parts that fit; the first is tried with `guess` lines.

    Lines that do not fit are cut with `overlap` [m]; raise NotEnoughBattery if no piece fits.
    """
    rest = tour
    while True:
        count = longest_part(lambda n, rest=rest: fits(rest.part(0, n)), len(rest.swaths), guess)  # type: ignore[misc]
        if count == 0:
            rest = _first_line_cut(rest, fits, overlap)
            continue
        yield rest.part(0, count)
        if count == len(rest.swaths):
            return
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
        return all(fits(Tour.of((piece,), ())) for piece in (pieces[0], pieces[-1]))

    if not fit(cut(MAX_PIECES)):
        east, north = swath.begin.tolist()
        words = f"expected enough charge to reach the line at east {east:.0f}, north {north:.0f} m, and back with the "
        hint = "begin nearer, or with a larger battery"
        raise NotEnoughBattery(f"{words}reserve, but it is too little", hint=hint, place="battery")
    pieces = next(filter(fit, map(cut, range(2, MAX_PIECES + 1))))
    between = [np.array([before.end, after.begin]) for before, after in pairwise(pieces)]
    return Tour.of((*pieces, *tour.swaths[1:]), (*between, *tour.transits))


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
