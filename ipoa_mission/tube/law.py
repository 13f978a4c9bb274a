"""What is known of each autopilot's tube: measured on recorded flights, held against others."""

from dataclasses import dataclass, replace

import numpy as np

from ipoa_mission.geometry import Vector
from ipoa_mission.tube.spread import Spread

PASS = 4.0  # for about so long what a vehicle is beside its path to one side is one and the same [s]


@dataclass(frozen=True)
class Law:
    """How far a vehicle flies beside its predicted path.

    `level` is to one side within a pass of `PASS` seconds, in a straight flight; a lateral acceleration of `turn`
    [m/s^2] doubles it, and after the last waypoint it is `ending` times as wide. `down` and `up` are the most of a
    whole flight, whatever it does: a height that is known wrongly stays wrong for minutes. `source` says on what it was
    measured, `not_valid` where it says nothing.
    """

    level: Spread
    down: Spread
    up: Spread
    turn: float
    ending: float
    source: str
    not_valid: str

    def stretch(self, across: Vector) -> Vector:
        """How many times as wide as straight ahead the tube is at lateral accelerations (n,) [m/s^2], (n,)."""
        return np.asarray(1.0 + across / self.turn)

    def after_the_way(self) -> "Law":
        """The law after the last waypoint."""
        wider = tuple(self.ending * distance for distance in self.level.distances)
        return replace(self, level=replace(self.level, distances=wider))
