"""What the server tells the page of how a flight can end before its mission does. Times are seconds from arming."""

from typing import Literal

from ipoa_mission.report.contingency_bars import GradeLook
from ipoa_mission.studio.vocabulary import Number, PageMessage


class StripStretch(PageMessage):
    """From when to when an ending leads to the same and is as clear, and between which distances along that is [m].

    `words`: to where, whether it is clear, of what it keeps how much, and what is required.
    """

    look: GradeLook
    from_s: float
    to_s: float
    begins: float
    ends: float
    words: str


class StripCost(PageMessage):
    """What an ending takes that is ordered at a time: seconds, watt hours, each at least and at most.

    It lands with the share `lands` of the battery, between `least` and `most`; None without a battery.
    """

    at_s: float
    seconds: tuple[float, float]
    energy_wh: tuple[float, float] | None
    lands: Number
    least: Number
    most: Number


class StripBar(PageMessage):
    """One ending from the first moment in the air to the last; between two `costs` it takes what lies between them."""

    ending: str
    stretches: tuple[StripStretch, ...]
    costs: tuple[StripCost, ...]


class StripOfEndings(PageMessage):
    """What each ending would do, of a survey in one of its flights, from 0 on; no bar where nobody can say.

    It comes after its plan: first without `costs`. `reserve`: the share of the battery that must be left.
    """

    kind: Literal["endings"] = "endings"
    revision: int
    flight: int
    reserve: Number
    bars: tuple[StripBar, ...]
