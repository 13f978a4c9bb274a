"""The result of a flight model: times of the visits, reasons of slowness, and the flown path."""

from dataclasses import dataclass

from ipoa_mission.forecast.timing.track import Track
from ipoa_mission.geometry import Vector


@dataclass(frozen=True)
class Missed:
    """The risk of a missed waypoint: in this `share` of the flights the vehicle turns back, which takes `cost_s`.

    PX4 counts a waypoint only when position and height are right as it passes, and it corrects its height in flight.
    """

    share: float
    cost_s: float


NEVER_MISSED = Missed(0.0, 0.0)


@dataclass(frozen=True, eq=False)
class Prediction:
    """Time of each visit (n,) [s], reason of its slowness ("" if none), path, and remarks.

    Nine flights in ten are from `low` to `high` (n,) [s]; docs/lab/flight-time.md has the share of recorded ones.
    `missed`: the risk of each visit; empty from a model without it. `touched`: touchdown of an aborted flight, at the
    earliest, in the mean and at the latest [s]; it is done once disarmed.
    """

    done: Vector
    low: Vector
    high: Vector
    reasons: tuple[str, ...]
    track: Track
    remarks: tuple[str, ...] = ()
    missed: tuple[Missed, ...] = ()
    touched: tuple[float, float, float] | None = None
