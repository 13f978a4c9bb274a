"""Touchdown speed without a range finder: LAND slows down by the height above home.

A range finder, terrain data or, on ArduCopter 4.7 in AUTO, the altitude of the LAND item take precedence. This module
uses the height above home, which every vehicle has.
"""

import math
from dataclasses import dataclass

from ipoa_mission.vehicles.parameters import Parameters, ParameterTable

TOUCHDOWN_TOLERANCE = 0.05  # a touchdown counts as fast beyond the landing speed plus this [m/s]
SLOWEST = 0.05  # [m/s]
HEIGHT_UNCERTAINTY = 2.0  # of heights and terrain maps; the least slow stretch [m]
ROUNDING = 0.05  # parameters are raised by whole metres; a smaller excess of the ground is ignored [m]


@dataclass(frozen=True)
class SlowedBy:
    """The parameters of LAND's slow stretch, their unit [m], and their documented maximum [m].

    `decided_by`: all parameters that affect the touchdown speed. `spared_by`: the parameter of the range finder.
    """

    names: tuple[str, ...]
    unit: float
    most: float
    decided_by: tuple[str, ...]
    spared_by: str = ""

    def raised(self, book: ParameterTable, parameters: Parameters, ground: float) -> Parameters:
        """Return parameters that raise the slow stretch by the ground's height above home [m].

        Values stay within the documented maximum.
        """
        p, higher = book.complete(parameters), math.ceil(ground - ROUNDING)
        return {name: round(min(p[name] * self.unit + higher, self.most) / self.unit, 6) for name in self.names}


@dataclass(frozen=True)
class SlowStretch:
    """LAND's speeds [m/s], and the heights above home where slowing `begins` and `ends` [m]."""

    landing: float
    descent: float
    begins: float
    ends: float

    def touchdown(self, ground: float) -> float:
        """Return the touchdown speed [m/s] on ground at a height above home [m]."""
        share = (ground - self.ends) / max(self.begins - self.ends, 1e-6)
        return self.landing + min(max(share, 0.0), 1.0) * max(self.descent - self.landing, 0.0)

    def is_fast(self, ground: float) -> bool:
        return self.touchdown(ground) > self.landing + TOUCHDOWN_TOLERANCE
