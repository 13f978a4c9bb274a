"""Compute the probability that pieces of a path come too near to obstacles.

A flight nearer than k to an upright body deviates by more than (lateral - k) *and* by more than (vertical - k). Only
the deviation towards its tangent plane counts. The least of these probabilities is an upper bound.
"""

from dataclasses import dataclass, fields, replace
from functools import cached_property

import numpy as np
import shapely
from numpy.typing import NDArray

from ipoa_mission.forecast.deviation.law import DeviationLaw
from ipoa_mission.forecast.timing.track import Pieces
from ipoa_mission.geometry import Vector
from ipoa_mission.world.airspace import Airspace
from ipoa_mission.world.obstacles.obstacle import distance_of

TYPICAL_CHANCE = 0.01  # at which vertical and lateral deviations are compared
Numbers = NDArray[np.intp]


@dataclass(frozen=True, eq=False)
class _Draws:
    """Each `pair` (n,), with the index of its `draw` (n,): an obstacle in a `window` of time (m,)."""

    pair: Numbers
    draw: Numbers
    window: Numbers

    def chance(self, chances: Vector, sides: float) -> float:
        """Return the probability of any pair; each obstacle counts by its likeliest, a window for at most `sides`."""
        if len(self.pair) == 0:
            return 0.0
        likeliest = np.zeros(len(self.window))
        np.maximum.at(likeliest, self.draw, chances[self.pair])
        greatest = np.zeros(int(self.window.max()) + 1)
        np.maximum.at(greatest, self.window, likeliest)
        summed = np.bincount(self.window, likeliest, len(greatest))
        return float(1.0 - np.prod(1.0 - np.minimum(np.minimum(summed, sides * greatest), 1.0)))


@dataclass(frozen=True, eq=False)
class ProximityRisks:
    """Pairs of a piece and an obstacle: indices, and lower bounds of their distance, (n,) each [m].

    `lateral`: to the outline. `above`: over the top or under the base. `widening` of the law. `sides` is 2 in a
    court or a corner of an obstacle, else 1.
    """

    law: DeviationLaw
    piece: Numbers
    obstacle: Numbers
    seconds: Vector
    lateral: Vector
    above: Vector
    is_over: NDArray[np.bool_]
    widening: Vector
    sides: Vector

    @cached_property
    def distance(self) -> Vector:
        return distance_of(self.lateral, self.above)

    @cached_property
    def facing(self) -> Vector:
        """Return the ratio of the deviation towards the obstacles to the lateral one."""
        side = self.law.lateral.distance(TYPICAL_CHANCE)
        down = self.law.down.distance(TYPICAL_CHANCE) / side
        up = self.law.up.distance(TYPICAL_CHANCE) / side
        lateral, above = np.maximum(self.lateral, 0.0), np.maximum(self.above, 0.0)
        length = np.hypot(lateral, above)
        wider = np.hypot(lateral, np.where(self.is_over, down, up) * above)
        return np.asarray(np.divide(wider, length, out=np.ones(len(lateral)), where=length > 0))

    def subset(self, chosen: NDArray[np.bool_]) -> "ProximityRisks":
        columns = (field.name for field in fields(self) if field.name != "law")
        return replace(self, **{name: getattr(self, name)[chosen] for name in columns})

    def likeliest_passings(self, clearance: float, chance: float) -> Numbers:
        """Return the passings that are likeliest nearer than `clearance` [m]; all others sum up to `chance`."""
        each = self._each(clearance)
        order = np.argsort(-each, kind="stable")
        passing = np.stack([self.seconds // self.law.decorrelation_s, self.obstacle])[:, order]
        _, first = np.unique(passing, axis=1, return_index=True)
        first.sort()
        rest = each[order[first]][::-1].cumsum()[::-1]
        return np.asarray(order[first[rest > chance]])

    def chance(self, clearance: float) -> float:
        """Return an upper bound of the probability that a flight is nearer than `clearance` [m]."""
        if len(self.piece) == 0:
            return 0.0
        chance = self._each(clearance)
        lateral = min(self._lateral.chance(chance, 2.0), self._side_of_a_flight(clearance))
        high = min(self._high.chance(chance, 1.0), self._height_of_a_flight(clearance))
        return 1.0 - (1.0 - lateral) * (1.0 - high)

    def likeliest(self, clearance: float) -> tuple[int, int]:
        pair = int(np.argmax(self._each(clearance)))
        return int(self.piece[pair]), int(self.obstacle[pair])

    @cached_property
    def by_height(self) -> NDArray[np.bool_]:
        laws = (self.law.lateral, self.law.down, self.law.up)
        clearance = self.distance - max(quantiles.distance(TYPICAL_CHANCE) for quantiles in laws)
        return np.asarray(self._vertical(clearance) < self._sideways(clearance))

    def _each(self, clearance: float) -> Vector:
        return np.minimum(self._sideways(clearance), self._vertical(clearance))

    def _sideways(self, clearance: Vector | float) -> Vector:
        lateral = self.law.lateral.chance((self.lateral - clearance) / self.widening)
        towards = self.law.lateral.chance((self.distance - clearance) / (self.widening * self.facing))
        return np.minimum(self.sides * np.minimum(lateral, towards), 1.0)

    def _vertical(self, clearance: Vector | float) -> Vector:
        spare = self.above - clearance
        return np.where(self.is_over, self.law.down.chance(spare), self.law.up.chance(spare))

    def _height_of_a_flight(self, clearance: float) -> float:
        spare = self.above - clearance
        low = self.law.lowest.chance(spare[self.by_height & self.is_over]).max(initial=0.0)
        high = self.law.highest.chance(spare[self.by_height & ~self.is_over]).max(initial=0.0)
        return float(min(low + high, 1.0))

    def _side_of_a_flight(self, clearance: float) -> float:
        if self.law.farthest is None:
            return 1.0
        spare = np.maximum(self.lateral - clearance, (self.distance - clearance) / self.facing) / self.widening
        return float(min(2.0 * self.law.farthest.chance(spare[~self.by_height]).max(initial=0.0), 1.0))

    @cached_property
    def _lateral(self) -> _Draws:
        return self._draws(~self.by_height, self.law.decorrelation_s)

    @cached_property
    def _high(self) -> _Draws:
        return self._draws(self.by_height, self.law.height_decorrelation_s)

    def _draws(self, chosen: NDArray[np.bool_], window_s: float) -> _Draws:
        during = self.seconds[chosen] // window_s
        during = (during - during.min(initial=np.inf)).astype(np.intp)
        count = int(self.obstacle.max()) + 1
        numbers, likeliest = np.unique(during * count + self.obstacle[chosen], return_inverse=True)
        return _Draws(np.flatnonzero(chosen), likeliest, numbers // count)

    def clearance_at(self, chance: float) -> float:
        """Return the clearance [m] that a flight falls short of with this chance."""
        if len(self.piece) == 0:
            return float("inf")
        high = float(self.distance.min())
        low = high - 1.0
        while self.chance(low) > chance:
            low -= high - low
        while high - low > 1e-3:  # [m]
            middle = (low + high) / 2
            low, high = (middle, high) if self.chance(middle) <= chance else (low, middle)
        return low


def proximity_risks(flown: Pieces, airspace: Airspace, law: DeviationLaw, clearance: float) -> ProximityRisks:
    a, b = flown.points[:-1], flown.points[1:]
    widening = law.widening(flown.lateral_accel)
    rare = 1e-5  # the chance of obstacles that are ignored
    reach = max(clearance, 0.0) + widening * law.lateral.distance(rare) + flown.excess[:, 0]
    near_pieces, near_obstacles = airspace.beside(shapely.linestrings(np.stack([a[:, :2], b[:, :2]], axis=1)), reach)
    pairs = [np.zeros((6, 0))]  # piece, obstacle, lateral, above, below, sides
    order = np.argsort(near_obstacles, kind="stable")
    numbers, first = np.unique(near_obstacles[order], return_index=True)
    for number, pieces in zip(numbers.tolist(), np.split(near_pieces[order], first[1:]), strict=False):
        for passing in airspace.obstacles[number].passings(a[pieces], b[pieces]):  # one for each part of a body
            pairs.append(np.array([pieces, np.full(len(pieces), number), *passing]))
    lateral, above, below, sides = np.hstack(pairs)[2:]
    piece, obstacle = np.hstack(pairs)[:2].astype(np.intp)
    over = above >= below
    side, down, up = flown.excess[piece].T
    nearer = np.maximum(above, below) - np.where(over, down, up)
    seconds = flown.times[piece]
    return ProximityRisks(law, piece, obstacle, seconds, lateral - side, nearer, over, widening[piece], sides)
