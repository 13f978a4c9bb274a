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
    whole flight, whatever it does: a height that is known wrongly stays wrong for minutes. In wind the three grow by
    `growth` [m for each m/s]. `source` says on what it was measured, `not_valid` where it says nothing.
    """

    level: Spread
    down: Spread
    up: Spread
    turn: float
    ending: float
    growth: tuple[float, float, float]
    source: str
    not_valid: str

    def stretch(self, across: Vector) -> Vector:
        """How many times as wide as straight ahead the tube is at lateral accelerations (n,) [m/s^2], (n,)."""
        return np.asarray(1.0 + across / self.turn)

    def in_wind(self, speed: float) -> "Law":
        """The law in a wind of this speed [m/s], gusts and all: every distance is longer by a share of it."""

        def longer(spread: Spread, share: float) -> Spread:
            first, *others = spread.distances
            return replace(spread, distances=(first, *(distance + share * speed for distance in others)))

        if speed == 0.0:
            return self
        spreads = zip((self.level, self.down, self.up), self.growth, strict=True)
        level, down, up = (longer(spread, share) for spread, share in spreads)
        return replace(self, level=level, down=down, up=up)

    def after_the_way(self) -> "Law":
        """The law after the last waypoint."""
        wider = tuple(self.ending * distance for distance in self.level.distances)
        return replace(self, level=replace(self.level, distances=wider))
