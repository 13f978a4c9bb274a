from dataclasses import dataclass

from ipoa_mission.forecast.timing.track import Track
from ipoa_mission.geometry import Vector


@dataclass(frozen=True)
class Missed:
    """A waypoint that PX4 misses by height in this `share` of flights; turning back takes `cost_s`."""

    share: float
    cost_s: float


NEVER_MISSED = Missed(0.0, 0.0)


@dataclass(frozen=True, eq=False)
class Prediction:
    """Time of each visit (n,) [s], reason of its slowness, path, and remarks.

    Nine flights in ten are from `low` to `high` (n,) [s]. `missed`: by visit. `touched`: touchdown of an aborted
    flight, at the earliest, in the mean and at the latest [s].
    """

    done: Vector
    low: Vector
    high: Vector
    reasons: tuple[str, ...]
    track: Track
    remarks: tuple[str, ...] = ()
    missed: tuple[Missed, ...] = ()
    touched: tuple[float, float, float] | None = None
