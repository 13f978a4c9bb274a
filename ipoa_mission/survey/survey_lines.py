"""Lay parallel lines, and close the gaps between by detours."""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
import shapely
from shapely.ops import substring

from ipoa_mission.geometry import Plane, Points, Vector, polyline_length, union_of
from ipoa_mission.survey.free import FreeSpace
from ipoa_mission.survey.times import LegTimes
from ipoa_mission.survey.tour import Tour

ARC = 8  # segments of a quarter circle
MAX_UNSEEN = 7e-4  # of the area
MIN_SHARE_SEEN = 0.1  # of a gap, by a detour


@dataclass(frozen=True)
class LineAxes:
    """Unit vectors along the lines and across, on their left (2,)."""

    along: Vector
    across: Vector

    @classmethod
    def of(cls, degrees: float) -> "LineAxes":
        east = math.sin(math.radians(degrees))
        north = math.cos(math.radians(degrees))
        return cls(np.array([east, north]), np.array([-north, east]))

    def turned(self, places: Plane) -> Plane:
        return np.column_stack([places @ self.along, places @ self.across])

    def back(self, places: Plane) -> Plane:
        return np.asarray(places[:, :1] * self.along + places[:, 1:] * self.across)


def line_positions(area: Any, grid: LineAxes, spacing: float, shift: float = 0.0) -> Vector:
    """Return the lines' positions across, evenly; `shift` from -1 to 1 moves them by this share of the slack."""
    across = shapely.get_coordinates(area) @ grid.across
    low = float(across.min())
    high = float(across.max())
    count = max(math.ceil((high - low) / spacing - 1e-6), 1)
    if shift == 0.0:
        return np.asarray(low + (high - low) / count * (np.arange(count) + 0.5))
    middle = (low + high) / 2 + shift * (count * spacing - (high - low)) / 2
    return np.asarray(middle + spacing * (np.arange(count) - (count - 1) / 2))


def cut_lines(edges: Points, grid: LineAxes, positions: Vector) -> Points:
    """Return the pieces (n, 2, 2) between the edges (m, 4) of polygons."""
    begins = grid.turned(edges[:, :2])
    ends = grid.turned(edges[:, 2:])
    crosses = (begins[None, :, 1] <= positions[:, None]) != (ends[None, :, 1] <= positions[:, None])
    line, edge = np.nonzero(crosses)
    share = (positions[line] - begins[edge, 1]) / (ends[edge, 1] - begins[edge, 1])
    along = begins[edge, 0] + share * (ends[edge, 0] - begins[edge, 0])
    order = np.lexsort([along, line])
    pairs = np.column_stack([along[order], positions[line[order]]]).reshape(-1, 2, 2)
    return grid.back(pairs.reshape(-1, 2)).reshape(-1, 2, 2)


def area_seen_from(lines: Any, width: float) -> Any:
    """Return the area seen from lines (n, 2, 2), without seams."""
    seam_width = 1e-4  # [m]
    return union_along(shapely.linestrings(lines), width / 2 + seam_width, ARC)


def union_along(drawn: Any, away: float, arc: int) -> Any:
    """Return the area within `away` of lines (n,); `arc` segments a quarter circle."""
    return union_of(shapely.buffer(drawn, away, quad_segs=arc))


def polygons_of(shape: Any) -> list[Any]:
    return [part for part in shapely.get_parts(shape) if part.geom_type == "Polygon" and part.area > 0.0]


def line_over(gap: Any, inner: Any, width: float) -> Plane | None:
    """Return the line (2, 2) that sees most of a gap, or None if a place sees as much."""
    box = shapely.get_coordinates(shapely.oriented_envelope(gap))
    if len(box) < 4:
        return None
    sides = np.diff(box[:3], axis=0)
    lengths = np.linalg.norm(sides, axis=1)
    along = sides[int(lengths.argmax())] / lengths.max()
    grid = LineAxes(along, np.array([-along[1], along[0]]))
    places = grid.turned(shapely.get_coordinates(shapely.segmentize(gap.boundary, width / 4)))
    west, south = places.min(axis=0)
    east, north = places.max(axis=0)
    low, high = sorted((north - width / 2, south + width / 2))
    best = None
    most = 0
    for height in np.linspace(low, high, num=5):
        full_line = shapely.LineString(grid.back(np.array([[west, height], [east, height]])))
        for part in shapely.get_parts(shapely.intersection(full_line, inner)):
            if part.geom_type != "LineString" or part.length <= 0.0:
                continue
            ends = np.sort(grid.turned(shapely.get_coordinates(part))[[0, -1], 0])
            away = places[:, 1] - height
            reach = np.sqrt(np.maximum((width / 2) ** 2 - away**2, 0.0))
            sees = (np.abs(away) <= width / 2) & (places[:, 0] >= ends[0] - reach) & (places[:, 0] <= ends[1] + reach)
            count = int(sees.sum())
            if count > most:
                first = (places[sees, 0] + reach[sees]).min()
                last = (places[sees, 0] - reach[sees]).max()
                ends = np.clip([min(first, last), max(first, last)], *ends)
                best = grid.back(np.column_stack([ends, [height, height]]))
                most = count
    return best


@dataclass(frozen=True, eq=False)
class Detour:
    """A detour from a leg of a tour by `via`, with `goal`."""

    leg: int
    via: Plane
    goal: Plane


@dataclass(frozen=True, eq=False)
class GapCloser:
    area: Any
    width: float
    space: FreeSpace
    cost: LegTimes

    def close(self, route: Tour) -> tuple[Tour, list[Plane], float]:
        """Return the route with detours, their lines (k, 2) or places (1, 2), and the unseen share beyond limits."""
        hopeless = list[Any]()
        goals = list[Plane]()
        left = self.area.difference(area_seen_from(route.lines, self.width))
        max_passes = 8
        for n in range(max_passes + 1):
            gaps = sorted(polygons_of(left), key=lambda gap: gap.area)
            lost = np.array([any(gap.equals(other) for other in hopeless) for gap in gaps], bool)
            areas = np.array([gap.area for gap in gaps])
            may_stay = max(MAX_UNSEEN * self.area.area - float(areas[lost].sum()), MAX_UNSEEN / 10 * self.area.area)
            too_much = np.cumsum(np.where(lost, 0.0, areas)) > may_stay
            tried = [gaps[k] for k in np.flatnonzero(too_much & ~lost)[::-1]]
            if not tried or n == max_passes:
                break
            seen = list[Any]()
            for gap in tried:
                detour = self._detour(route, gap)
                if detour is None:
                    hopeless.append(gap)
                else:
                    goals.append(detour.goal)
                    route, line = route.detour(detour.leg, detour.via)
                    seen.append(shapely.LineString(line).buffer(self.width / 2, quad_segs=ARC))
            left = left.difference(union_of(seen))
        return route, goals, max(float(areas.sum()) / self.area.area - MAX_UNSEEN, 0.0)

    def _detour(self, route: Tour, gap: Any) -> Detour | None:
        around = self._viewpoints(gap)
        lines = [] if around is not None else self._lines(gap)
        if around is None and not lines:
            around = shapely.Point(shapely.get_coordinates(shapely.shortest_line(self.space.inner, gap))[0])
            if gap.difference(around.buffer(self.width / 2)).area > (1 - MIN_SHARE_SEEN) * gap.area:
                return None
        legs = self._near_legs(route, shapely.get_coordinates(gap.centroid)[0])
        return self._quickest(route, legs, around, lines)

    def _quickest(self, route: Tour, legs: list[int], around: Any | None, lines: list[Plane]) -> Detour | None:
        best = None
        least = np.inf
        for n in legs:
            before = route.places[max(n - 1, 0) : n + 1]
            after = route.places[n + 1 : n + 3]
            now = self.cost.seconds(np.array([*before, *after]))
            for goal in self._goals(around, lines, before[-1:], after[:1]):
                if self._at_least(before, goal, after) - now >= least:
                    continue
                via = self._round_corners(before[-1:], goal, after[:1])
                if via is None:
                    continue
                seconds = self.cost.seconds(np.array([*before, *via, *after])) - now
                if seconds < least:
                    best = Detour(n, via, goal)
                    least = seconds
        return best

    def _at_least(self, before: Plane, via: Plane, after: Plane) -> float:
        legs = np.diff(np.array([*before, via[0]]), axis=0), np.diff(np.array([via[-1], *after]), axis=0)
        return self.cost.seconds(via) + float(np.linalg.norm(np.concatenate(legs), axis=1).sum()) / self.cost.speed

    def _round_corners(self, before: Plane, via: Plane, after: Plane) -> Plane | None:
        places = [via]
        if len(before):
            way_in = self.space.way(before[0], via[0], self.cost)
            if way_in is None:
                return None
            places.insert(0, way_in[1:-1])
        if len(after):
            way_out = self.space.way(via[-1], after[0], self.cost)
            if way_out is None:
                return None
            places.append(way_out[1:-1])
        return np.concatenate(places)

    def _viewpoints(self, gap: Any) -> Any | None:
        hull = shapely.get_coordinates(shapely.convex_hull(gap))[:-1]
        if len(hull) > 1 and np.ptp(hull, axis=0).max() > self.width:
            return None
        radius = 0.999 * self.width / 2  # discs are polygons
        discs = shapely.buffer(shapely.points(hull), radius, quad_segs=ARC)
        around = shapely.intersection(shapely.intersection_all(discs), self.space.inner)
        return None if around.is_empty else around

    def _near_legs(self, route: Tour, center: Vector) -> list[int]:
        """Return the legs near a place; -1 and the last index: before and after the path."""
        begins = route.places[:-1]
        legs = route.places[1:] - begins
        squares = np.maximum(np.einsum("ij,ij->i", legs, legs), 1e-12)
        share = np.clip(np.einsum("ij,ij->i", center - begins, legs) / squares, 0, 1)
        away = np.linalg.norm(begins + share[:, None] * legs - center, axis=1)
        away[route.is_on] = np.inf  # lines stay straight
        max_legs = 6
        order = np.argsort(away, kind="stable")[:max_legs]
        return [*(int(n) for n in order if np.isfinite(away[n])), -1, len(route.is_on)]

    def _lines(self, gap: Any) -> list[Plane]:
        """Return the line that sees most of a gap, and the edge of a hole if it takes most of the line."""
        places = shapely.points(shapely.get_coordinates(shapely.segmentize(gap.boundary, self.width / 8)))
        rings = shapely.get_rings(shapely.get_parts(self.space.inner))
        ring = rings[int(shapely.distance(rings, gap).argmin())]
        distances = np.sort(shapely.line_locate_point(ring, places))
        widest = int(np.diff(distances, append=distances[0] + ring.length).argmax())
        start = float(distances[(widest + 1) % len(distances)])
        end = float(distances[widest])
        spans = [(start, end)] if start <= end else [(start, ring.length), (0.0, end)]
        edge = np.concatenate([shapely.get_coordinates(substring(ring, *span)) for span in spans])
        edge = edge[np.concatenate([[True], np.linalg.norm(np.diff(edge, axis=0), axis=1) > 1e-6])]
        is_most_of_ring = polyline_length(edge) > 0.6 * ring.length
        if is_most_of_ring and ring.distance(gap) < self.width / 2:
            return [edge, shapely.get_coordinates(ring)]
        line = line_over(gap, self.space.inner, self.width)
        lines = [each for each in (line, edge) if each is not None and len(each) > 1]
        left = [gap.difference(shapely.LineString(each).buffer(self.width / 2, quad_segs=ARC)).area for each in lines]
        quick = [n for n, area in enumerate(left) if area <= min(left) + MIN_SHARE_SEEN * gap.area]
        return [lines[quick[0]]] if quick and left[quick[0]] < (1 - MIN_SHARE_SEEN) * gap.area else []

    def _goals(self, around: Any | None, lines: list[Plane], before: Plane, after: Plane) -> list[Plane]:
        ends = np.concatenate([before, after])
        if lines:
            begun = [_begun_near(line, ends) for line in lines]
            return [each for line in begun for each in (line, line[::-1])]
        leg = shapely.LineString(ends) if len(ends) > 1 else shapely.Point(ends[0])
        return [shapely.get_coordinates(shapely.shortest_line(around, leg))[:1]]


def _begun_near(line: Plane, places: Plane) -> Plane:
    """Return a line; a closed one begins nearest to `places`."""
    if (line[0] != line[-1]).any():
        return line
    away = np.linalg.norm(line[:-1, None] - places, axis=2).sum(axis=1)
    return np.roll(line[:-1], -int(away.argmin()), axis=0)[[*range(len(line) - 1), 0]]
