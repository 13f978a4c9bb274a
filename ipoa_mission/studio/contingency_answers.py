"""Define the server's messages on contingencies. Times are seconds from arming."""

from typing import Literal

from ipoa_mission.report.contingency_bars import GradeLook
from ipoa_mission.studio.vocabulary import Number, PageMessage


class StripStretch(PageMessage):
    """A stretch of the flight with one outcome of a contingency; distances along are in [m].

    `words`: its destination, whether it is clear, the share kept, and the share required.
    """

    look: GradeLook
    from_s: float
    to_s: float
    begins: float
    ends: float
    words: str


class StripCost(PageMessage):
    """Time [s] and energy [Wh] of a contingency that begins at a time, each at least and at most.

    It lands with the share `lands` of the battery, between `least` and `most`; None without a battery.
    """

    at_s: float
    seconds: tuple[float, float]
    energy_wh: tuple[float, float] | None
    lands: Number
    least: Number
    most: Number


class StripBar(PageMessage):
    """One contingency over the whole flight; between two `costs` interpolate."""

    ending: str
    stretches: tuple[StripStretch, ...]
    costs: tuple[StripCost, ...]


class StripOfEndings(PageMessage):
    """The outcomes of all contingencies, of one flight of a survey (from 0); no bar where unknown.

    It follows its plan, first without `costs`. `reserve`: the share of the battery that must be left.
    """

    kind: Literal["endings"] = "endings"
    revision: int
    flight: int
    reserve: Number
    bars: tuple[StripBar, ...]
