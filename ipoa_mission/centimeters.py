"""Round kept lengths down and required ones up: no length reads better than it is."""

import math

PER_METER = 100
NOISE = 1e-6  # [cm]: 0.1 + 0.7 is 80 cm


def floor_cm(meters: float, per_meter: int = PER_METER) -> float:
    """Round a kept length down [m].

    >>> floor_cm(2.478), floor_cm(0.1 + 0.7), floor_cm(-0.001)
    (2.47, 0.8, -0.01)
    """
    return math.floor(per_meter * meters + NOISE) / per_meter if math.isfinite(meters) else meters


def ceil_cm(meters: float, per_meter: int = PER_METER) -> float:
    """Round a required or reached length up [m].

    >>> ceil_cm(2.491), ceil_cm(2.5), ceil_cm(0.1 + 0.7)
    (2.5, 2.5, 0.8)
    """
    return math.ceil(per_meter * meters - NOISE) / per_meter if math.isfinite(meters) else meters


def falls_short(kept: float, required: float) -> bool:
    """Compare as printed [m].

    >>> falls_short(2.499, 2.5), falls_short(2.5, 2.5)
    (True, False)
    """
    return floor_cm(kept) < ceil_cm(required)


def goes_beyond(reached: float, most: float) -> bool:
    return ceil_cm(reached) > floor_cm(most)
