"""The quickest tour of parallel lines that sees all of an area and keeps inside it."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal, TypeAlias

import numpy as np
import shapely

from ipoa_mission.errors import BadInput, MissionError
from ipoa_mission.geometry import Points, Vector
from ipoa_mission.survey._kernels import NO_WAY, search_order
from ipoa_mission.survey.area import Area
from ipoa_mission.survey.free import FreeSpace, Ways
from ipoa_mission.survey.gaps import Closing, SensedPath
from ipoa_mission.survey.lines import SHORT, LineAxes, cut, heights, line_over, parts_of, seen_from
from ipoa_mission.survey.times import LegTimes
from ipoa_mission.survey.tour import Swath, Tour

#: Of the lines, clockwise from north [degrees]; several: one pass in each; crosshatch: the best one and the one across.
Direction: TypeAlias = Literal["best", "crosshatch"] | float | Sequence[float]

BUILT = 3  # directions of which the lines are laid out, of all that are looked at
MOST_LOOKED_AT = 36
ALIKE_DEG = 1.0  # directions nearer to each other are one
SHIFTS = (0.0, -1.0, 1.0)
ROUNDS, STEPS = 1000, 1e6  # of the search that find nothing better, and so many for the square of the number of lines
SIMPLER = 0.01  # of the spacing: by so much what is kept out of may grow, to have fewer corners


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
    """The tour that takes the least time.

    Args:
        area: what is to be seen; its holes are kept out of.
        spacing: between lines [m]: what lies within half of it of a line is seen.
        cost: how long the vehicle takes.
        keep_out: a shapely geometry that neither lines nor ways enter, obstacles grown by their clearance.
        direction: of the lines.
        turns_outside: how far ways may leave the area [m].
        begin: where the vehicle comes from (2,); left out, it does not matter.
        end: where it goes afterwards (2,).

    Returns:
        Lines and ways; the same for the same arguments.

    Raises:
        BadInput: naming the argument.
        MissionError: nothing of the area may be flown over, or there is no way between its parts.
    """
    _expect(spacing > 0 and math.isfinite(spacing), "spacing: expected more than 0 m", spacing)
    _expect(turns_outside >= 0 and math.isfinite(turns_outside), "turns_outside: expected 0 m or more", turns_outside)
    survey = _Survey.of(area, spacing, keep_out, turns_outside, cost)
    if isinstance(direction, str):
        _expect(direction in ("best", "crosshatch"), "direction: expected best, crosshatch or degrees", direction)
        best = survey.best_layout(survey.directions(), begin, end)
        layouts = [best]
        if direction == "crosshatch":
            layouts.append(survey.best_layout([best.degrees + 90.0], begin, end))
    else:
        given = [float(direction)] if isinstance(direction, int | float) else [float(each) for each in direction]
        _expect(bool(given) and all(map(math.isfinite, given)), "direction: expected degrees", direction)
        layouts = [survey.best_layout([degrees], begin, end) for degrees in given]
    return survey.tour(layouts, begin, end)


def _expect(is_so: bool, words: str, given: object) -> None:
    if not is_so:
        raise BadInput(f"{words}, not {given}")


@dataclass(frozen=True, eq=False)
class _Layout:
    """Lines (n, 2, 2) in one direction, an order of them by entries (n,), and what it costs [s]."""

    degrees: float
    lines: Points
    entries: Any
    seconds: float


@dataclass(frozen=True, eq=False)
class _Survey:
    """What is to be seen, from where, and where ways lead: in the area, or round what is kept out of to other parts."""

    area: Any
    free: FreeSpace
    ways: FreeSpace
    around: FreeSpace
    spacing: float
    cost: LegTimes

    @classmethod
    def of(cls, area: Area, spacing: float, keep_out: Any, turns_outside: float, cost: LegTimes) -> "_Survey":
        kept = shapely.Polygon() if keep_out is None else keep_out.buffer(SIMPLER * spacing, quad_segs=4)
        kept = kept.simplify(SIMPLER * spacing)
        free = FreeSpace.of(area.shape.difference(kept))
        if free.inner.is_empty:
            raise MissionError("survey: nothing of the area may be flown over", hint="it lies in what is kept out of")
        holes = shapely.union_all([shapely.Polygon(ring) for part in area.shape.geoms for ring in part.interiors])
        closed = holes.union(kept)
        ways = FreeSpace.of(area.shape.buffer(turns_outside).difference(closed)) if turns_outside > 0 else free
        reach = 2 * spacing + max(np.ptp(np.array(area.shape.bounds).reshape(2, 2), axis=0))
        around = FreeSpace.of(shapely.box(*area.shape.bounds).buffer(reach, join_style="mitre").difference(closed))
        can = area.shape.intersection(free.shape.buffer(spacing / 2)) if keep_out is not None else area.shape
        return cls(can, free, ways, around, spacing, cost)

    def directions(self) -> list[float]:
        """Those of the edges, and of the hull's, the longest first, but no two alike [degrees]."""
        rings = [*shapely.get_rings(shapely.get_parts(self.free.shape)), self.area.convex_hull.exterior]
        legs = np.concatenate([np.diff(shapely.get_coordinates(ring), axis=0) for ring in rings])
        lengths = np.linalg.norm(legs, axis=1)
        degrees = np.degrees(np.arctan2(legs[:, 0], legs[:, 1])) % 180.0
        found = list[float]()
        for n in np.argsort(-lengths, kind="stable"):
            apart = [abs((degrees[n] - other + 90.0) % 180.0 - 90.0) for other in found]
            if min(apart, default=90.0) > ALIKE_DEG:
                found.append(float(degrees[n]))
        return found[:MOST_LOOKED_AT]

    def best_layout(self, degrees: list[float], begin: Vector | None, end: Vector | None) -> _Layout:
        """The quickest of directions, some of them looked at closely."""
        looked = [(self._rough(each, shift), each, shift) for each in degrees for shift in SHIFTS]
        laid = [self._layout(each, shift, begin, end) for _, each, shift in sorted(looked)[:BUILT]]
        return min(laid, key=lambda layout: layout.seconds)

    def _rough(self, degrees: float, shift: float) -> float:
        """About how long lines in a direction take, ways not counted [s]."""
        lines = self._lines(degrees, shift)
        away = 1.0 if shift else 0.0
        turn = self.cost.seconds(np.array([[0.0, 0.0], [9e3, 0.0], [9e3, self.spacing], [0.0, self.spacing]]))
        turn -= 18e3 / self.cost.speed
        return (
            float(np.linalg.norm(lines[:, 1] - lines[:, 0], axis=1).sum()) / self.cost.speed + turn * len(lines) + away
        )

    def _lines(self, degrees: float, shift: float) -> Points:
        grid = LineAxes.of(degrees)
        rings = shapely.get_rings(shapely.get_parts(self.free.inner))
        corners = [shapely.get_coordinates(ring) for ring in rings]
        edges = np.concatenate([np.column_stack([ring[:-1], ring[1:]]) for ring in corners])
        lines = cut(edges, grid, heights(self.area, grid, self.spacing, shift))
        return lines[np.linalg.norm(lines[:, 1] - lines[:, 0], axis=1) > SHORT * self.spacing]

    def _layout(self, degrees: float, shift: float, begin: Vector | None, end: Vector | None) -> _Layout:
        """The lines of a direction, with those that holes make necessary besides, quickly put in order."""
        lines = self._lines(degrees, shift)
        gaps = self.area.difference(seen_from(lines, self.spacing))
        more = []
        for gap in parts_of(gaps):
            if gap.area > 0.05 * self.spacing**2 and gap.length > 2.5 * self.spacing:
                line = line_over(gap, self.free.inner, self.spacing)
                more += [] if line is None else [line]
        lines = np.concatenate([lines, np.array(more).reshape(-1, 2, 2)])
        if not len(lines):
            spot = shapely.get_coordinates(self.free.inner.representative_point())
            lines = np.array([[spot[0], spot[0]]])
        return self._ordered(degrees, lines, np.arange(len(lines)) * 2, begin, end, 0)[0]

    def _ordered(
        self, degrees: float, lines: Points, entries: Any, begin: Vector | None, end: Vector | None, rounds: int
    ) -> tuple[_Layout, Ways]:
        ends = np.ascontiguousarray(lines.reshape(-1, 2))
        ways = Ways(ends, self.ways, self.around, self.cost)
        along = np.array([self.cost.seconds(line) for each in lines for line in (each, each[::-1])])
        times = np.zeros((len(ends) + 2, len(ends) + 2))
        times[:-2, :-2] = ways.times
        times[-2, :-2], times[:-2, -2] = (self._reach(ends, place) for place in (begin, end))
        best, seconds = search_order(np.asarray(entries, np.int64), times, along, rounds)
        if seconds >= NO_WAY:
            raise MissionError("survey: no way leads between all parts of the area", hint="survey them one by one")
        return _Layout(degrees, lines, best, float(seconds)), ways

    def _reach(self, ends: Points, place: Vector | None) -> Vector:
        """How long it is from each end (n, 2) to a place, or nothing [s]."""
        if place is None:
            return np.zeros(len(ends))
        return np.asarray(np.linalg.norm(ends - np.asarray(place, float), axis=1) / self.cost.speed)

    def tour(self, layouts: list[_Layout], begin: Vector | None, end: Vector | None) -> Tour:
        """The tour of one pass after the other, ordered well, its gaps closed."""
        places, is_on = list[Any](), list[bool]()
        for n, layout in enumerate(layouts):
            count = len(layout.lines)
            rounds = int(min(10 * count, ROUNDS, STEPS / count**2))
            here = begin if n == 0 else np.asarray(places[-1])
            there = end if n == len(layouts) - 1 else None
            ordered, ways = self._ordered(layout.degrees, layout.lines, layout.entries, here, there, rounds)
            route = self._route(ordered, ways)
            Closing(self.area, self.spacing, self.ways, self.cost).close(route)
            if n:
                join = Ways(np.array([places[-1]] * 2 + [route.places[0]] * 2), self.ways, self.around, self.cost)
                way = join.way(0, 2)
                places += list(way[1:-1])
                is_on += [False] * (len(way) - 1)
            places += route.places
            is_on += route.is_on
        return _tour_of(np.array(places), is_on)

    def _route(self, layout: _Layout, ways: Ways) -> SensedPath:
        """An order as places, and where the sensor is on."""
        ends = ways.ends
        route = SensedPath([ends[layout.entries[0]]])
        for n, entry in enumerate(layout.entries):
            if n:
                way = ways.way(int(layout.entries[n - 1]) ^ 1, int(entry))
                route.places += list(way[1:])
                route.is_on += [False] * (len(way) - 1)
            route.places.append(ends[entry ^ 1])
            route.is_on.append(True)
        return route


def _tour_of(places: Points, is_on: list[bool]) -> Tour:
    """Legs with the sensor on as lines, those between them as ways."""
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
