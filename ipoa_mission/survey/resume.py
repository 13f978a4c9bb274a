"""Find the part of a tour that earlier flights left."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from ipoa_mission.geometry import Plane, Points
from ipoa_mission.ground import Ground
from ipoa_mission.survey.sight import Sight
from ipoa_mission.survey.tour import Swath, Tour

MAX_REST = 5.0  # of a line, left unflown or overshot [m]


def rest_of_tour(
    tour: Tour, flown: Sequence[Points], sight: Sight, ground: Ground, transit: Callable[[Points, Points], Points]
) -> Tour | None:
    """Return the lines that paths (n, 3) left, with overlap, or None; `transit` has corners between places (2,)."""
    pieces = list[list[tuple[float, float]]]([] for _ in tour.swaths)
    for path in flown:
        for run in runs_in_order(tour, path, sight, ground):
            pieces[run.line].append((run.begin, run.end))
    swaths = list[Swath]()
    transits = list[Plane]()
    before = -1
    for n, swath in enumerate(tour.swaths):
        for begin, end in _unflown_pieces(pieces[n], swath.length, sight):
            first = swath.at(begin) if begin > 0.0 else swath.begin
            piece = Swath(first, swath.at(end) if end < swath.length else swath.end)
            if swaths:
                is_next = before == n - 1 and (swaths[-1].end == tour.swaths[before].end).all() and begin == 0.0
                transits.append(tour.transits[n - 1] if is_next else transit(swaths[-1].end, piece.begin))
            swaths.append(piece)
            before = n
    return Tour.of(swaths, transits) if swaths else None


@dataclass(frozen=True)
class _Run:
    """A piece of a line between distances along it [m]; `at`: first path index."""

    at: int
    line: int
    begin: float
    end: float


def runs_in_order(tour: Tour, path: Points, sight: Sight, ground: Ground) -> list[_Run]:
    """Return the longest chain of runs with lines in order."""
    chains = dict[int, list[_Run]]()
    for run in sorted(_runs(tour, path, sight, ground), key=lambda run: run.at):
        before = [chains.get(run.line, [])]
        for line in range(run.line - 1, -1, -1):
            before.append(chains.get(line, []))
            if tour.swaths[line].length >= sight.spacing:  # shorter ones hardly show
                break
        chains[run.line] = [*max(before, key=_length), run]
    chain = max(chains.values(), key=_length, default=[])
    turn = sight.spacing / 2
    last = chain[-1].line if chain else 0
    runs = []
    for run in chain:
        length = tour.swaths[run.line].length
        begin = 0.0 if run.begin <= turn else run.begin
        end = length if run.line < last and run.end >= length - turn else run.end
        runs.append(replace(run, begin=begin, end=end))
    return [*runs, *(short for pair in pairwise(runs) for short in _short_lines_passed(tour, path, *pair, turn))]


def _short_lines_passed(tour: Tour, path: Points, before: _Run, after: _Run, turn: float) -> Iterator[_Run]:
    """Return the lines between two successive runs that are too short to show."""
    if before.end < tour.swaths[before.line].length or after.begin > 0.0:
        return
    index = before.at
    for line in range(before.line + 1, after.line):
        swath = tour.swaths[line]
        away = np.linalg.norm(path[index : after.at + 1, :2] - (swath.begin + swath.end) / 2, axis=1)
        if swath.length < 2 * turn and away.min() <= turn:
            index += int(away.argmin())
            yield _Run(index, line, 0.0, swath.length)


def _length(chain: list[_Run]) -> float:
    return sum(run.end - run.begin for run in chain)


def _runs(tour: Tour, path: Points, sight: Sight, ground: Ground) -> Iterator[_Run]:
    max_lateral = min(max(0.1 * sight.spacing, 2.0), 0.4 * sight.spacing)  # [m]
    max_slant = 0.25  # [m/m]
    is_high = path[:, 2] - ground(path) >= 0.9 * sight.least
    for line, swath in enumerate(tour.swaths):
        ahead = swath.ahead
        off = path[:, :2] - swath.begin
        along = off @ ahead
        aside = off @ np.array([-ahead[1], ahead[0]])
        is_on = is_high & (np.abs(aside) <= max_lateral) & (along >= -MAX_REST) & (along <= swath.length + MAX_REST)
        steps = np.diff(along)
        is_flown = is_on[:-1] & is_on[1:] & (np.abs(np.diff(aside)) <= max_slant * steps) & (steps > 0.0)
        edges = np.diff(np.concatenate([[0], is_flown.astype(int), [0]]))
        for first, after in zip(np.flatnonzero(edges > 0), np.flatnonzero(edges < 0), strict=True):
            run = _Run(int(first), line, max(float(along[first]), 0.0), min(float(along[after]), swath.length))
            if run.end - run.begin > min(MAX_REST, swath.length / 2):
                yield run


def _unflown_pieces(flown: list[tuple[float, float]], length: float, sight: Sight) -> list[tuple[float, float]]:
    end = min(MAX_REST, sight.spacing / 4)
    reached = 0.0
    left = list[tuple[float, float]]()
    for low, high in [*sorted(flown), (length, length)]:
        if low - reached > end or not flown:
            begin = max(reached - sight.piece_overlap, 0.0)
            until = min(low + sight.piece_overlap, length)
            if left and begin <= left[-1][1]:
                begin, _ = left.pop()
            left.append((begin, until))
        reached = max(reached, high)
    return left
