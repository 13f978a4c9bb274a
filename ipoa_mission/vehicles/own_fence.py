"""The fence around home that a vehicle's own parameters define, independent of a mission's fence."""

from dataclasses import dataclass


@dataclass(frozen=True)
class FenceLimit:
    """One limit of a fence [m] and its parameter; infinite: no limit."""

    name: str
    value: float


@dataclass(frozen=True)
class OwnFence:
    """Greatest distance from home, greatest height, and least height between take-off and landing [m]."""

    radius: FenceLimit
    ceiling: FenceLimit
    floor: FenceLimit
