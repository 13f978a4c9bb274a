"""Find the quickest transits in polygons, over the visibility graph of their corners."""

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import shapely

from ipoa_mission.geometry import Matrix, Plane, Vector, union_of
from ipoa_mission.survey._kernels import DIRECT, NO_WAY, NONE, straight_ways, ways_between
from ipoa_mission.survey.survey_area import INSET
from ipoa_mission.survey.times import LegTimes, Ways

MAX_TURN = math.radians(60.0)


@dataclass(frozen=True, eq=False)
class FreeSpace:
    """Polygons to fly in, their part `INSET` from the edge, edges (m, 4), corners, and their `arms` (n, 4)."""

    shape: Any
    inner: Any
    edges: Matrix
    corners: Plane
    arms: Matrix

    @classmethod
    def of(cls, shape: Any) -> "FreeSpace":
        inner = shape.buffer(-INSET, join_style="mitre")
        edges = np.vstack([np.empty((0, 4)), *(np.column_stack([ring[:-1], ring[1:]]) for ring in _rings(shape))])
        bends = np.vstack([np.empty((0, 6)), *map(_bends, _rings(inner))])
        return cls(shape, inner, edges, *map(np.ascontiguousarray, (bends[:, :2], bends[:, 2:])))

    @cached_property
    def between(self) -> Ways:
        """Return the straight ways between corners."""
        ways = straight_ways(self.corners, self.arms, self.corners, self.arms, self.edges)
        ways = np.where(np.tri(len(ways), k=-1, dtype=bool), ways, ways.T)
        np.fill_diagonal(ways, NO_WAY)
        return listed(np.ascontiguousarray(ways))

    def way(self, start: Vector, end: Vector, cost: LegTimes) -> Plane | None:
        """Return the corners of the quickest way between places (2,), both included; None: no way leads there."""
        transits = Transits(np.array([start, start, end, end]), self, self, cost)
        return None if transits.times[0, 2] >= NO_WAY else transits.corners(0, 2)

    def transits(self, ends: Plane, cost: LegTimes) -> Any:
        ends = np.ascontiguousarray(ends)
        no_arms = np.zeros((len(ends), 4))
        near = listed(straight_ways(ends, no_arms, self.corners, self.arms, self.edges))
        bend_m = 1.0 * cost.speed
        return ways_between(cost.table, ends, self.corners, near, self.between, self.edges, bend_m)


class Transits:
    """The transits between line ends (2n, 2); `times` (2n, 2n) [s] with corners at both ends."""

    def __init__(self, ends: Plane, inside: FreeSpace, outside: FreeSpace, cost: LegTimes) -> None:
        self.ends = ends
        self._spaces = (inside, outside)
        self._searches = [inside.transits(ends, cost)]
        self.times = self._searches[0][0]
        each = np.arange(len(ends))
        self._is_outside = self.times >= NO_WAY
        self._is_outside[each, each] = self._is_outside[each, each ^ 1] = False
        if self._is_outside.any():
            self._searches.append(outside.transits(ends, cost))
            outside_s = 60.0  # discourages leaving the area
            times = np.minimum(self._searches[1][0] + outside_s, NO_WAY)
            self.times = np.where(self._is_outside, times, self.times)

    def corners(self, i: int, j: int) -> Plane:
        """Return the corners from end i to end j, both included."""
        number = int(self._is_outside[i, j])
        _, last, previous = self._searches[number]
        corners = self._spaces[number].corners
        passed = [self.ends[j]]
        corner = int(last[i, j])
        assert corner != NONE, "the search chose an existing transit"
        while corner != DIRECT:
            passed.append(corners[corner])
            corner = int(previous[i, corner])
        return np.array([self.ends[i], *passed[::-1]])


def listed(lengths: Matrix) -> Ways:
    rows, columns = np.nonzero(lengths < NO_WAY)
    return Ways(lengths, np.searchsorted(rows, np.arange(len(lengths) + 1)), np.ascontiguousarray(columns))


def _rings(shape: Any) -> list[Plane]:
    oriented = shapely.orient_polygons(shape)
    return [shapely.get_coordinates(ring) for ring in shapely.get_rings(shapely.get_parts(oriented))]


def _bends(ring: Plane) -> Matrix:
    """Return the right turns of a ring, with the directions to their neighbors (0 at sharp corners), (k, 6)."""
    corners = ring[:-1]
    arms_to_neighbors = (np.roll(corners, step, axis=0) - corners for step in (1, -1))
    back, on = (arm / np.linalg.norm(arm, axis=1, keepdims=True) for arm in arms_to_neighbors)
    turns = np.arctan2(on[:, 0] * back[:, 1] - on[:, 1] * back[:, 0], -(on * back).sum(axis=1))
    sharp_angle = np.radians(40.0)
    arms = np.where(turns[:, None] > -sharp_angle, np.column_stack([back, on]), 0.0)
    return np.asarray(np.column_stack([corners, arms])[turns < 0.0])


def widen(shape: Any, most: float) -> Any:
    """Return polygons around `shape` with fewer corners, wider by at most `most` [m]."""
    return _redraw(shape, most, order=1)


def narrow(shape: Any, most: float) -> Any:
    """Return polygons within `shape` with fewer corners, narrower by at most `most` [m]."""
    return _redraw(shape, most, order=-1)


def _redraw(shape: Any, most: float, order: int) -> Any:
    """Redraw rings, interior on the left in this `order` of corners; keep a part whose new rings would cross."""
    parts = []
    for part in shapely.get_parts(shapely.orient_polygons(shape)):
        rings = (shapely.get_coordinates(ring)[:-1] for ring in shapely.get_rings(part))
        outer, *inner = (_sharpen_bulges(_fill_dents(ring[::order], most), most)[::order] for ring in rings)
        simple = shapely.Polygon(outer, inner)
        parts.append(simple if simple.is_valid else part)
    return union_of(parts)


def _turns(ring: Plane) -> Vector:
    """Return the turns of an open ring, left positive [rad]."""
    into = ring - np.roll(ring, 1, axis=0)
    out = np.roll(ring, -1, axis=0) - ring
    return np.asarray(np.arctan2(into[:, 0] * out[:, 1] - into[:, 1] * out[:, 0], (into * out).sum(axis=1)))


def _fill_dents(ring: Plane, most: float) -> Plane:
    """Replace runs of small right turns by a straight edge."""
    turns = _turns(ring)
    if (turns >= 0.0).all():
        return ring
    first = int(turns.argmax())
    ring = np.roll(ring, -first, axis=0)
    turns = np.roll(turns, -first)
    corners = [0]
    n = 0
    count = len(ring)
    while n < count:
        end = n + 1
        turned = 0.0
        while end < count and turns[end] < 0.0 and turned - turns[end] <= MAX_TURN:
            begin = ring[n]
            leg = ring[(end + 1) % count] - ring[n]
            away = (ring[n + 1 : end + 1] - begin) @ np.array([-leg[1], leg[0]]) / max(math.hypot(*leg), 1e-12)
            if away.max() > most:
                break
            turned -= turns[end]
            end += 1
        corners.append(end)
        n = end
    return np.asarray(ring[corners[:-1]])


def _sharpen_bulges(ring: Plane, most: float) -> Plane:
    turns = _turns(ring)
    first = int(turns.argmax()) if turns.max() > MAX_TURN else int(turns.argmin())
    ring = np.roll(ring, -first, axis=0)
    turns = np.roll(turns, -first)
    corners = [ring[0]]
    n = 1
    count = len(ring)
    while n < count:
        corner = ring[n]
        turned = turns[n]
        end = n + 1
        into = ring[n] - ring[n - 1]
        while end < count and min(turns[end], turns[end - 1]) > 0.0 and turned + turns[end] <= MAX_TURN:
            out = ring[(end + 1) % count] - ring[end]
            apart = ring[end] - ring[n - 1]
            share = (apart[0] * out[1] - apart[1] * out[0]) / (into[0] * out[1] - into[1] * out[0])
            meets = ring[n - 1] + share * into
            if shapely.LineString(ring[n : end + 1]).distance(shapely.Point(meets)) > most:
                break
            corner = meets
            turned += turns[end]
            end += 1
        corners.append(corner)
        n = end
    return np.array(corners)
