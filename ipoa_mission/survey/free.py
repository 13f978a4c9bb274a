"""Where a survey may fly, and the shortest ways there between the ends of its lines."""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import shapely
from numpy.typing import NDArray

from ipoa_mission.geometry import Points
from ipoa_mission.survey._kernels import DIRECT, NO_WAY, NONE, sights, straight_ways, ways_between
from ipoa_mission.survey.times import LegTimes

INSET = 0.02  # lines and ways keep so far inside, more than a mission's whole 1e-7 degrees are off [m]
BEND_S = 1.0  # a bend of a way counts as so much, when the shortest is sought [s]
LEAVING_S = 60.0  # that a way leaves the area counts as so much: only to come to another part [s]


@dataclass(frozen=True, eq=False)
class FreeSpace:
    """Polygons that may be flown in: all, what of them is `INSET` from the edge, edges (m, 4), corners to go round."""

    shape: Any
    inner: Any
    edges: Points
    corners: Points

    @classmethod
    def of(cls, shape: Any) -> "FreeSpace":
        """That of polygons (shapely)."""
        inner = shape.buffer(-INSET, join_style="mitre")
        rings = _rings(shape)
        edges = [np.column_stack([ring[:-1], ring[1:]]) for ring in rings]
        corners = [_bends(ring) for ring in _rings(inner)]
        return cls(
            shape,
            inner,
            np.ascontiguousarray(np.concatenate([np.empty((0, 4)), *edges])),
            np.ascontiguousarray(np.concatenate([np.empty((0, 2)), *corners])),
        )

    @cached_property
    def between(self) -> Points:
        """How far it is straight from corner to corner (n, n) [m]."""
        return np.asarray(straight_ways(self.corners, self.edges))

    def sees(self, places: Points, others: Points) -> NDArray[np.bool_]:
        """Whether there is a straight way from each of the places (n, 2) to each of the others (m, 2), (n, m)."""
        return np.asarray(sights(np.ascontiguousarray(places), np.ascontiguousarray(others), self.edges))


class Ways:
    """The ways from each end of lines to each other's; line k has the ends 2k and 2k + 1 of `ends` (2n, 2).

    Attributes:
        times: how long they take, corners counted where they leave and join lines, (2n, 2n) [s].
    """

    def __init__(self, ends: Points, inside: FreeSpace, outside: FreeSpace, cost: LegTimes) -> None:
        self.ends, self._spaces, self._found = ends, (inside, outside), list[Any]()
        bend = BEND_S * cost.speed
        self._found.append(ways_between(cost.clock, ends, inside.corners, inside.between, inside.edges, bend))
        self.times = self._found[0][0]
        partner = np.arange(len(ends)) ^ 1
        lost = self.times >= NO_WAY
        lost[np.arange(len(ends)), np.arange(len(ends))] = lost[np.arange(len(ends)), partner] = False
        self._is_outside = lost
        if lost.any():
            found = ways_between(cost.clock, ends, outside.corners, outside.between, outside.edges, bend)
            self._found.append(found)
            self.times = np.where(lost, np.minimum(self._found[1][0] + LEAVING_S, NO_WAY), self.times)

    def way(self, i: int, j: int) -> Points:
        """The corners (k, 2) of the way from end i to end j, both with it."""
        which = int(self._is_outside[i, j])
        _, last, prev = self._found[which]
        corners, passed, c = self._spaces[which].corners, [self.ends[j]], int(last[i, j])
        assert c != NONE, "there is a way, as it was chosen"
        while c != DIRECT:
            passed.append(corners[c])
            c = int(prev[i, c])
        return np.array([self.ends[i], *passed[::-1]])


def _rings(shape: Any) -> list[Points]:
    """All rings of polygons, what is inside on their left, closed."""
    oriented = shapely.orient_polygons(shape)
    return [shapely.get_coordinates(ring) for ring in shapely.get_rings(shapely.get_parts(oriented))]


def _bends(ring: Points) -> Points:
    """The corners of a ring, what is inside on its left, that a shortest way may go round: it turns right there."""
    corners = ring[:-1]
    into, out = corners - np.roll(corners, 1, axis=0), np.roll(corners, -1, axis=0) - corners
    return np.asarray(corners[into[:, 0] * out[:, 1] - into[:, 1] * out[:, 0] < 0.0])
