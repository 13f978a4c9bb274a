import math
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


SLOW_SHARE = 0.95  # of the requested speed
MIN_CORNER_DEG = 10.0

Place = tuple[float, float, float]


def corner_deg(before: Place, at: Place, after: Place) -> float:
    """Return the level course change [deg]; 0 at a vertical side."""
    x1, y1, x2, y2 = at[0] - before[0], at[1] - before[1], after[0] - at[0], after[1] - at[1]
    if math.hypot(x1, y1) < 0.1 or math.hypot(x2, y2) < 0.1:
        return 0.0
    return abs(math.degrees(math.atan2(x1 * y2 - y1 * x2, x1 * x2 + y1 * y2)))


def slow_because(
    planned: float | None,
    allowed: float,
    asked: float,
    top: float,
    flown: float,
    corner: float,
    stops: bool,
    curved: bool = False,
) -> str:
    """Return the joined reasons of a leg.

    `planned`: peak speed (None if `curved`). `allowed`: the `asked` speed as limited by its slope. `top`: as limited by
    drag and wind. `flown`: its highest horizontal speed.
    """
    reasons = []
    wanted = min(asked if planned is None else planned, allowed, asked)
    if planned is not None and planned < SLOW_SHARE * min(allowed, asked):
        reasons.append("leg shorter than its braking distance")
    elif allowed < SLOW_SHARE * asked:
        reasons.append("climb or descent rate")
    if curved and flown < SLOW_SHARE * min(top, wanted):
        reasons.append("acceleration on the curve")
    elif top < SLOW_SHARE * wanted:
        reasons.append("drag at the greatest lean")
    elif planned is not None and not reasons and flown < SLOW_SHARE * wanted:
        reasons.append("lag behind the path")
    if corner >= MIN_CORNER_DEG:
        reasons.append(f"corner {corner:.0f} deg")
    if stops:
        reasons.append("stop")
    return ", ".join(reasons)
