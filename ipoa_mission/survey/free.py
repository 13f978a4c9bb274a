"""Find the quickest transits in polygons, over the visibility graph of their corners."""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import shapely
from numpy.typing import NDArray

from ipoa_mission.geometry import Points
from ipoa_mission.survey._kernels import DIRECT, NO_WAY, NONE, sights, straight_ways, ways_between
from ipoa_mission.survey.survey_area import INSET
from ipoa_mission.survey.times import LegTimes


@dataclass(frozen=True, eq=False)
class FreeSpace:
    """Polygons to fly in, their part `INSET` from the edge, edges (m, 4), corners (n, 2), and their `arms` (n, 4)."""

    shape: Any
    inner: Any
    edges: Points
    corners: Points
    arms: Points

    @classmethod
    def of(cls, shape: Any) -> "FreeSpace":
        inner = shape.buffer(-INSET, join_style="mitre")
        edges = [np.column_stack([ring[:-1], ring[1:]]) for ring in _rings(shape)]
        bends = np.concatenate([np.empty((0, 6)), *map(_bends, _rings(inner))])
        return cls(
            shape,
            inner,
            np.ascontiguousarray(np.concatenate([np.empty((0, 4)), *edges])),
            np.ascontiguousarray(bends[:, :2]),
            np.ascontiguousarray(bends[:, 2:]),
        )

    @cached_property
    def between(self) -> Points:
        return np.asarray(straight_ways(self.corners, self.arms, self.edges))

    def sees(self, places: Points, others: Points) -> NDArray[np.bool_]:
        """Return which `others` (m, 2) are in straight reach of each place (n, 2), (n, m)."""
        return np.asarray(sights(np.ascontiguousarray(places), np.ascontiguousarray(others), self.edges))

    def transits(self, ends: Points, cost: LegTimes) -> Any:
        bend_m = 1.0 * cost.speed
        return ways_between(cost.clock, ends, self.corners, self.arms, self.between, self.edges, bend_m)


class Transits:
    """The transits between line ends (2n, 2); `times` (2n, 2n) [s] with corners at both ends."""

    def __init__(self, ends: Points, inside: FreeSpace, outside: FreeSpace, cost: LegTimes) -> None:
        self.ends, self._spaces = ends, (inside, outside)
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

    def corners(self, i: int, j: int) -> Points:
        """Return the corners (k, 2) from end i to end j, both included."""
        which = int(self._is_outside[i, j])
        _, last, previous = self._searches[which]
        corners, passed, corner = self._spaces[which].corners, [self.ends[j]], int(last[i, j])
        assert corner != NONE, "the search chose an existing transit"
        while corner != DIRECT:
            passed.append(corners[corner])
            corner = int(previous[i, corner])
        return np.array([self.ends[i], *passed[::-1]])


def _rings(shape: Any) -> list[Points]:
    """Return all rings, closed, interior on the left."""
    oriented = shapely.orient_polygons(shape)
    return [shapely.get_coordinates(ring) for ring in shapely.get_rings(shapely.get_parts(oriented))]


def _bends(ring: Points) -> Points:
    """Return the right turns of a ring, with the directions to their neighbors (0 at sharp corners), (k, 6)."""
    corners = ring[:-1]
    back, on = np.roll(corners, 1, axis=0) - corners, np.roll(corners, -1, axis=0) - corners
    back, on = (arm / np.linalg.norm(arm, axis=1, keepdims=True) for arm in (back, on))
    turns = np.arctan2(on[:, 0] * back[:, 1] - on[:, 1] * back[:, 0], -(on * back).sum(axis=1))
    sharp_angle = np.radians(40.0)
    arms = np.where(turns[:, None] > -sharp_angle, np.column_stack([back, on]), 0.0)
    return np.asarray(np.column_stack([corners, arms])[turns < 0.0])
