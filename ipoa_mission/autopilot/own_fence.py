from dataclasses import dataclass


@dataclass(frozen=True)
class FenceLimit:
    """A limit [m] and its parameter; infinite: none."""

    name: str
    value: float


@dataclass(frozen=True)
class OwnFence:
    """Distance from home, and heights between take-off and landing [m]."""

    radius: FenceLimit
    ceiling: FenceLimit
    floor: FenceLimit
