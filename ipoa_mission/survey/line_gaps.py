"""Find unseen gaps between lines, and the shortest detours that see them."""

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
from ipoa_mission.world.polygon import union_of

MAX_UNSEEN = 7e-4  # of the area
MAX_PASSES = 8
MIN_SHARE_SEEN = 0.1  # of a gap
MAX_TRIED_LEGS = 6
WHOLE_EDGE_SHARE = 0.6  # of an edge round a hole
MIN_SEEN = 1e-3  # [spacing^2], of a gap
DISC_SHARE = 0.999  # circles are polygons


@dataclass(frozen=True, eq=False)
class Detour:
    """A detour from a leg by the places `via` (k, 2), with `goal` (m, 2), to the leg's end.

    Leg -1 is before the path, the last one after it.
    """

    leg: int
    via: Points
    goal: Points
    seconds: float


@dataclass
class SensedPath:
    """Places (n, 2), and whether the sensor is on after each."""

    places: list[Points]
    is_on: list[bool] = field(default_factory=list)

    def legs(self, on: bool) -> Points:
        chosen = [n for n, each in enumerate(self.is_on) if each is on]
        return np.array([[self.places[n], self.places[n + 1]] for n in chosen]).reshape(-1, 2, 2)

    def insert(self, detour: Detour) -> Points:
        """Insert a detour; return its places (k, 2) with both ends on the path."""
        n, via = detour.leg, list(detour.via)
        begin, end = self.places[max(n, 0) : n + 1], self.places[n + 1 : n + 2]
        self.places[n + 1 : n + 1] = via
        self.is_on[max(n, 0) : n + 1] = [True] * (len(begin) + len(via) + len(end) - 1)
        return np.array([*begin, *via, *end])


@dataclass(frozen=True, eq=False)
class Closing:
    area: Any
    width: float
    space: FreeSpace
    cost: LegTimes

    def gaps(self, route: SensedPath) -> Any:
        """Return the gaps; large ones switch the sensor on along ways that see them."""
        gaps = self.area.difference(seen_from(route.legs(True), self.width))
        too_much = gaps.area - MAX_UNSEEN * self.area.area
        off = [n for n, on in enumerate(route.is_on) if not on]
        if too_much <= 0.0 or not off:
            return gaps
        around = shapely.buffer(shapely.linestrings(route.legs(False)), self.width / 2, quad_segs=ARC)
        shapely.prepare(gaps)
        touched = np.flatnonzero(shapely.intersects(gaps, around))
        seen = shapely.area(shapely.intersection(around[touched], gaps))
        order = np.argsort(-seen, kind="stable")
        needed = (np.cumsum(seen[order]) - seen[order] < too_much) & (seen[order] > MIN_SEEN * self.width**2)
        chosen = touched[order[needed]]
        for n in chosen:
            route.is_on[off[n]] = True
        return gaps.difference(union_of(around[chosen])) if len(chosen) else gaps

    def close(self, route: SensedPath, once: bool) -> tuple[list[Points], float]:
        """Insert detours into `route` past its largest gaps.

        With `once`, one detour round a hole sees all gaps along its edge. Return the lines (k, 2) and places (1, 2) of
        detours, and the unseen share beyond the limit.
        """
        hopeless, goals, left = list[Any](), list[Points](), self.gaps(route)
        for n in range(MAX_PASSES + 1):
            gaps = self._by_hole(parts_of(left)) if once else parts_of(left)
            gaps.sort(key=lambda gap: gap.area)
            lost = np.array([any(gap.equals(other) for other in hopeless) for gap in gaps], bool)
            areas = np.array([gap.area for gap in gaps])
            may_stay = max(MAX_UNSEEN * self.area.area - float(areas[lost].sum()), MAX_UNSEEN / 10 * self.area.area)
            too_much = np.cumsum(np.where(lost, 0.0, areas)) > may_stay
            tried = [gaps[k] for k in np.flatnonzero(too_much & ~lost)[::-1]]
            if not tried or n == MAX_PASSES:
                break
            seen = list[Any]()
            for gap in tried:
                if (detour := self._detour(route, gap)) is None:
                    hopeless.append(gap)
                else:
                    goals.append(detour.goal)
                    seen.append(shapely.LineString(route.insert(detour)).buffer(self.width / 2, quad_segs=ARC))
            left = left.difference(union_of(seen))
        return goals, max(float(areas.sum()) / self.area.area - MAX_UNSEEN, 0.0)

    def _by_hole(self, gaps: list[Any]) -> list[Any]:
        rings = [ring for part in shapely.get_parts(self.space.inner) for ring in part.interiors]
        if not rings or not gaps:
            return gaps
        gap, ring = shapely.STRtree(rings).query_nearest(gaps, max_distance=self.width / 2, all_matches=False)
        others = np.setdiff1d(np.arange(len(gaps)), gap)
        return [union_of([gaps[n] for n in gap[ring == k]]) for k in np.unique(ring)] + [gaps[n] for n in others]

    def _detour(self, route: SensedPath, gap: Any) -> Detour | None:
        around = self._viewpoints(gap)
        lines = [] if around is not None else self._lines(gap)
        if around is None and not lines:
            around = shapely.Point(shapely.get_coordinates(shapely.shortest_line(self.space.inner, gap))[0])
            if gap.difference(around.buffer(self.width / 2)).area > (1 - MIN_SHARE_SEEN) * gap.area:
                return None
        legs = self._near_legs(route, shapely.get_coordinates(gap.centroid)[0])
        straight = self._quickest(route, legs, around, lines, round_corners=False)
        return straight or self._quickest(route, legs, around, lines, round_corners=True)

    def _quickest(
        self, route: SensedPath, legs: list[int], around: Any | None, lines: list[Points], round_corners: bool
    ) -> Detour | None:
        best, least = None, np.inf
        for n in legs:
            before, after = route.places[max(n - 1, 0) : n + 1], route.places[n + 1 : n + 3]
            now = self.cost.seconds(np.array([*before, *after]))
            for goal in self._goals(around, lines, before[-1:], after[:1]):
                if self._at_least(before, goal, after) - now >= least:
                    continue
                via = self._round_corners(before[-1:], goal, after[:1]) if round_corners else goal
                if via is None:
                    continue
                straight = np.array([*before[-1:], *via, *after[:1]])
                if not round_corners and not self.space.sees(straight[:-1], straight[1:]).diagonal().all():
                    continue
                seconds = self.cost.seconds(np.array([*before, *via, *after])) - now
                if seconds < least:
                    best, least = Detour(n, via, goal, seconds), seconds
        return best

    def _at_least(self, before: list[Vector], via: Points, after: list[Vector]) -> float:
        """Return a lower bound [s]."""
        legs = np.diff(np.array([*before, via[0]]), axis=0), np.diff(np.array([via[-1], *after]), axis=0)
        return self.cost.seconds(via) + float(np.linalg.norm(np.concatenate(legs), axis=1).sum()) / self.cost.speed

    def _round_corners(self, before: list[Vector], via: Points, after: list[Vector]) -> Points | None:
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

    def _viewpoints(self, gap: Any) -> Any | None:
        hull = shapely.get_coordinates(shapely.convex_hull(gap))[:-1]
        if len(hull) > 1 and np.ptp(hull, axis=0).max() > self.width:
            return None
        discs = shapely.buffer(shapely.points(hull), DISC_SHARE * self.width / 2, quad_segs=ARC)
        around = shapely.intersection(shapely.intersection_all(discs), self.space.inner)
        return None if around.is_empty else around

    def _near_legs(self, route: SensedPath, center: Vector) -> list[int]:
        """Return the legs near a place; -1 and the last index: before and after the path."""
        places = np.array(route.places)
        from_, to = places[:-1], places[1:]
        leg = to - from_
        share = np.clip(
            np.einsum("ij,ij->i", center - from_, leg) / np.maximum(np.einsum("ij,ij->i", leg, leg), 1e-12), 0, 1
        )
        away = np.linalg.norm(from_ + share[:, None] * leg - center, axis=1)
        away[np.array(route.is_on, bool)] = np.inf  # lines stay straight
        order = np.argsort(away, kind="stable")[:MAX_TRIED_LEGS]
        found = [int(n) for n in order if np.isfinite(away[n])]
        return [*found, -1, len(places) - 1]

    def _lines(self, gap: Any) -> list[Points]:
        """Return the line (k, 2) that sees most of a gap, and the edge of a hole if it takes most of that."""
        places = shapely.points(_densely(gap.boundary, self.width / 8))
        rings = shapely.get_rings(shapely.get_parts(self.space.inner))
        ring = rings[int(shapely.distance(rings, gap).argmin())]
        at = np.sort(shapely.line_locate_point(ring, places))
        widest = int(np.diff(at, append=at[0] + ring.length).argmax())
        start, end = float(at[(widest + 1) % len(at)]), float(at[widest])
        spans = [(start, end)] if start <= end else [(start, ring.length), (0.0, end)]
        edge = np.concatenate([shapely.get_coordinates(substring(ring, *span)) for span in spans])
        edge = edge[np.concatenate([[True], np.linalg.norm(np.diff(edge, axis=0), axis=1) > 1e-6])]
        if polyline_length(edge) > WHOLE_EDGE_SHARE * ring.length and ring.distance(gap) < self.width / 2:
            return [edge, shapely.get_coordinates(ring)]
        line = line_over(gap, self.space.inner, self.width)
        found = [each for each in (line, edge) if each is not None and len(each) > 1]
        left = [gap.difference(shapely.LineString(each).buffer(self.width / 2, quad_segs=ARC)).area for each in found]
        quick = [n for n, area in enumerate(left) if area <= min(left) + MIN_SHARE_SEEN * gap.area]
        return [found[quick[0]]] if quick and left[quick[0]] < (1 - MIN_SHARE_SEEN) * gap.area else []

    def _goals(
        self, around: Any | None, lines: list[Points], before: list[Vector], after: list[Vector]
    ) -> list[Points]:
        """Return the places (k, 2) that see a gap."""
        ends = np.array([*before, *after])
        if lines:
            begun = [_begun_near(line, ends) for line in lines]
            return [each for line in begun for each in (line, line[::-1])]
        leg = shapely.LineString(ends) if len(ends) > 1 else shapely.Point(ends[0])
        return [shapely.get_coordinates(shapely.shortest_line(around, leg))[:1]]


def _begun_near(line: Points, places: Points) -> Points:
    """Return a line (n, 2); a closed one begins nearest to `places`."""
    if (line[0] != line[-1]).any():
        return line
    away = np.linalg.norm(line[:-1, None] - places, axis=2).sum(axis=1)
    return np.roll(line[:-1], -int(away.argmin()), axis=0)[[*range(len(line) - 1), 0]]


def _densely(shape: Any, spacing: float) -> Points:
    return np.asarray(shapely.get_coordinates(shapely.segmentize(shape, spacing)))
