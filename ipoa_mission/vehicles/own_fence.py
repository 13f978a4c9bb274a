"""The fence that a vehicle has by its own parameters, around its home, whatever fence a mission brings."""

from dataclasses import dataclass


@dataclass(frozen=True)
class FenceLimit:
    """One limit of a fence [m], and the parameter that says it; none is infinite."""

    name: str
    value: float


@dataclass(frozen=True)
class OwnFence:
    """How far from home a vehicle may fly, how high above it, and how low between take-off and landing [m]."""

    radius: FenceLimit
    ceiling: FenceLimit
    floor: FenceLimit
