"""From which of several start places the lines of a survey are flown, and by how many flights: in the least time."""

import math
from collections.abc import Callable, Sequence
from itertools import groupby
from typing import Any, NamedTuple

import numpy as np
import shapely
from numpy.typing import NDArray

from ipoa_mission.geometry import Points, Vector
from ipoa_mission.survey.area import Area
from ipoa_mission.survey.times import LegTimes
from ipoa_mission.survey.tour import Sortie, Swath, Tour
from ipoa_mission.survey.tour_split import fewest_parts, first_cut, part_of

SURELY = 1.1  # times what a battery holds: a flight that seems to take more is not looked at
NEARLY = 1.002  # times what seemed to be the least time of all is as good
SLIVER = 1e-3  # of a spacing squared: what is smaller is no part of the area [m^2]


class RouteCost(NamedTuple):
    """What one flight takes: as a share of what it may take (1 and less can be flown), and its seconds."""

    share: float
    seconds: float

    @property
    def fits(self) -> bool:
        """Whether it can be flown."""
        return self.share <= 1.0


Try = Callable[[Sortie], RouteCost]


def nearest_areas(area: Area, starts: Points, spacing: float) -> list[Area | None]:
    """What of an area lies nearer to each start place (n, 2) than to the others; None where nothing does."""
    cells = shapely.get_parts(shapely.voronoi_polygons(shapely.MultiPoint(starts), extend_to=area.shape))
    found = list[Area | None]()
    for start in shapely.points(starts):
        here = area.shape if len(starts) == 1 else area.shape.intersection(_cell_of(start, cells))
        parts = [p for p in shapely.get_parts(here) if p.geom_type == "Polygon" and p.area > SLIVER * spacing**2]
        found.append(Area(shapely.MultiPolygon(parts)) if parts else None)
    return found


def _cell_of(start: Any, cells: Any) -> Any:
    return next(cell for cell in cells if cell.covers(start))


def nearest_parts(tour: Tour, starts: Points, tried: Try, overlap: float) -> tuple[Sortie, ...] | Swath:
    """The lines of a tour from the start place (n, 2) that is nearest to their middle, in as few flights each as fit.

    Where not even a piece of a line fits it is returned.
    """
    nearest = [int(np.argmin(np.linalg.norm(starts - (s.begin + s.end) / 2, axis=1))) for s in tour.swaths]
    parts, first = list[Sortie](), 0
    for start, same in groupby(nearest):
        last = first + len([*same])
        found = fewest_parts(part_of(tour, first, last), lambda part, n=start: tried(Sortie(part, n)).fits, overlap)  # type: ignore[misc]
        if isinstance(found, Swath):
            return found
        parts += [Sortie(part, start) for part in found]
        first = last
    return tuple(parts)


def quickest_parts(
    tour: Tour, starts: Points, times: LegTimes, tried: Try, overlap: float, most: float = math.inf
) -> tuple[tuple[Sortie, ...], float] | Swath | None:
    """The flights from start places (k, 2) that fly a tour in the least time, and these seconds.

    All cuts between lines and all start places are compared by the clock `times`; the flights of the best are tried,
    and what does not fit is left out, until all do, and take hardly more than they seemed to. A line that fits in no
    flight is cut, and what was seen up to `overlap` [m] before the cut is seen again; where even a piece of it does not
    fit it is returned. None where it would take more than `most` seconds. As clock and trials differ, a little less may
    be possible: of 41,000 random cases up to 6 lines and 2 places 2.3 % in the worst, and more than 0.2 % in 0.4 %.
    """
    known = dict[Any, RouteCost]()

    def once(part: Sortie) -> RouteCost:
        key = part.tour.swaths, part.start
        if key not in known:
            known[key] = tried(part)
        return known[key]

    while True:
        looks = _Looks(tour, starts, times, once)
        while (best := looks.best()) is not None:
            if (seems := looks.seconds_of(best)) > SURELY * most:
                return None
            trials = [looks.look(*one) for one in best]
            if all(trial.fits for trial in trials) and looks.seconds_of(best) <= NEARLY * seems:
                parts = tuple(Sortie(part_of(tour, first, last), start) for first, last, start in best)
                return parts, looks.seconds_of(best)
        for at in looks.stuck()[::-1]:
            ahead = part_of(tour, at, len(tour.swaths))
            cut = first_cut(ahead, lambda piece: any(once(Sortie(piece, n)).fits for n in range(len(starts))), overlap)
            if cut is None:
                return tour.swaths[at]
            tour = Tour((*tour.swaths[:at], *cut.swaths), (*tour.ways[:at], *cut.ways))


class _Looks:
    """What is known of the flights (first line, one after the last, start place) of a tour."""

    def __init__(self, tour: Tour, starts: Points, times: LegTimes, tried: Try) -> None:
        self.tour, self._tried = tour, tried
        self._known = dict[tuple[int, int, int], RouteCost]()
        begins, ends = (np.array([getattr(s, key) for s in tour.swaths]) for key in ("begin", "end"))
        there, back = (np.linalg.norm(each[None] - starts[:, None], axis=2) / times.speed for each in (begins, ends))
        self._seconds = there[:, :, None] + _within(tour, times)[None] + back[:, None, :]  # (start, first, last)
        count = len(tour.swaths)
        self._shut = np.broadcast_to(np.tri(count, count, -1, dtype=bool), self._seconds.shape).copy()
        self._per_second = np.zeros(len(starts))
        for start in range(len(starts)):
            nearest = int(there[start].argmin())
            seems = self._seconds[start, nearest, nearest]
            trial = self.look(nearest, nearest + 1, start)
            if math.isfinite(trial.seconds):  # what a climb and a landing take
                self._seconds[start] += max(trial.seconds - seems, 0.0)
                self._seconds[start, nearest, nearest] = trial.seconds
            self.look(0, count, start)

    def look(self, first: int, last: int, start: int) -> RouteCost:
        """Try a flight, and remember what follows for those that fly more or about as much."""
        key = first, last, start
        if key not in self._known:
            self._known[key] = trial = self._tried(Sortie(part_of(self.tour, first, last), start))
            if not trial.fits:
                self._shut[start, : first + 1, last - 1 :] = True
            if math.isfinite(trial.share) and math.isfinite(trial.seconds):
                self._per_second[start] = trial.share / trial.seconds
                self._seconds[start, first, last - 1] = trial.seconds
        return self._known[key]

    def best(self) -> list[tuple[int, int, int]] | None:
        """Those that seem to take the least time, of all flights against which nothing speaks; None: there are none."""
        count = len(self.tour.swaths)
        seems_too_much = self._seconds * self._per_second[:, None, None] > SURELY
        seems_too_much[:, np.arange(count), np.arange(count)] = False
        for first, last, start in self._known:
            seems_too_much[start, first, last - 1] = False
        costs: NDArray[np.float64] = np.where(self._shut | seems_too_much, np.inf, self._seconds)
        least, by = costs.min(axis=0), costs.argmin(axis=0)
        upto, cut = np.full(count + 1, np.inf), np.zeros(count + 1, int)
        upto[0] = 0.0
        for last in range(1, count + 1):
            ways = upto[:last] + least[:last, last - 1]
            cut[last] = int(ways.argmin())
            upto[last] = ways[cut[last]]
        if not math.isfinite(upto[count]):
            return None
        flights, last = list[tuple[int, int, int]](), count
        while last:
            first = int(cut[last])
            flights.insert(0, (first, last, int(by[first, last - 1])))
            last = first
        return flights

    def seconds_of(self, flights: Sequence[tuple[int, int, int]]) -> float:
        """About how long they take together [s]."""
        return sum(float(self._seconds[start, first, last - 1]) for first, last, start in flights)

    def stuck(self) -> list[int]:
        """The lines that are in no flight that fits."""
        alone = np.arange(len(self.tour.swaths))
        return [int(n) for n in np.flatnonzero(self._shut[:, alone, alone].all(axis=0))]


def _within(tour: Tour, times: LegTimes) -> Vector:
    """How long it is from where each line begins to where each other one ends (n, n) [s]."""
    begun, ended, path = list[float](), list[float](), tour.swaths[0].begin[None]
    for n, swath in enumerate(tour.swaths):
        if n:
            path = np.concatenate([path, tour.ways[n - 1]])
        begun.append(times.seconds(_no_stops(path)))
        path = np.concatenate([path, [swath.begin, swath.end]])
        ended.append(times.seconds(_no_stops(path)))
    return np.asarray(np.array(ended)[None] - np.array(begun)[:, None])


def _no_stops(path: Points) -> Points:
    return np.asarray(path[np.concatenate([[True], (np.diff(path, axis=0) != 0.0).any(axis=1)])])


def by_start(parts: Sequence[Sortie]) -> tuple[Sortie, ...]:
    """The same flights, those from one start place one after the other: the vehicle is moved as rarely as can be."""
    order = list(dict.fromkeys(part.start for part in parts))
    return tuple(sorted(parts, key=lambda part: order.index(part.start)))
