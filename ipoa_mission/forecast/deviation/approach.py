"""How near the pieces of a course come to each obstacle, and with what chance a flight is nearer still.

A place that is moved sideways by s and vertically by h keeps from an upright body at least the distance that is left
when s is taken off the level and h off the vertical one. So to come nearer than k a flight must leave the path by more
than (level - k) *and* by more than (vertical - k). A body also lies behind the plane that touches it where it is
nearest, so that only what leads towards it counts. The least of these chances bounds it.
"""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import shapely
from numpy.typing import NDArray

from ipoa_mission.forecast.deviation.law import DeviationLaw
from ipoa_mission.forecast.deviation.pieces import Pieces
from ipoa_mission.geometry import Vector
from ipoa_mission.world.airspace import Airspace

RARE_CHANCE = 1e-5  # what is so far away that it is reached with less than this chance is not looked at
USUAL_CHANCE = 0.01  # the chance at which heights are compared with what is level
RESOLUTION = 1e-3  # to which a clearance is found [m]
Numbers = NDArray[np.intp]


@dataclass(frozen=True, eq=False)
class _Draws:
    """Pairs by the stretches of time that know nothing of each other.

    `taken` (n,) are the pairs, `one` (n,) numbers what is one obstacle in one stretch, `stretch` (m,) is which one.
    """

    taken: Numbers
    one: Numbers
    stretch: Numbers

    def chance(self, chances: Vector, sides: float) -> float:
        """The chance that any of the pairs comes about, of the chances of all pairs.

        In one stretch a vehicle is beside its path to one side, of so many `sides` at most, and every obstacle counts
        by the pair that is the likeliest.
        """
        if len(self.taken) == 0:
            return 0.0
        likeliest = np.zeros(len(self.stretch))
        np.maximum.at(likeliest, self.one, chances[self.taken])
        greatest = np.zeros(int(self.stretch.max()) + 1)
        np.maximum.at(greatest, self.stretch, likeliest)
        summed = np.bincount(self.stretch, likeliest, len(greatest))
        return float(1.0 - np.prod(1.0 - np.minimum(np.minimum(summed, sides * greatest), 1.0)))


@dataclass(frozen=True, eq=False)
class Approaches:
    """Pairs of a piece and an obstacle: numbers, and distances that the piece nowhere falls short of, (n,) each [m].

    `aside` is to its outline, `above` over its top or under its base, whichever is more. `stretch` widens the law for
    the piece; in a court or a corner of an obstacle it has two `sides` to be hit on.
    """

    law: DeviationLaw
    piece: Numbers
    obstacle: Numbers
    seconds: Vector
    aside: Vector
    above: Vector
    is_over: NDArray[np.bool_]
    stretch: Vector
    sides: Vector

    @cached_property
    def distance(self) -> Vector:
        """What the pieces at least are from the obstacles [m]; negative inside."""
        outside = np.hypot(np.maximum(self.aside, 0.0), np.maximum(self.above, 0.0))
        return np.asarray(outside + np.minimum(np.maximum(self.aside, self.above), 0.0))

    @cached_property
    def facing(self) -> Vector:
        """How much wider than to the side the tube is towards the obstacles."""
        return _facing(self.law, self.aside, self.above, self.is_over)

    def of(self, taken: NDArray[np.bool_]) -> "Approaches":
        """Some of the pairs (n,)."""
        columns = ("piece", "obstacle", "seconds", "aside", "above", "is_over", "stretch", "sides")
        return replace(self, **{name: getattr(self, name)[taken] for name in columns})

    def chance(self, kept: float) -> float:
        """The chance at most that a flight somewhere comes nearer than `kept` [m]."""
        if len(self.piece) == 0:
            return 0.0
        chance = self._each(kept)
        beside = min(self._beside.chance(chance, 2.0), self._side_of_a_flight(kept))
        high = min(self._high.chance(chance, 1.0), self._height_of_a_flight(kept))
        return 1.0 - (1.0 - beside) * (1.0 - high)

    def likeliest(self, kept: float) -> tuple[int, int]:
        """The piece and the obstacle that are the likeliest to be nearer to each other than `kept` [m]."""
        pair = int(np.argmax(self._each(kept)))
        return int(self.piece[pair]), int(self.obstacle[pair])

    @cached_property
    def by_height(self) -> NDArray[np.bool_]:
        """The pairs that heights keep apart rather than what is level, (n,)."""
        spreads = (self.law.level, self.law.down, self.law.up)
        kept = self.distance - max(spread.distance(USUAL_CHANCE) for spread in spreads)
        return np.asarray(self._vertical(kept) < self._sideways(kept))

    def _each(self, kept: float) -> Vector:
        """The chance of each pair at its moment, (n,)."""
        return np.minimum(self._sideways(kept), self._vertical(kept))

    def _sideways(self, kept: Vector | float) -> Vector:
        level = self.law.level.chance((self.aside - kept) / self.stretch)
        towards = self.law.level.chance((self.distance - kept) / (self.stretch * self.facing))
        return np.minimum(self.sides * np.minimum(level, towards), 1.0)

    def _vertical(self, kept: Vector | float) -> Vector:
        room = self.above - kept
        return np.where(self.is_over, self.law.down.chance(room), self.law.up.chance(room))

    def _height_of_a_flight(self, kept: float) -> float:
        """The chance that a height is anywhere so wrong in a whole flight."""
        room = self.above - kept
        low = self.law.lowest.chance(room[self.by_height & self.is_over]).max(initial=0.0)
        high = self.law.highest.chance(room[self.by_height & ~self.is_over]).max(initial=0.0)
        return float(min(low + high, 1.0))

    def _side_of_a_flight(self, kept: float) -> float:
        """The chance that a whole flight is anywhere so far beside its path, to one of two sides."""
        if self.law.farthest is None:
            return 1.0
        room = np.maximum(self.aside - kept, (self.distance - kept) / self.facing) / self.stretch
        return float(min(2.0 * self.law.farthest.chance(room[~self.by_height]).max(initial=0.0), 1.0))

    @cached_property
    def _beside(self) -> "_Draws":
        return self._draws(~self.by_height, self.law.memory)

    @cached_property
    def _high(self) -> "_Draws":
        return self._draws(self.by_height, self.law.height_memory)

    def _draws(self, taken: NDArray[np.bool_], memory: float) -> "_Draws":
        during = self.seconds[taken] // memory
        during = (during - during.min(initial=np.inf)).astype(np.intp)
        count = int(self.obstacle.max()) + 1
        numbers, likeliest = np.unique(during * count + self.obstacle[taken], return_inverse=True)
        return _Draws(np.flatnonzero(taken), likeliest, numbers // count)

    def kept(self, chance: float) -> float:
        """The clearance that a flight falls short of with at most this chance [m]; infinite if nothing is near."""
        if len(self.piece) == 0:
            return float("inf")
        high = float(self.distance.min())
        low = high - 1.0
        while self.chance(low) > chance:
            low -= high - low
        while high - low > RESOLUTION:
            middle = (low + high) / 2
            low, high = (middle, high) if self.chance(middle) <= chance else (low, middle)
        return low


def approaches(flown: Pieces, airspace: Airspace, law: DeviationLaw, kept: float) -> Approaches:
    """Every pair of a piece and an obstacle that may be nearer than `kept` [m]."""
    a, b = flown.points[:-1], flown.points[1:]
    stretch = law.stretch(flown.across)
    reach = max(kept, 0.0) + stretch * law.level.distance(RARE_CHANCE)
    lines = shapely.linestrings(np.stack([a[:, :2], b[:, :2]], axis=1))
    piece, obstacle = airspace.beside(lines, reach)
    order = np.argsort(obstacle, kind="stable")
    piece, obstacle = piece[order], obstacle[order]
    passings = [airspace.obstacles[i].passing(a[on], b[on]) for i, on in _by_obstacle(piece, obstacle)]
    aside, above, below, sides = map(np.concatenate, zip(*passings, strict=True)) if passings else np.zeros((4, 0))
    over = above >= below
    return Approaches(
        law, piece, obstacle, flown.times[piece], aside, np.maximum(above, below), over, stretch[piece], sides
    )


def _by_obstacle(piece: Numbers, obstacle: Numbers) -> list[tuple[int, Numbers]]:
    """Obstacle by obstacle the pieces that belong to it; both are sorted by obstacles."""
    numbers, first = np.unique(obstacle, return_index=True)
    return list(zip(numbers.tolist(), np.split(piece, first[1:]), strict=True)) if len(numbers) else []


def _facing(law: DeviationLaw, aside: Vector, above: Vector, is_over: NDArray[np.bool_]) -> Vector:
    down, up = (spread.distance(USUAL_CHANCE) / law.level.distance(USUAL_CHANCE) for spread in (law.down, law.up))
    aside, above = np.maximum(aside, 0.0), np.maximum(above, 0.0)
    length = np.hypot(aside, above)
    wider = np.hypot(aside, np.where(is_over, down, up) * above)
    return np.divide(wider, length, out=np.ones(len(aside)), where=length > 0)
