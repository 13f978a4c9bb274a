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

from ipoa_mission.geometry import Vector
from ipoa_mission.tube.course import Course
from ipoa_mission.tube.law import PASS, Law
from ipoa_mission.world.airspace import Airspace

RARE_CHANCE = 1e-5  # what is so far away that it is reached with less than this chance is not looked at
USUAL_CHANCE = 0.01  # the chance at which heights are compared with what is level
RESOLUTION = 1e-3  # to which a clearance is found [m]
Numbers = NDArray[np.intp]


@dataclass(frozen=True, eq=False)
class Approaches:
    """Pairs of a piece and an obstacle: numbers, and distances that the piece nowhere falls short of, (n,) each [m].

    `aside` is to its outline, `above` over its top or under its base, whichever is more. `stretch` widens the law for
    the piece; in a court or a corner of an obstacle it has two `sides` to be hit on.
    """

    law: Law
    piece: Numbers
    obstacle: Numbers
    passing: Numbers
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
        columns = ("piece", "obstacle", "passing", "aside", "above", "is_over", "stretch", "sides")
        return replace(self, **{name: getattr(self, name)[taken] for name in columns})

    def chance(self, kept: float) -> float:
        """The chance at most that a flight somewhere comes nearer than `kept` [m]."""
        if len(self.piece) == 0:
            return 0.0
        total, vertical = self._chances(kept)
        return float(min(total.sum() + vertical.max(initial=0.0), 1.0))

    def likeliest(self, kept: float) -> tuple[int, int]:
        """The piece and the obstacle that are the likeliest to be nearer to each other than `kept` [m]."""
        pair = int(np.argmax(self._each(kept)[0]))
        return int(self.piece[pair]), int(self.obstacle[pair])

    def _each(self, kept: float) -> tuple[Vector, NDArray[np.bool_]]:
        """The chance of each pair, and whether it is that of a height."""
        level = self.law.level.chance((self.aside - kept) / self.stretch)
        towards = self.law.level.chance((self.distance - kept) / (self.stretch * self.facing))
        room = self.above - kept
        vertical = np.where(self.is_over, self.law.down.chance(room), self.law.up.chance(room))
        sideways = self.sides * np.minimum(level, towards)
        return np.minimum(sideways, vertical), vertical < sideways

    def _chances(self, kept: float) -> tuple[Vector, Vector]:
        """Of each pass, to one side and the other; and of heights, which are wrong in a whole flight."""
        chance, is_height = self._each(kept)
        sideways = np.where(is_height, 0.0, chance)
        count = int(self.obstacle.max()) + 1
        _, pairs = np.unique(self.passing * count + self.obstacle, return_inverse=True)
        least = np.zeros(int(pairs.max()) + 1)
        np.maximum.at(least, pairs, sideways)
        owner = np.zeros(len(least), dtype=np.intp)
        owner[pairs] = self.passing
        summed, greatest = np.zeros(int(owner.max()) + 1), np.zeros(int(owner.max()) + 1)
        np.add.at(summed, owner, least)
        np.maximum.at(greatest, owner, least)
        return np.minimum(summed, 2 * greatest), chance[is_height]

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


def approaches(course: Course, airspace: Airspace, law: Law, kept: float) -> Approaches:
    """Every pair of a piece and an obstacle that may be nearer than `kept` [m]."""
    a, b = course.points[:-1], course.points[1:]
    stretch = law.stretch(course.across)
    reach = max(kept, 0.0) + stretch * law.level.distance(RARE_CHANCE)
    lines = shapely.linestrings(np.stack([a[:, :2], b[:, :2]], axis=1))
    piece, obstacle = airspace.beside(lines, reach)
    order = np.argsort(obstacle, kind="stable")
    piece, obstacle = piece[order], obstacle[order]
    passings = [airspace.obstacles[i].passing(a[on], b[on]) for i, on in _by_obstacle(piece, obstacle)]
    aside, above, below, sides = map(np.concatenate, zip(*passings, strict=True)) if passings else np.zeros((4, 0))
    passing = ((course.times[piece] - course.times[0]) // PASS).astype(np.intp)
    over = above >= below
    return Approaches(law, piece, obstacle, passing, aside, np.maximum(above, below), over, stretch[piece], sides)


def _by_obstacle(piece: Numbers, obstacle: Numbers) -> list[tuple[int, Numbers]]:
    """Obstacle by obstacle the pieces that belong to it; both are sorted by obstacles."""
    numbers, first = np.unique(obstacle, return_index=True)
    return list(zip(numbers.tolist(), np.split(piece, first[1:]), strict=True)) if len(numbers) else []


def _facing(law: Law, aside: Vector, above: Vector, is_over: NDArray[np.bool_]) -> Vector:
    down, up = (spread.distance(USUAL_CHANCE) / law.level.distance(USUAL_CHANCE) for spread in (law.down, law.up))
    aside, above = np.maximum(aside, 0.0), np.maximum(above, 0.0)
    length = np.hypot(aside, above)
    wider = np.hypot(aside, np.where(is_over, down, up) * above)
    return np.divide(wider, length, out=np.ones(len(aside)), where=length > 0)
