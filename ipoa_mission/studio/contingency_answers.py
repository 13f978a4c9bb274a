"""Messages on contingencies. Times are seconds from arming."""

from typing import Literal

from ipoa_mission.report.contingency_bars import GradeLook
from ipoa_mission.studio.vocabulary import Number, PageMessage


class StripStretch(PageMessage):
    """A stretch with one outcome; distances along [m]. `words`: destination, share kept and required."""

    look: GradeLook
    from_s: float
    to_s: float
    begins: float
    ends: float
    words: str


class StripCost(PageMessage):
    """Time [s] and energy [Wh], each at least and at most; landing share of the battery, None without one."""

    at_s: float
    seconds: tuple[float, float]
    energy_wh: tuple[float, float] | None
    lands: Number
    least: Number
    most: Number


class StripBar(PageMessage):
    """Interpolate between `costs`."""

    ending: str
    stretches: tuple[StripStretch, ...]
    costs: tuple[StripCost, ...]


class StripOfEndings(PageMessage):
    """Outcomes of one flight of a survey (from 0), first without `costs`; `reserve`: share that must be left."""

    kind: Literal["endings"] = "endings"
    revision: int
    flight: int
    reserve: Number
    bars: tuple[StripBar, ...]
