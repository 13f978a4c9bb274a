"""What a model of an autopilot hands to `estimate`: when each visit was done, why it was slow, and the flown path."""

from dataclasses import dataclass

from ipoa_mission.geometry import Points, Vector


@dataclass(frozen=True)
class Track:
    """The predicted path: times (n,) from arming [s], points (n, 3) east, north, up [m], speeds (n,) [m/s]."""

    times: Vector
    points: Points
    speeds: Vector


@dataclass(frozen=True, eq=False)
class Prediction:
    """When each visit of the itinerary is done (n,) [s], the reason it was slow ("" if none), the path, and remarks.

    Each time honestly lies from `low` to `high` (n,) [s]; docs/flight-time.md says how often the recorded flights keep
    to it.
    """

    done: Vector
    low: Vector
    high: Vector
    reasons: tuple[str, ...]
    track: Track
    remarks: tuple[str, ...] = ()
