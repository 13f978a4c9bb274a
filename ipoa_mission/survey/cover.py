"""Lay lines over an area, and find the quickest tour of them."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, Literal, TypeAlias

import numpy as np
import shapely

from ipoa_mission import MissionError
from ipoa_mission.geometry import Plane, Points, Vector, union_of
from ipoa_mission.survey._kernels import NO_WAY, search_order
from ipoa_mission.survey.free import FreeSpace, Transits, narrow
from ipoa_mission.survey.survey_area import ARC, Area
from ipoa_mission.survey.survey_lines import (
    MAX_UNSEEN,
    GapCloser,
    LineAxes,
    area_seen_from,
    cut_lines,
    line_over,
    line_positions,
    polygons_of,
)
from ipoa_mission.survey.times import LegTimes
from ipoa_mission.survey.tour import Tour

Direction: TypeAlias = Literal["best", "crosshatch"] | float | Sequence[float]


@dataclass(frozen=True)
class SearchLimits:
    """The effort for one tour; `gap_cost_share`: of the cheapest closing of gaps."""

    directions: int = 36
    direction_difference: float = 1.0  # the least [degrees]
    shifts: tuple[float, ...] = (0.0, -1.0, 1.0, -0.5, 0.5)
    laid: int = 20  # directions and shifts whose lines are laid
    laid_without_holes: int = 4
    lines: int = 800
    order_rounds: int = 1000
    order_steps: float = 1e6
    gap_cost_share: float = 0.5
    refinements: int = 2


LIMITS = SearchLimits()


def quickest_tour(
    problem: "CoverProblem", direction: Direction = "best", begin: Vector | None = None, end: Vector | None = None
) -> Tour:
    """Return the quickest tour between places (2,) or None: lines along edges, detours to gaps."""
    if isinstance(direction, str):
        passes = [problem.directions()]
    else:
        passes = [[float(each)] for each in ([direction] if isinstance(direction, int | float) else direction)]
    places = list[Any]()
    is_on = list[bool]()
    while passes:
        is_last = not passes[1:] and direction != "crosshatch"
        best = problem.quickest_pass(passes.pop(0), begin, end if is_last else None)
        if places:
            transit = problem.transit(places[-1], best.tour.places[0])
            places += [*transit[1:-1]]
            is_on += [False] * (len(transit) - 1)
        places += [*best.tour.places]
        is_on += best.tour.is_on.tolist()
        begin = places[-1]
        if direction == "crosshatch":
            direction = "best"
            passes = [[best.degrees + 90.0]]
    return Tour(np.array(places), np.array(is_on))


@dataclass(frozen=True, eq=False)
class _Pass:
    """Lines (n, 2, 2) and their tour; `goals`: detours that close gaps; `unseen`: the excess unseen share."""

    degrees: float
    lines: Points
    tour: Tour
    seconds: float
    goals: list[Plane]
    unseen: float

    @property
    def rank(self) -> tuple[float, float]:
        return self.unseen, self.seconds


@dataclass(frozen=True, eq=False)
class CoverProblem:
    """An area to see by lines in `free`, `spacing` [m] apart; transits use `turns`, else `around`."""

    area: Any
    free: FreeSpace
    turns: FreeSpace
    around: FreeSpace
    spacing: float
    cost: LegTimes

    @classmethod
    def of(
        cls, area: Area, spacing: float, cost: LegTimes, keep_out: Any = None, turns_outside: float = 0.0
    ) -> "CoverProblem":
        """Return the problem; transits may leave the area by `turns_outside` [m]."""
        kept_out = shapely.Polygon() if keep_out is None else keep_out
        visible = area.visible(keep_out, spacing)
        free = FreeSpace.of(_where_lines_go(area.shape, kept_out, visible, spacing, cost.past_corners))
        if free.inner.is_empty:
            words = "nothing of the area may be flown over"
            raise MissionError(words, hint="it is in the keep-out", code="area-kept-out", place="survey")
        holes = union_of([shapely.Polygon(ring) for part in area.shape.geoms for ring in part.interiors])
        closed = holes.union(kept_out)
        turns = FreeSpace.of(area.shape.buffer(turns_outside).difference(closed)) if turns_outside > 0 else free
        reach = 2 * spacing + max(np.ptp(np.array(area.shape.bounds).reshape(2, 2), axis=0))
        around = FreeSpace.of(shapely.box(*area.shape.bounds).buffer(reach, join_style="mitre").difference(closed))
        return cls(visible, free, turns, around, spacing, cost)

    def directions(self) -> list[float]:
        """Return the directions of edges and hull, longest first [degrees]."""
        rings = [*shapely.get_rings(shapely.get_parts(self.free.shape)), self.area.convex_hull.exterior]
        legs = np.concatenate([np.diff(shapely.get_coordinates(ring), axis=0) for ring in rings])
        lengths = np.linalg.norm(legs, axis=1)
        degrees = np.degrees(np.arctan2(legs[:, 0], legs[:, 1])) % 180.0
        chosen = list[float]()
        for n in np.argsort(-lengths, kind="stable"):
            apart = [abs((degrees[n] - other + 90.0) % 180.0 - 90.0) for other in chosen]
            if min(apart, default=90.0) > LIMITS.direction_difference:
                chosen.append(float(degrees[n]))
        return chosen[: LIMITS.directions]

    def quickest_pass(self, degrees: list[float], begin: Vector | None, end: Vector | None) -> _Pass:
        rough = sorted((self._rough_seconds(each, shift), each, shift) for each in degrees for shift in LIMITS.shifts)
        laid = list[tuple[float, Points]]()
        count = 0
        has_holes = len(shapely.get_rings(self.free.shape)) > len(shapely.get_parts(self.free.shape))
        for _, each, shift in rough[: LIMITS.laid if has_holes else LIMITS.laid_without_holes]:
            if not laid or count + len(laid[-1][1]) <= LIMITS.lines:
                laid.append((each, self._laid(each, shift)))
                count += len(laid[-1][1])
        ordered = sorted((self._ordered(*lines, begin, end) for lines in laid), key=lambda each: each.seconds)
        best = self._closed(ordered[0], begin, end)
        least_cost = LIMITS.gap_cost_share * (best.seconds - ordered[0].seconds)
        for other in ordered[1:]:
            if best.rank <= (0.0, other.seconds + least_cost):
                break
            closed = self._closed(other, begin, end)
            least_cost = min(least_cost, LIMITS.gap_cost_share * (closed.seconds - other.seconds))
            best = min(best, closed, key=lambda each: each.rank)
        for _ in range(LIMITS.refinements):
            more = [goal[[0, -1]] for goal in best.goals if len(goal) < 3]
            if not more:
                break
            refined = self._ordered(best.degrees, np.concatenate([best.lines, more]), begin, end)
            closed = self._closed(refined, begin, end)
            if closed.rank >= best.rank:
                break
            best = closed
        return best

    def transit(self, start: Vector, end: Vector) -> Plane:
        """Return the corners from one place (2,) to another."""
        first = self._out(start)
        last = self._out(end)
        transits = Transits(np.array([first[-1], first[-1], last[-1], last[-1]]), self.turns, self.around, self.cost)
        if transits.times[0, 2] >= NO_WAY:
            raise _no_way_between_parts()
        return np.concatenate([first[:-1], transits.corners(0, 2), last[-2::-1]])

    def _rough_seconds(self, degrees: float, shift: float) -> float:
        lines = self._lines(degrees, shift)
        length = float(np.linalg.norm(lines[:, 1] - lines[:, 0], axis=1).sum())
        return length / self.cost.speed + self._turn_s * len(lines) + abs(shift)

    def _lines(self, degrees: float, shift: float) -> Points:
        grid = LineAxes.of(degrees)
        corners = [shapely.get_coordinates(ring) for ring in shapely.get_rings(shapely.get_parts(self.free.inner))]
        edges = np.concatenate([np.column_stack([ring[:-1], ring[1:]]) for ring in corners])
        lines = cut_lines(edges, grid, line_positions(self.area, grid, self.spacing, shift))
        min_length = 0.25 * self.spacing  # detours see shorter pieces
        return np.asarray(lines[np.linalg.norm(lines[:, 1] - lines[:, 0], axis=1) > min_length])

    def _laid(self, degrees: float, shift: float) -> Points:
        """Return lines, also over large gaps, and places in parts without any, (n, 2, 2)."""
        lines = self._lines(degrees, shift)
        min_area = 0.2 * self.spacing**2
        min_outline = 4.0 * self.spacing
        more = []
        for gap in polygons_of(self.area.difference(area_seen_from(lines, self.spacing))):
            if gap.area > min_area and gap.length > min_outline:
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
        transits = Transits(ends, self.turns, self.around, self.cost)
        along = np.array([self.cost.seconds(line) for each in lines for line in (each, each[::-1])])
        spots = np.repeat((lines[:, 0] == lines[:, 1]).all(axis=1), 2)
        along[spots] = self._turn_s / 2  # corner not known yet
        times = np.zeros((len(ends) + 2, len(ends) + 2))
        times[:-2, :-2] = transits.times
        times[-2, :-2], times[:-2, -2] = (self._seconds_to(place, ends) for place in (begin, end))
        rounds = int(min(10 * len(lines), LIMITS.order_rounds, LIMITS.order_steps / len(lines) ** 2))
        entries, seconds = search_order(times, along, rounds)
        if seconds >= NO_WAY:
            raise _no_way_between_parts()
        places = [ends[entries[0]]]
        is_on = list[bool]()
        for n, entry in enumerate(entries):
            corners = [*transits.corners(int(entries[n - 1]) ^ 1, int(entry))[1:]] if n else []
            places += [*corners, ends[entry ^ 1]]
            is_on += [False] * len(corners) + [True]
        tour = Tour(np.array(places), np.array(is_on))
        return _Pass(degrees, lines, tour, self._seconds(tour, begin, end), [], 1.0)

    def _closed(self, ordered: _Pass, begin: Vector | None, end: Vector | None) -> _Pass:
        tour, goals, unseen = GapCloser(self.area, self.spacing, self.turns, self.cost).close(ordered.tour)
        seconds = self._seconds(tour, begin, end)
        return replace(ordered, tour=tour, seconds=seconds, goals=goals, unseen=round(unseen, 4))

    def _seconds(self, tour: Tour, begin: Vector | None, end: Vector | None) -> float:
        before, after = ([] if place is None else [np.asarray(place, float)] for place in (begin, end))
        return self.cost.seconds(np.array([*before, *tour.places, *after]))

    def _out(self, place: Vector) -> Plane:
        """Return a place, then the nearest free one if the outline covers it, (1 or 2, 2)."""
        spot = shapely.Point(place)
        if self.around.shape.covers(spot) or self.turns.inner.is_empty:
            return np.array([place])
        return np.array([place, shapely.get_coordinates(shapely.shortest_line(self.turns.inner, spot))[0]])

    @cached_property
    def _turn_s(self) -> float:
        leg = 9e3  # [m]
        corners = np.array([[0.0, 0.0], [leg, 0.0], [leg, self.spacing], [0.0, self.spacing]])
        return self.cost.seconds(corners) - 2 * leg / self.cost.speed

    def _seconds_to(self, place: Vector | None, ends: Plane) -> Vector:
        """Return the time from each line end (2n, 2) to a place [s]."""
        if place is None:
            return np.zeros(len(ends))
        lines = [ends[[n ^ 1, n]] for n in range(len(ends))]
        return np.array([self.cost.seconds(np.array([*line, place])) - self.cost.seconds(line) for line in lines])


def _no_way_between_parts() -> MissionError:
    words = "no way leads between all parts of the area"
    return MissionError(words, hint="survey them one by one", code="area-parted", place="survey")


def _where_lines_go(area: Any, keep_out: Any, visible: Any, spacing: float, past: float) -> Any:
    """Return the area for lines, inset by the overshoot, but round holes."""
    outlines = union_of([shapely.Polygon(part.exterior) for part in area.geoms])
    # The missed area grows with the cube of the inset.
    inset = min(past, (0.25 * MAX_UNSEEN * spacing**2 * math.sqrt(area.area)) ** (1 / 3))
    simplification = min(0.03 * spacing, 0.1)  # [m], for fewer corners
    permitted = area.difference(keep_out)
    may_hide = visible.difference(permitted.buffer(spacing / 2, quad_segs=ARC)).area + MAX_UNSEEN / 10 * area.area
    for share in (1.0, 0.5, 0.0):
        inside = outlines.buffer(-share * inset, join_style="mitre").intersection(area)
        simple = narrow(inside, simplification).difference(keep_out)
        hidden = visible.difference(simple.buffer(spacing / 2, quad_segs=ARC)).area
        if len(shapely.get_parts(simple)) == len(shapely.get_parts(permitted)) and hidden <= may_hide:
            return simple
    return permitted
