"""What of a survey is still to be flown: its lines without those along which a vehicle has flown.

A place of a line counts as flown where the vehicle went along the line beside it, near enough, as high as was asked,
and in the order of the lines: a way to them or home that happens to lead along one does not count.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from ipoa_mission.geometry import Points
from ipoa_mission.survey.sight import Sight
from ipoa_mission.survey.tour import Swath, Tour
from ipoa_mission.world.ground import Ground

ASIDE, NEAREST, FARTHEST = 0.1, 2.0, 0.4  # beside a line [spacings], but no less than so far [m], nor more [spacings]
SLANT = 0.25  # so much aside for each metre along it
LOW = 0.9  # of the height that was asked for
END = 5.0  # that a piece of a line may be long that counts all the same [m]; a quarter of the spacing at most
TINY = 0.01  # [m]

WayBetween = Callable[[Points, Points], Points]


def left_to_fly(
    tour: Tour, flown: Sequence[Points], sight: Sight, ground: Ground, way_between: WayBetween
) -> Tour | None:
    """The lines of a tour that are left, in their order; None where all are flown.

    What is left of a line begins so much before the place where it was left that photos overlap there.

    Args:
        tour: all of the survey.
        flown: paths on which the sensor was on but for turns, (n, 3) each, east, north, up [m].
        sight: how wide a line sees, and from how high.
        ground: under them.
        way_between: the corners of the way from one place (2,) to another, both with it.
    """
    again = max(sight.trigger or 0.0, sight.along / 2, 1.0)
    pieces = list[list[tuple[float, float]]]([] for _ in tour.swaths)
    for path in flown:
        for run in _in_order(tour, path, sight, ground):
            pieces[run.line].append((run.begin, run.end))
    swaths, ways, before = list[Swath](), list[Points](), -1
    for n, swath in enumerate(tour.swaths):
        for begin, end in _left(pieces[n], swath.length, sight, again):
            ahead = (swath.end - swath.begin) / max(swath.length, TINY)
            piece = Swath(
                swath.begin + begin * ahead if begin > 0.0 else swath.begin,
                swath.begin + end * ahead if end < swath.length else swath.end,
            )
            if swaths:
                is_next = before == n - 1 and (swaths[-1].end == tour.swaths[before].end).all() and begin == 0.0
                ways.append(tour.ways[n - 1] if is_next else way_between(swaths[-1].end, piece.begin))
            swaths.append(piece)
            before = n
    return Tour(tuple(swaths), tuple(ways)) if swaths else None


def is_along(tour: Tour, path: Points, sight: Sight, ground: Ground) -> bool:
    """Whether anything of a path (n, 3) was flown along the lines of a tour."""
    return bool(_in_order(tour, path, sight, ground))


@dataclass(frozen=True)
class _Run:
    """A piece of a line, from where to where along it [m], flown without a break; `at`: its first place of the path."""

    at: int
    line: int
    begin: float
    end: float


def _in_order(tour: Tour, path: Points, sight: Sight, ground: Ground) -> list[_Run]:
    """The longest part of what a path flew along lines in which line follows upon line."""
    chains = dict[int, list[_Run]]()  # the longest one so far that ends on each line
    for run in sorted(_runs(tour, path, sight, ground), key=lambda run: run.at):
        before = [chains.get(run.line, [])]
        for line in range(run.line - 1, -1, -1):
            before.append(chains.get(line, []))
            if tour.swaths[line].length >= sight.spacing:  # a shorter one is hardly to be seen in a path
                break
        chains[run.line] = [*max(before, key=_length), run]
    chain = max(chains.values(), key=_length, default=[])
    turn = sight.spacing / 2  # a corner may be cut by so much, as it is whenever the line is flown
    last = chain[-1].line if chain else 0
    runs = [
        replace(
            run,
            begin=0.0 if run.begin <= turn else run.begin,
            end=length if run.line < last and run.end >= (length := tour.swaths[run.line].length) - turn else run.end,
        )
        for run in chain
    ]
    return [*runs, *(found for pair in pairwise(runs) for found in _passed(tour, path, *pair, turn))]


def _passed(tour: Tour, path: Points, before: _Run, after: _Run, turn: float) -> Iterator[_Run]:
    """The lines between two that were flown one after the other, if the corners of each leave nothing straight of it.

    The path comes by the middle of each of them, in their order.
    """
    if before.end < tour.swaths[before.line].length or after.begin > 0.0:
        return
    at = before.at
    for line in range(before.line + 1, after.line):
        swath = tour.swaths[line]
        away = np.linalg.norm(path[at : after.at + 1, :2] - (swath.begin + swath.end) / 2, axis=1)
        if swath.length < 2 * turn and away.min() <= turn:
            at += int(away.argmin())
            yield _Run(at, line, 0.0, swath.length)


def _length(chain: list[_Run]) -> float:
    return sum(run.end - run.begin for run in chain)


def _runs(tour: Tour, path: Points, sight: Sight, ground: Ground) -> Iterator[_Run]:
    """What of each line was flown along in its sense, but for pieces that a turn may leave."""
    most = min(max(ASIDE * sight.spacing, NEAREST), FARTHEST * sight.spacing)
    is_high = path[:, 2] - ground(path) >= LOW * sight.least
    for line, swath in enumerate(tour.swaths):
        ahead = (swath.end - swath.begin) / max(swath.length, TINY)
        off = path[:, :2] - swath.begin
        along, aside = off @ ahead, off @ np.array([-ahead[1], ahead[0]])
        is_on = is_high & (np.abs(aside) <= most) & (along >= -END) & (along <= swath.length + END)
        steps = np.diff(along)
        is_flown = is_on[:-1] & is_on[1:] & (np.abs(np.diff(aside)) <= SLANT * steps) & (steps > 0.0)
        edges = np.diff(np.concatenate([[0], is_flown.astype(int), [0]]))
        for first, after in zip(np.flatnonzero(edges > 0), np.flatnonzero(edges < 0), strict=True):
            run = _Run(int(first), line, max(float(along[first]), 0.0), min(float(along[after]), swath.length))
            if run.end - run.begin > min(END, swath.length / 2):
                yield run


def _left(flown: list[tuple[float, float]], length: float, sight: Sight, again: float) -> list[tuple[float, float]]:
    """The pieces of a line of some length [m] that were not flown, each with what is flown again."""
    end, reached = min(END, sight.spacing / 4), 0.0
    left = list[tuple[float, float]]()
    for low, high in [*sorted(flown), (length, length)]:
        if low - reached > end or not flown:
            begin, until = max(reached - again, 0.0), min(low + again, length)
            if left and begin <= left[-1][1]:
                begin, _ = left.pop()
            left.append((begin, until))
        reached = max(reached, high)
    return left
