"""Touchdown speed by LAND's height above home.

A range finder, terrain data or ArduCopter 4.7's LAND altitude in AUTO would take precedence.
"""

import math
from dataclasses import dataclass

from ipoa_mission.autopilot.parameters import Parameters, ParameterTable

SLOWEST = 0.05  # [m/s]
HEIGHT_UNCERTAINTY = 2.0  # of heights and terrain maps; least slow stretch [m]


@dataclass(frozen=True)
class SlowedBy:
    """LAND's slow stretch, its unit and documented maximum [m].

    `decided_by`: all that affect touchdown. `spared_by`: the range finder's.
    """

    names: tuple[str, ...]
    unit: float
    most: float
    decided_by: tuple[str, ...]
    spared_by: str = ""

    def raised(self, table: ParameterTable, parameters: Parameters, ground: float) -> Parameters:
        p = table.complete(parameters)
        higher = math.ceil(ground - 0.05)  # whole meters, with rounding
        return {name: round(min(p[name] * self.unit + higher, self.most) / self.unit, 6) for name in self.names}


@dataclass(frozen=True)
class SlowStretch:
    """LAND's speeds [m/s], and heights above home of its slowing [m]."""

    landing: float
    descent: float
    begins: float
    ends: float

    def touchdown(self, ground: float) -> float:
        share = (ground - self.ends) / max(self.begins - self.ends, 1e-6)
        return self.landing + min(max(share, 0.0), 1.0) * max(self.descent - self.landing, 0.0)

    def is_fast(self, ground: float) -> bool:
        return self.touchdown(ground) > self.landing + 0.05
