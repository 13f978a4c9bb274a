import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, Literal, TypeAlias

import numpy as np
import shapely

from ipoa_mission.errors import BadInput, MissionError
from ipoa_mission.geometry import Points, Vector
from ipoa_mission.scenario.survey_area import ARC, Area
from ipoa_mission.survey._kernels import NO_WAY
from ipoa_mission.survey._order import search_order
from ipoa_mission.survey.free import FreeSpace, Ways
from ipoa_mission.survey.line_gaps import MAX_UNSEEN, Closing, SensedPath
from ipoa_mission.survey.outline import narrower, wider
from ipoa_mission.survey.survey_lines import MIN_PIECE, LineAxes, cut, heights, line_over, parts_of, seen_from
from ipoa_mission.survey.times import LegTimes
from ipoa_mission.survey.tour import Swath, Tour
from ipoa_mission.world.polygon import union_of

#: Clockwise from north [degrees]; several: one pass each; crosshatch: the best and the one across.
Direction: TypeAlias = Literal["best", "crosshatch"] | float | Sequence[float]

MAX_LAID = 20  # directions and shifts
MAX_LAID_WHOLE = 4
MAX_LINES = 800
REFINEMENTS = 2
ASSUMED_SHARE = 0.5  # share of the smallest cost of closing gaps so far
GAP_AREA, GAP_OUTLINE = 0.2, 4.0  # [spacing^2], [spacing]: larger gaps get a line before ordering
TURN_LEG = 9e3  # [m]
MAX_DIRECTIONS = 36
MIN_DIRECTION_DIFFERENCE = 1.0  # [degrees]
SHIFTS = (0.0, -1.0, 1.0, -0.5, 0.5)
MAX_ROUNDS, MAX_STEPS = 1000, 1e6
INSET_SHARE = 0.25  # of the coverage budget
SIMPLIFICATION = 0.03  # [spacing]
EDGE_INSET, MAX_EDGE_INSET = 0.03, 0.1  # [spacing], [m]: for an area with fewer corners


def quickest_tour(
    area: Area,
    spacing: float,
    *,
    cost: LegTimes,
    keep_out: Any = None,
    direction: Direction = "best",
    turns_outside: float = 0.0,
    begin: Vector | None = None,
    end: Vector | None = None,
) -> Tour:
    """Return the quickest tour. Raises BadInput, MissionError.

    Args:
        area: to be seen; its holes are kept out of.
        spacing: between lines [m].
        cost: times of the vehicle.
        keep_out: a shapely geometry.
        direction: of the lines.
        turns_outside: how far ways may leave the area [m].
        begin: place before the tour (2,), or None for any.
        end: place after it (2,), or None.
    """
    _expect(spacing > 0 and math.isfinite(spacing), "spacing", "more than 0 m", spacing)
    _expect(turns_outside >= 0 and math.isfinite(turns_outside), "turns_outside", "0 m or more", turns_outside)
    survey = _Survey.of(area, spacing, keep_out, turns_outside, cost)
    if isinstance(direction, str):
        _expect(direction in ("best", "crosshatch"), "direction", "best, crosshatch or degrees", direction)
        passes = [survey.directions()]
    else:
        given = [float(direction)] if isinstance(direction, int | float) else [float(each) for each in direction]
        _expect(bool(given) and all(map(math.isfinite, given)), "direction", "degrees", direction)
        passes = [[degrees] for degrees in given]
    places, is_on = list[Any](), list[bool]()
    while passes:
        is_last = not passes[1:] and direction != "crosshatch"
        best = survey.quickest(passes.pop(0), begin, end if is_last else None)
        if places:
            way = survey.way(places[-1], best.route.places[0])
            places += list(way[1:-1])
            is_on += [False] * (len(way) - 1)
        places += best.route.places
        is_on += best.route.is_on
        begin = places[-1]
        if direction == "crosshatch":
            direction, passes = "best", [[best.degrees + 90.0]]
    return _tour_of(np.array(places), is_on)


def way_between(
    area: Area, spacing: float, *, cost: LegTimes, keep_out: Any = None, turns_outside: float = 0.0
) -> Callable[[Vector, Vector], Points]:
    """Return a function that gives the corners (k, 2) between two places (2,)."""
    return _Survey.of(area, spacing, keep_out, turns_outside, cost).way


def _expect(is_so: bool, place: str, words: str, given: object) -> None:
    if not is_so:
        raise BadInput(f"expected {words}, not {given}", place=place)


@dataclass(frozen=True, eq=False)
class _Pass:
    """Lines (n, 2, 2) and their route; `goals`: detours that close gaps; `unseen`: the excess unseen share."""

    degrees: float
    lines: Points
    route: SensedPath
    seconds: float
    goals: list[Points]
    unseen: float
    once: bool = False

    @property
    def worth(self) -> tuple[float, float]:
        return self.unseen, self.seconds


@dataclass(frozen=True, eq=False)
class _Survey:
    area: Any
    free: FreeSpace
    ways: FreeSpace
    around: FreeSpace
    spacing: float
    cost: LegTimes

    @classmethod
    def of(cls, area: Area, spacing: float, keep_out: Any, turns_outside: float, cost: LegTimes) -> "_Survey":
        kept = shapely.Polygon() if keep_out is None else _simpler(keep_out, area.shape, spacing)
        visible = area.visible(keep_out, spacing)
        free = FreeSpace.of(_where_lines_go(area.shape, kept, visible, spacing, cost.past_corners))
        if free.inner.is_empty:
            words = "nothing of the area may be flown over"
            raise MissionError(words, hint="it is in the keep-out", code="area-kept-out", place="survey")
        holes = union_of([shapely.Polygon(ring) for part in area.shape.geoms for ring in part.interiors])
        closed = holes.union(kept)
        ways = FreeSpace.of(area.shape.buffer(turns_outside).difference(closed)) if turns_outside > 0 else free
        reach = 2 * spacing + max(np.ptp(np.array(area.shape.bounds).reshape(2, 2), axis=0))
        around = FreeSpace.of(shapely.box(*area.shape.bounds).buffer(reach, join_style="mitre").difference(closed))
        return cls(visible, free, ways, around, spacing, cost)

    def directions(self) -> list[float]:
        """Return the directions of edges and hull, longest first [degrees]."""
        rings = [*shapely.get_rings(shapely.get_parts(self.free.shape)), self.area.convex_hull.exterior]
        legs = np.concatenate([np.diff(shapely.get_coordinates(ring), axis=0) for ring in rings])
        lengths = np.linalg.norm(legs, axis=1)
        degrees = np.degrees(np.arctan2(legs[:, 0], legs[:, 1])) % 180.0
        found = list[float]()
        for n in np.argsort(-lengths, kind="stable"):
            apart = [abs((degrees[n] - other + 90.0) % 180.0 - 90.0) for other in found]
            if min(apart, default=90.0) > MIN_DIRECTION_DIFFERENCE:
                found.append(float(degrees[n]))
        return found[:MAX_DIRECTIONS]

    def quickest(self, degrees: list[float], begin: Vector | None, end: Vector | None) -> _Pass:
        """Return the quickest pass; only the most promising are computed in full."""
        looked = sorted((self._rough(each, shift), each, shift) for each in degrees for shift in SHIFTS)
        laid, lines = list[tuple[float, Points]](), 0
        for _, each, shift in looked[: MAX_LAID if self._is_holed else MAX_LAID_WHOLE]:
            if not laid or lines + len(laid[-1][1]) <= MAX_LINES:
                laid.append((each, self._laid(each, shift)))
                lines += len(laid[-1][1])
        ordered = sorted((self._ordered(*one, begin, end) for one in laid), key=lambda one: one.seconds)
        best = min(
            (self._closed(ordered[0], once, begin, end) for once in sorted({False, self._is_holed})),
            key=lambda one: one.worth,
        )
        assumed = ASSUMED_SHARE * (best.seconds - ordered[0].seconds)
        for one in ordered[1:]:
            if best.worth <= (0.0, one.seconds + assumed):
                break
            closed = self._closed(one, best.once, begin, end)
            assumed = min(assumed, ASSUMED_SHARE * (closed.seconds - one.seconds))
            best = min(best, closed, key=lambda one: one.worth)
        for _ in range(REFINEMENTS):
            more = [goal[[0, -1]] for goal in best.goals if len(goal) < 3]
            if not more:
                break
            one = self._ordered(best.degrees, np.concatenate([best.lines, more]), begin, end)
            closed = self._closed(one, best.once, begin, end)
            if closed.worth >= best.worth:
                break
            best = closed
        return best

    def _rough(self, degrees: float, shift: float) -> float:
        """Return the approximate time of the lines [s]."""
        lines = self._lines(degrees, shift)
        length = float(np.linalg.norm(lines[:, 1] - lines[:, 0], axis=1).sum())
        return length / self.cost.speed + self._turn * len(lines) + abs(shift)

    def _lines(self, degrees: float, shift: float) -> Points:
        grid = LineAxes.of(degrees)
        rings = shapely.get_rings(shapely.get_parts(self.free.inner))
        corners = [shapely.get_coordinates(ring) for ring in rings]
        edges = np.concatenate([np.column_stack([ring[:-1], ring[1:]]) for ring in corners])
        lines = cut(edges, grid, heights(self.area, grid, self.spacing, shift))
        return np.asarray(lines[np.linalg.norm(lines[:, 1] - lines[:, 0], axis=1) > MIN_PIECE * self.spacing])

    def _laid(self, degrees: float, shift: float) -> Points:
        lines = self._lines(degrees, shift)
        more = []
        for gap in parts_of(self.area.difference(seen_from(lines, self.spacing))):
            if gap.area > GAP_AREA * self.spacing**2 and gap.length > GAP_OUTLINE * self.spacing:
                line = line_over(gap, self.free.inner, self.spacing)
                more += [] if line is None else [line]
        lines = np.concatenate([lines, np.array(more).reshape(-1, 2, 2)])
        drawn = shapely.linestrings(lines)
        parts = [part for part in shapely.get_parts(self.free.inner) if not shapely.intersects(part, drawn).any()]
        worth_it = [part for part in parts if part.area > MAX_UNSEEN * self.area.area / 10 or not len(lines)]
        spots = [shapely.get_coordinates(part.representative_point()) for part in worth_it]
        return np.concatenate([lines, np.array(spots).repeat(2, axis=0).reshape(-1, 2, 2)])

    def _ordered(self, degrees: float, lines: Points, begin: Vector | None, end: Vector | None) -> _Pass:
        ends = np.ascontiguousarray(lines.reshape(-1, 2))
        ways = Ways(ends, self.ways, self.around, self.cost)
        along = np.array([self.cost.seconds(line) for each in lines for line in (each, each[::-1])])
        spots = np.repeat((lines[:, 0] == lines[:, 1]).all(axis=1), 2)
        along[spots] = self._turn / 2  # corner not known yet
        times = np.zeros((len(ends) + 2, len(ends) + 2))
        times[:-2, :-2] = ways.times
        times[-2, :-2], times[:-2, -2] = (self._reach(ends, place) for place in (begin, end))
        rounds = int(min(10 * len(lines), MAX_ROUNDS, MAX_STEPS / len(lines) ** 2))
        entries, seconds = search_order(np.arange(len(lines), dtype=np.int64) * 2, times, along, rounds)
        if seconds >= NO_WAY:
            raise _parted()
        route = _route(entries, ways)
        return _Pass(degrees, lines, route, self._seconds(route, begin, end), [], 1.0)

    def _closed(self, one: _Pass, once: bool, begin: Vector | None, end: Vector | None) -> _Pass:
        """Return the pass with detours to its gaps; `once` round holes instead of to each gap."""
        route = SensedPath([*one.route.places], [*one.route.is_on])
        goals, unseen = Closing(self.area, self.spacing, self.ways, self.cost).close(route, once)
        seconds = self._seconds(route, begin, end)
        return replace(one, route=route, seconds=seconds, goals=goals, unseen=round(unseen, 4), once=once)

    def _seconds(self, route: SensedPath, begin: Vector | None, end: Vector | None) -> float:
        return self.cost.seconds(np.array([*_known(begin), *route.places, *_known(end)]))

    def way(self, start: Vector, end: Vector) -> Points:
        """Return the corners (k, 2) from one place to another. Raises MissionError."""
        first, last = self._out(start), self._out(end)
        ways = Ways(np.array([first[-1], first[-1], last[-1], last[-1]]), self.ways, self.around, self.cost)
        if ways.times[0, 2] >= NO_WAY:
            raise _parted()
        return np.concatenate([first[:-1], ways.way(0, 2), last[-2::-1]])

    def _out(self, place: Vector) -> Points:
        """Return a place, then the nearest free one if the outline covers it, (1 or 2, 2)."""
        spot = shapely.Point(place)
        if self.around.shape.covers(spot) or self.ways.inner.is_empty:
            return np.array([place])
        return np.array([place, shapely.get_coordinates(shapely.shortest_line(self.ways.inner, spot))[0]])

    @cached_property
    def _is_holed(self) -> bool:
        return len(shapely.get_rings(self.free.shape)) > len(shapely.get_parts(self.free.shape))

    @cached_property
    def _turn(self) -> float:
        corners = np.array([[0.0, 0.0], [TURN_LEG, 0.0], [TURN_LEG, self.spacing], [0.0, self.spacing]])
        return self.cost.seconds(corners) - 2 * TURN_LEG / self.cost.speed

    def _reach(self, ends: Points, place: Vector | None) -> Vector:
        """Return the time from each line end (2n, 2) to a place [s]."""
        if place is None:
            return np.zeros(len(ends))
        lines = [ends[[n ^ 1, n]] for n in range(len(ends))]
        return np.array([self.cost.seconds(np.array([*line, place])) - self.cost.seconds(line) for line in lines])


def _known(place: Vector | None) -> list[Vector]:
    return [] if place is None else [np.asarray(place, float)]


def _parted() -> MissionError:
    return MissionError(
        "no way leads between all parts of the area", hint="survey them one by one", code="area-parted", place="survey"
    )


def _simpler(kept: Any, area: Any, spacing: float) -> Any:
    edge = float(kept.boundary.intersection(area).length)
    most = SIMPLIFICATION * spacing if edge <= 0.0 else min(SIMPLIFICATION * spacing, MAX_UNSEEN / 2 * area.area / edge)
    return wider(kept, most)


def _where_lines_go(area: Any, kept: Any, visible: Any, spacing: float, past: float) -> Any:
    """Return the area for lines, inset by the overshoot. Holes get no inset: it takes many more lines."""
    outlines = union_of([shapely.Polygon(part.exterior) for part in area.geoms])
    # The missed area grows with the cube of the inset.
    inset = min(past, (INSET_SHARE * MAX_UNSEEN * spacing**2 * math.sqrt(area.area)) ** (1 / 3))
    whole = area.difference(kept)
    may_hide = visible.difference(whole.buffer(spacing / 2, quad_segs=ARC)).area + MAX_UNSEEN / 10 * area.area
    for share in (1.0, 0.5, 0.0):
        inside = outlines.buffer(-share * inset, join_style="mitre").intersection(area)
        simple = narrower(inside, min(EDGE_INSET * spacing, MAX_EDGE_INSET)).difference(kept)
        hidden = visible.difference(simple.buffer(spacing / 2, quad_segs=ARC)).area
        if len(shapely.get_parts(simple)) == len(shapely.get_parts(whole)) and hidden <= may_hide:
            return simple
    return whole


def _route(entries: Any, ways: Ways) -> SensedPath:
    route = SensedPath([ways.ends[entries[0]]])
    for n, entry in enumerate(entries):
        if n:
            way = ways.way(int(entries[n - 1]) ^ 1, int(entry))
            route.places += list(way[1:])
            route.is_on += [False] * (len(way) - 1)
        route.places.append(ways.ends[entry ^ 1])
        route.is_on.append(True)
    return route


def _tour_of(places: Points, is_on: list[bool]) -> Tour:
    swaths, ways, way = list[Swath](), list[Points](), list[Points]()
    for n, on in enumerate(is_on):
        if on:
            if swaths:
                ways.append(np.array([swaths[-1].end, *way, places[n]]))
            swaths.append(Swath(places[n], places[n + 1]))
            way = []
        elif swaths and n + 1 < len(is_on) and not is_on[n + 1]:
            way.append(places[n + 1])
    return Tour(tuple(swaths), tuple(ways))
