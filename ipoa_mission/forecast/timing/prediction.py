"""What a model of an autopilot hands to `estimate`: when each visit was done, why it was slow, and the flown path."""

from dataclasses import dataclass

from ipoa_mission.forecast.timing.track import Track
from ipoa_mission.geometry import Vector


@dataclass(frozen=True)
class Missed:
    """How likely a waypoint is missed: in this `share` of the flights the vehicle turns back to it, for `cost_s` more.

    PX4 counts a waypoint only when place and height are right as it passes, and it corrects its height in flight.
    """

    share: float
    cost_s: float


NEVER_MISSED = Missed(0.0, 0.0)


@dataclass(frozen=True, eq=False)
class Prediction:
    """When each visit of the itinerary is done (n,) [s], the reason it was slow ("" if none), the path, and remarks.

    Nine flights in ten lie from `low` to `high` (n,) [s]; docs/lab/flight-time.md says how many recorded ones did.
    `missed`: the risk of each visit; empty from a model that knows of none. `touched`: when a flight that is broken off
    comes down to the ground, at the earliest, in the mean and at the latest [s]; it is done once it is disarmed.
    """

    done: Vector
    low: Vector
    high: Vector
    reasons: tuple[str, ...]
    track: Track
    remarks: tuple[str, ...] = ()
    missed: tuple[Missed, ...] = ()
    touched: tuple[float, float, float] | None = None
