"""How fast a vehicle touches down where no range finder sees the ground: LAND slows down by the height over home.

What a range finder, terrain data or (ArduCopter 4.7, LAND in AUTO) the altitude of the LAND item say goes before that;
the height over home is what counts here: it is what every vehicle has.
"""

import math
from dataclasses import dataclass

from ipoa_mission.vehicles.parameters import Parameters, ParameterTable

FASTER = 0.05  # a touchdown faster than the landing speed by less than this is none [m/s]
SLOWEST = 0.05  # [m/s]
SURE = 2.0  # heights and maps of the ground are off by so much: a slow stretch is no shorter [m]
ROUNDING = 0.05  # parameters are raised by whole metres; a ground that is higher by so little needs no more [m]


@dataclass(frozen=True)
class SlowedBy:
    """The parameters by which LAND slows down, the unit of each [m], the most that its firmware documents [m].

    `decided_by`: all that decides how fast it touches down; `spared_by`: what gives it a range finder.
    """

    names: tuple[str, ...]
    unit: float
    most: float
    decided_by: tuple[str, ...]
    spared_by: str = ""

    def raised(self, book: ParameterTable, parameters: Parameters, ground: float) -> Parameters:
        """What lets it slow down as high above ground so high above home [m] as these parameters do above home.

        No parameter goes beyond what its firmware documents.
        """
        p, higher = book.complete(parameters), math.ceil(ground - ROUNDING)
        return {name: round(min(p[name] * self.unit + higher, self.most) / self.unit, 6) for name in self.names}


@dataclass(frozen=True)
class SlowStretch:
    """LAND's speeds [m/s], and the heights over home where it begins to be slower and is as slow as it gets [m]."""

    landing: float
    descent: float
    begins: float
    ends: float

    def touchdown(self, ground: float) -> float:
        """At how many m/s it touches down on ground so high above home [m]."""
        share = (ground - self.ends) / max(self.begins - self.ends, 1e-6)
        return self.landing + min(max(share, 0.0), 1.0) * max(self.descent - self.landing, 0.0)

    def is_fast(self, ground: float) -> bool:
        """Whether it touches down there faster than it lands."""
        return self.touchdown(ground) > self.landing + FASTER
