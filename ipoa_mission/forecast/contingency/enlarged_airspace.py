"""Enlarge obstacles by the deviation bound of contingencies."""

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from ipoa_mission.forecast.deviation.kept_limits import (
    MIN_GROWTH,
    TightPlace,
    clearance_task,
    tight_places,
    with_margins,
)
from ipoa_mission.geometry import Points, Vector
from ipoa_mission.scenario import Scenario
from ipoa_mission.world.airspace import NOTHING_NEAR, Airspace, Clearance

SHARING = 4.0  # places that share the chance of exceeding the bound


@dataclass(frozen=True, eq=False)
class EnlargedAirspace:
    """`whole`: obstacles enlarged by the whole bound. `left`: by at most the room at each given place.

    Within reach of a `tight` place those of `left` count, as in the guarantee of the flight.
    """

    whole: Airspace
    left: Airspace
    tight: tuple[TightPlace, ...] = ()

    @classmethod
    def of(cls, scenario: Scenario) -> "EnlargedAirspace":
        task = clearance_task(scenario)
        whole = with_margins(task, SHARING, spares_places=False).airspace
        if task.chance is None:
            return cls(whole, whole)
        tight = tight_places(scenario, task.law.lateral.distance(task.chance / SHARING) + MIN_GROWTH)
        return cls(whole, with_margins(task, SHARING).airspace if tight else whole, tight)

    @cached_property
    def _by_height(self) -> dict[float, "EnlargedAirspace"]:
        return {0.0: self}

    def taller(self, by: float) -> "EnlargedAirspace":
        """Extend obstacles down and up [m]."""
        if by not in self._by_height:
            whole, left = (
                replace(airspace, obstacles=tuple(body.grown(0.0, by, by) for body in airspace.obstacles))
                for airspace in (self.whole, self.left)
            )
            self._by_height[by] = EnlargedAirspace(whole, left, self.tight)
        return self._by_height[by]

    def at_tight_place(self, starts: Points, ends: Points) -> NDArray[np.bool_]:
        """Return which legs (n,) come within reach of a tight place."""
        is_near = np.zeros(len(starts), dtype=bool)
        along = ends - starts
        squared = np.maximum((along**2).sum(axis=1), 1e-12)
        for tight in self.tight:
            share = np.clip(((tight.place - starts) * along).sum(axis=1) / squared, 0.0, 1.0)
            is_near |= np.linalg.norm(starts + share[:, None] * along - tight.place, axis=1) <= tight.reach
        return is_near

    def leg_clearance(self, start: Vector, end: Vector, within: float) -> tuple[float, int]:
        """Return the least distance of a leg to an obstacle `within` [m], and its index; else infinite and -1."""
        least = math.inf
        nearest = -1
        for piece, airspace in self._pieces(start, end):
            _, which = airspace.legs_clearance(piece[:1], piece[1:], within)
            number = int(which[0])
            if number >= 0:
                distance, _ = airspace.obstacles[number].leg_clearance(*piece)
                if distance < least:
                    least, nearest = distance, number
        return least, nearest

    def obstacle_clearance(self, points: Points, within: float = math.inf) -> Clearance:
        """As `Airspace.obstacle_clearance`."""
        if not self.tight:
            return self.whole.obstacle_clearance(points, within)
        least = NOTHING_NEAR
        for leg, (start, end) in enumerate(pairwise(points)):
            for piece, airspace in self._pieces(start, end):
                clearance = airspace.obstacle_clearance(piece, min(within, least.distance))
                if clearance.distance < least.distance:
                    least = replace(clearance, leg=leg)
        return least

    def _pieces(self, start: Vector, end: Vector) -> Iterator[tuple[Points, Airspace]]:
        """Cut a leg where it enters and leaves the reach of tight places."""
        along = end - start
        squared = float(along @ along)
        cuts = {0.0, 1.0}
        for tight in self.tight:
            away = start - tight.place
            half = float(away @ along)
            root = half**2 - squared * (float(away @ away) - tight.reach**2)
            if squared > 0.0 and root > 0.0:
                cuts |= {share for sign in (-1, 1) if 0.0 < (share := (sign * math.sqrt(root) - half) / squared) < 1.0}
        for begin, after in pairwise(sorted(cuts)):
            middle = start + (begin + after) / 2 * along
            is_near = any(np.linalg.norm(middle - tight.place) <= tight.reach for tight in self.tight)
            yield start + np.outer((begin, after), along), self.left if is_near else self.whole
