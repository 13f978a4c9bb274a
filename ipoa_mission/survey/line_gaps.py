"""What a path over an area leaves unseen between the ends of its lines, and the least detours that see it."""

from dataclasses import dataclass, field
from typing import Any

import numpy as np
import shapely
from shapely.ops import substring

from ipoa_mission.geometry import Points, Vector, polyline_length
from ipoa_mission.survey._kernels import NO_WAY
from ipoa_mission.survey.free import FreeSpace, Ways
from ipoa_mission.survey.survey_lines import ARC, line_over, parts_of, seen_from
from ipoa_mission.survey.times import LegTimes
from ipoa_mission.world.union import union_of

LEFT = 7e-4  # share of the area that may stay unseen
PASSES = 8  # over all gaps that are left
USEFUL = 0.1  # share of a gap that a line must see
NEAR = 6  # detours that are tried for a gap
WHOLE = 0.6  # of an edge round a hole: where more of it is to be flown along, all of it may be
SEES = 1e-3  # of the spacing squared: a way that sees more of a gap has the sensor on
WITHIN = 0.999  # of half the width: as circles are polygons


@dataclass(frozen=True, eq=False)
class Detour:
    """From a leg of a path by places `via` (k, 2) on to its end: what leads to `goal` (m, 2), that, and the way on.

    Leg -1 and that after the last: before and after all. It takes `seconds` more.
    """

    leg: int
    via: Points
    goal: Points
    seconds: float


@dataclass
class SensedPath:
    """Places (n, 2) in the order flown, and whether the sensor is on from each to the next."""

    places: list[Points]
    is_on: list[bool] = field(default_factory=list)

    def legs(self, on: bool) -> Points:
        """Those on which the sensor is on, or off, (k, 2, 2)."""
        chosen = [n for n, each in enumerate(self.is_on) if each is on]
        return np.array([[self.places[n], self.places[n + 1]] for n in chosen]).reshape(-1, 2, 2)

    def lead(self, detour: Detour) -> Points:
        """Fly a detour, the sensor on; the places (k, 2) from where it leaves the path to where it is on it again."""
        n, via = detour.leg, list(detour.via)
        begin, end = self.places[max(n, 0) : n + 1], self.places[n + 1 : n + 2]
        self.places[n + 1 : n + 1] = via
        self.is_on[max(n, 0) : n + 1] = [True] * (len(begin) + len(via) + len(end) - 1)
        return np.array([*begin, *via, *end])


@dataclass(frozen=True, eq=False)
class Closing:
    """What is to be seen, in what width, where it may be flown, and what that costs."""

    area: Any
    width: float
    space: FreeSpace
    cost: LegTimes

    def gaps(self, route: SensedPath) -> Any:
        """What the route leaves unseen; where that is too much, ways that see some of it are switched on."""
        gaps = self.area.difference(seen_from(route.legs(True), self.width))
        too_much = gaps.area - LEFT * self.area.area
        off = [n for n, on in enumerate(route.is_on) if not on]
        if too_much <= 0.0 or not off:
            return gaps
        around = shapely.buffer(shapely.linestrings(route.legs(False)), self.width / 2, quad_segs=ARC)
        shapely.prepare(gaps)
        touched = np.flatnonzero(shapely.intersects(gaps, around))
        seen = shapely.area(shapely.intersection(around[touched], gaps))
        order = np.argsort(-seen, kind="stable")
        needed = (np.cumsum(seen[order]) - seen[order] < too_much) & (seen[order] > SEES * self.width**2)
        chosen = touched[order[needed]]
        for n in chosen:
            route.is_on[off[n]] = True
        return gaps.difference(union_of(around[chosen])) if len(chosen) else gaps

    def close(self, route: SensedPath, once: bool) -> tuple[list[Points], float]:
        """Lead the route by detours past what it leaves unseen, the largest gaps first, until little is left.

        Args:
            route: is changed.
            once: holes are gone round once, for all gaps along their edge, rather than to each of these.

        Returns:
            The lines (k, 2) and places (1, 2) to which the detours lead; the share that is left too much.
        """
        hopeless, led, left = list[Any](), list[Points](), self.gaps(route)
        for n in range(PASSES + 1):
            gaps = self._by_hole(parts_of(left)) if once else parts_of(left)
            gaps.sort(key=lambda gap: gap.area)
            lost = np.array([any(gap.equals(other) for other in hopeless) for gap in gaps], bool)
            areas = np.array([gap.area for gap in gaps])
            may_stay = max(LEFT * self.area.area - float(areas[lost].sum()), LEFT / 10 * self.area.area)
            too_much = np.cumsum(np.where(lost, 0.0, areas)) > may_stay
            tried = [gaps[k] for k in np.flatnonzero(too_much & ~lost)[::-1]]
            if not tried or n == PASSES:
                break
            seen = list[Any]()
            for gap in tried:
                if (detour := self._detour(route, gap)) is None:
                    hopeless.append(gap)
                else:
                    led.append(detour.goal)
                    seen.append(shapely.LineString(route.lead(detour)).buffer(self.width / 2, quad_segs=ARC))
            left = left.difference(union_of(seen))
        return led, max(float(areas.sum()) / self.area.area - LEFT, 0.0)

    def _by_hole(self, gaps: list[Any]) -> list[Any]:
        """The same, those along the edge of one hole as one."""
        rings = [ring for part in shapely.get_parts(self.space.inner) for ring in part.interiors]
        if not rings or not gaps:
            return gaps
        gap, ring = shapely.STRtree(rings).query_nearest(gaps, max_distance=self.width / 2, all_matches=False)
        others = np.setdiff1d(np.arange(len(gaps)), gap)
        return [union_of([gaps[n] for n in gap[ring == k]]) for k in np.unique(ring)] + [gaps[n] for n in others]

    def _detour(self, route: SensedPath, gap: Any) -> Detour | None:
        """The quickest one past a gap, straight if that can be; None where there is no way."""
        around = self._whence(gap)
        lines = [] if around is not None else self._lines(gap)
        if around is None and not lines:  # what is seen of it from where it is nearest
            around = shapely.Point(shapely.get_coordinates(shapely.shortest_line(self.space.inner, gap))[0])
            if gap.difference(around.buffer(self.width / 2)).area > (1 - USEFUL) * gap.area:
                return None
        legs = self._near(route, shapely.get_coordinates(gap.centroid)[0])
        straight = self._quickest(route, legs, around, lines, led=False)
        return straight or self._quickest(route, legs, around, lines, led=True)

    def _quickest(
        self, route: SensedPath, legs: list[int], around: Any | None, lines: list[Points], led: bool
    ) -> Detour | None:
        """The quickest detour from one of some legs, by ways `led` round corners or not."""
        best, least = None, np.inf
        for n in legs:
            before, after = route.places[max(n - 1, 0) : n + 1], route.places[n + 1 : n + 3]
            now = self.cost.seconds(np.array([*before, *after]))
            for goal in self._goals(around, lines, before[-1:], after[:1]):
                if self._at_least(before, goal, after) - now >= least:
                    continue
                via = self._led(before[-1:], goal, after[:1]) if led else goal
                if via is None:
                    continue
                straight = np.array([*before[-1:], *via, *after[:1]])
                if not led and not self.space.sees(straight[:-1], straight[1:]).diagonal().all():
                    continue
                seconds = self.cost.seconds(np.array([*before, *via, *after])) - now
                if seconds < least:
                    best, least = Detour(n, via, goal, seconds), seconds
        return best

    def _at_least(self, before: list[Vector], via: Points, after: list[Vector]) -> float:
        """What places before, a line and places after take at least, corners where they meet not counted [s]."""
        legs = np.diff(np.array([*before, via[0]]), axis=0), np.diff(np.array([via[-1], *after]), axis=0)
        return self.cost.seconds(via) + float(np.linalg.norm(np.concatenate(legs), axis=1).sum()) / self.cost.speed

    def _led(self, before: list[Vector], via: Points, after: list[Vector]) -> Points | None:
        """The same places with the ways to them and on from them round corners; None where there are none."""
        stops = [*before, via[0], via[-1], *after]
        ways = Ways(np.repeat(np.array(stops), 2, axis=0), self.space, self.space, self.cost)
        first, last = len(before), len(before) + 1
        way_in, way_out = np.empty((0, 2)), np.empty((0, 2))
        if before:
            if ways.times[0, 2 * first] >= NO_WAY:
                return None
            way_in = ways.way(0, 2 * first)[1:-1]
        if after:
            if ways.times[2 * last, 2 * last + 2] >= NO_WAY:
                return None
            way_out = ways.way(2 * last, 2 * last + 2)[1:-1]
        return np.concatenate([way_in, via, way_out])

    def _whence(self, gap: Any) -> Any | None:
        """Where all of a gap is seen from at once."""
        hull = shapely.get_coordinates(shapely.convex_hull(gap))[:-1]
        if len(hull) > 1 and np.ptp(hull, axis=0).max() > self.width:
            return None
        discs = shapely.buffer(shapely.points(hull), WITHIN * self.width / 2, quad_segs=ARC)
        around = shapely.intersection(shapely.intersection_all(discs), self.space.inner)
        return None if around.is_empty else around

    def _near(self, route: SensedPath, center: Vector) -> list[int]:
        """Legs of ways into which a detour to a place may be put; -1 and the last place: before and after all."""
        places = np.array(route.places)
        from_, to = places[:-1], places[1:]
        leg = to - from_
        share = np.clip(
            np.einsum("ij,ij->i", center - from_, leg) / np.maximum(np.einsum("ij,ij->i", leg, leg), 1e-12), 0, 1
        )
        away = np.linalg.norm(from_ + share[:, None] * leg - center, axis=1)
        away[np.array(route.is_on, bool)] = np.inf  # they must not be bent, as they see what nothing else does
        order = np.argsort(away, kind="stable")[:NEAR]
        found = [int(n) for n in order if np.isfinite(away[n])]
        return [*found, -1, len(places) - 1]

    def _lines(self, gap: Any) -> list[Points]:
        """The line (k, 2) that sees the most of a gap: straight through it, or along the edge that is nearest.

        Of an edge round a hole most of which that is, all of it too: it may be entered anywhere.
        """
        places = shapely.points(_densely(gap.boundary, self.width / 8))
        rings = shapely.get_rings(shapely.get_parts(self.space.inner))
        ring = rings[int(shapely.distance(rings, gap).argmin())]
        at = np.sort(shapely.line_locate_point(ring, places))
        widest = int(np.diff(at, append=at[0] + ring.length).argmax())
        start, end = float(at[(widest + 1) % len(at)]), float(at[widest])  # the long way round is left out
        spans = [(start, end)] if start <= end else [(start, ring.length), (0.0, end)]
        edge = np.concatenate([shapely.get_coordinates(substring(ring, *span)) for span in spans])
        edge = edge[np.concatenate([[True], np.linalg.norm(np.diff(edge, axis=0), axis=1) > 1e-6])]
        if polyline_length(edge) > WHOLE * ring.length and ring.distance(gap) < self.width / 2:
            return [edge, shapely.get_coordinates(ring)]
        line = line_over(gap, self.space.inner, self.width)
        found = [each for each in (line, edge) if each is not None and len(each) > 1]
        left = [gap.difference(shapely.LineString(each).buffer(self.width / 2, quad_segs=ARC)).area for each in found]
        quick = [n for n, area in enumerate(left) if area <= min(left) + USEFUL * gap.area]
        return [found[quick[0]]] if quick and left[quick[0]] < (1 - USEFUL) * gap.area else []

    def _goals(
        self, around: Any | None, lines: list[Points], before: list[Vector], after: list[Vector]
    ) -> list[Points]:
        """The places (k, 2) by which detours from one place to another see a gap."""
        ends = np.array([*before, *after])
        if lines:
            begun = [_begun_near(line, ends) for line in lines]
            return [each for line in begun for each in (line, line[::-1])]
        leg = shapely.LineString(ends) if len(ends) > 1 else shapely.Point(ends[0])
        return [shapely.get_coordinates(shapely.shortest_line(around, leg))[:1]]


def _begun_near(line: Points, places: Points) -> Points:
    """A line (n, 2); one that is closed begins at the corner that is nearest to some places."""
    if (line[0] != line[-1]).any():
        return line
    away = np.linalg.norm(line[:-1, None] - places, axis=2).sum(axis=1)
    return np.roll(line[:-1], -int(away.argmin()), axis=0)[[*range(len(line) - 1), 0]]


def _densely(shape: Any, spacing: float) -> Points:
    return np.asarray(shapely.get_coordinates(shapely.segmentize(shape, spacing)))
