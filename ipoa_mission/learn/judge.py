"""What a learned vehicle is worth: each flight timed with what the others tell."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ipoa_mission.autopilots.learned import LearnedVehicle
from ipoa_mission.errors import MissionError
from ipoa_mission.learn.evidence import Evidence
from ipoa_mission.learn.fit import fit


@dataclass(frozen=True)
class LeftOut:
    """A flight timed without having been learned from: seconds flown, by the simulated vehicle, by the learned one."""

    name: str
    flown_s: float
    before_s: float
    after_s: float

    @property
    def better(self) -> float:
        """By how many seconds the learned vehicle is nearer."""
        return abs(self.before_s - self.flown_s) - abs(self.after_s - self.flown_s)


def left_out(flights: Sequence[Evidence], leashed: bool = False) -> tuple[LeftOut, ...]:
    """Each flight by what all others tell.

    Raises:
        MissionError: fewer than two flights, or the others of one tell nothing.
    """
    if len(flights) < 2:
        raise MissionError("expected two flights or more: what one tells is judged by another")
    return tuple(_timed(one, fit([each for each in flights if each is not one], leashed)) for one in flights)


def timed(flights: Sequence[Evidence], vehicle: LearnedVehicle) -> tuple[LeftOut, ...]:
    """Each flight by a vehicle that was learned from others."""
    return tuple(_timed(one, vehicle) for one in flights)


def _timed(one: Evidence, vehicle: LearnedVehicle) -> LeftOut:
    before, after = (float(one.forecast(each).sum()) for each in (None, vehicle))
    return LeftOut(one.name, float(one.seconds.sum()), before, after)


def median_errors(judged: Sequence[LeftOut]) -> tuple[float, float]:
    """The median error of a flight's time before and after, as a share of it."""
    before = [abs(one.before_s / one.flown_s - 1) for one in judged]
    after = [abs(one.after_s / one.flown_s - 1) for one in judged]
    return float(np.median(before)), float(np.median(after))
