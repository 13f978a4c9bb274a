"""What is known of each autopilot's tube: measured on recorded flights, held against others."""

from dataclasses import dataclass, replace

import numpy as np

from ipoa_mission.forecast.deviation.quantiles import Quantiles
from ipoa_mission.geometry import Vector

A_FEW = 4  # moments that know nothing of each other, for which a flight is near to a limit that is no obstacle


@dataclass(frozen=True)
class DeviationLaw:
    """How far a vehicle flies beside its predicted path.

    `level` is to one side at a moment, in a straight flight; a lateral acceleration of `turn` [m/s^2] doubles it, and
    after the last waypoint it is `after_way` times as wide. After `memory` seconds it is as good as independent.
    `down` and `up` are the heights at a moment, new every `height_memory` seconds; and as a height that is known
    wrongly stays so, `lowest` and `highest` are the most of a whole flight, whatever it does. So is `farthest` to one
    side, of an autopilot that does not get farther the longer it flies. In wind all of them grow by `growth` [m for
    each m/s, to the side, down, up]. `source` says on what it was measured: nothing stands behind it with
    other airframes and parameters than the simulators', or for what satellites are wrong by. `strongest` is the wind,
    gusts and all, up to which flights kept to it [m/s].
    """

    level: Quantiles
    down: Quantiles
    up: Quantiles
    lowest: Quantiles
    highest: Quantiles
    farthest: Quantiles | None
    turn: float
    after_way: float
    memory: float
    height_memory: float
    growth: tuple[float, float, float]
    source: str
    strongest: float

    def stretch(self, across: Vector) -> Vector:
        """How many times as wide as straight ahead the tube is at lateral accelerations (n,) [m/s^2], (n,)."""
        return np.asarray(1.0 + across / self.turn)

    def beside(self, chance: float) -> float:
        """How far to one side a flight gets with this chance in a few times its memory [m]."""
        return self.level.distance(chance / A_FEW)

    def in_wind(self, speed: float) -> "DeviationLaw":
        """The law in a wind of this speed [m/s], gusts and all: every distance is longer by a share of it."""

        def longer(spread: Quantiles, share: float) -> Quantiles:
            first, *others = spread.distances
            return replace(spread, distances=(first, *(distance + share * speed for distance in others)))

        if speed == 0.0:
            return self
        level, down, up = self.growth
        return replace(
            self,
            level=longer(self.level, level),
            down=longer(self.down, down),
            up=longer(self.up, up),
            lowest=longer(self.lowest, down),
            highest=longer(self.highest, up),
            farthest=self.farthest and longer(self.farthest, level),
        )

    def after_the_way(self) -> "DeviationLaw":
        """The law after the last waypoint."""

        def wider(spread: Quantiles) -> Quantiles:
            return replace(spread, distances=tuple(self.after_way * distance for distance in spread.distances))

        return replace(self, level=wider(self.level), farthest=self.farthest and wider(self.farthest))
