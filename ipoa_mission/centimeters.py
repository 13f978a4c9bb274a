"""Round kept lengths down and required ones up: no length reads better than it is."""

import math

PER_METER = 100
NOISE = 1e-6  # [cm]: 0.1 + 0.7 is 80 cm


def down(meters: float, per_meter: int = PER_METER) -> float:
    """Round a kept length down [m].

    >>> down(2.478), down(0.1 + 0.7), down(-0.001)
    (2.47, 0.8, -0.01)
    """
    return math.floor(per_meter * meters + NOISE) / per_meter if math.isfinite(meters) else meters


def up(meters: float, per_meter: int = PER_METER) -> float:
    """Round a required or reached length up [m].

    >>> up(2.491), up(2.5), up(0.1 + 0.7)
    (2.5, 2.5, 0.8)
    """
    return math.ceil(per_meter * meters - NOISE) / per_meter if math.isfinite(meters) else meters


def falls_short(kept: float, required: float) -> bool:
    """Compare as printed [m].

    >>> falls_short(2.499, 2.5), falls_short(2.5, 2.5)
    (True, False)
    """
    return down(kept) < up(required)


def goes_beyond(reached: float, most: float) -> bool:
    return up(reached) > down(most)
