from collections.abc import Callable, Iterator, Sequence
from itertools import pairwise

import numpy as np

from ipoa_mission.geometry import polyline_length
from ipoa_mission.routing.battery_split import greatest_fitting
from ipoa_mission.survey.tour import Swath, Tour

MAX_PIECES = 64
HALVINGS = 60  # for the length of the longest flight

Fits = Callable[[Tour], bool]


def part_of(tour: Tour, first: int, last: int) -> Tour:
    return Tour(tour.swaths[first:last], tour.ways[first : last - 1])


def fewest_parts(tour: Tour, fits: Fits, overlap: float, guess: int = 1) -> tuple[Tour, ...] | Swath:
    """Return the fewest parts that fit; the first is tried with `guess` lines.

    Lines that do not fit are cut with `overlap` [m]; return a line of which no piece fits.
    """
    parts, ahead = list[Tour](), tour
    while ahead.swaths:
        before = len(parts[-1].swaths) if parts else guess
        count = greatest_fitting(lambda n, ahead=ahead: fits(part_of(ahead, 0, n)), len(ahead.swaths), before)  # type: ignore[misc]
        if count == 0:
            cut = first_cut(ahead, fits, overlap)
            if cut is None:
                return ahead.swaths[0]
            ahead = cut
            continue
        parts.append(part_of(ahead, 0, count))
        ahead = part_of(ahead, count, len(ahead.swaths))
    return tuple(parts)


def first_cut(tour: Tour, fits: Fits, overlap: float) -> Tour | None:
    """Return the tour with its first line in the fewest pieces that fit, or None."""
    swath = tour.swaths[0]

    def all_fit(pieces: Sequence[Swath]) -> bool:
        return all(fits(Tour((piece,), ())) for piece in (pieces[0], pieces[-1]))

    if not all_fit([*_pieces(swath, MAX_PIECES, overlap)]):
        return None
    for count in range(2, MAX_PIECES + 1):
        pieces = tuple(_pieces(swath, count, overlap))
        if all_fit(pieces):
            between = tuple(np.array([one.end, other.begin]) for one, other in pairwise(pieces))
            return Tour((*pieces, *tour.swaths[1:]), (*between, *tour.ways))
    return None


def _pieces(swath: Swath, count: int, overlap: float) -> Iterator[Swath]:
    ahead = (swath.end - swath.begin) / max(swath.length, 1e-9)
    for n in range(count):
        begin = max(swath.length * n / count - (overlap if n else 0.0), 0.0)
        yield Swath(swath.begin + begin * ahead, swath.begin + swath.length * (n + 1) / count * ahead)


def parts_of_equal_length(tour: Tour, count: int) -> tuple[Tour, ...]:
    """Return `count` parts, the longest as short as possible, ways from and to home included."""
    lines = np.array([swath.length for swath in tour.swaths])
    ways = np.array([0.0, *(polyline_length(way) for way in tour.ways)])
    upto = np.concatenate([[0.0], np.cumsum(lines + ways)])
    there = np.array([np.linalg.norm(swath.begin) for swath in tour.swaths]) - ways
    back = np.array([np.linalg.norm(swath.end) for swath in tour.swaths])
    total = len(lines)

    def cuts(most: float) -> list[int]:
        found = [0]
        while found[-1] < total and len(found) <= count:
            first = found[-1]
            lengths = upto[first + 1 :] - upto[first] + there[first] + back[first:]
            left = count - len(found)  # following parts have a line each
            fitting = int(np.argmax(lengths > most)) if (lengths > most).any() else len(lengths)
            found.append(first + max(min(fitting, total - first - left), 1))
        return found

    least, most = 0.0, float(upto[-1] + there.max() + back.max() + ways.sum())
    for _ in range(HALVINGS):
        middle = (least + most) / 2
        least, most = (least, middle) if cuts(middle)[-1] >= total else (middle, most)
    return tuple(part_of(tour, a, b) for a, b in pairwise(cuts(most)))
