"""Round kept lengths down and required lengths up to the centimetre, for printing and comparison.

No length reads better than it is: 2.478 m is 2.47 m, which is less than 2.50 m.
"""

import math

PER_METER = 100
NOISE = 1e-6  # tolerance for binary fractions [cm]: 0.1 + 0.7 is 80 cm


def down(meters: float, per_meter: int = PER_METER) -> float:
    """Round a kept length down to the centimetre [m].

    >>> down(2.478), down(0.1 + 0.7), down(-0.001)
    (2.47, 0.8, -0.01)
    """
    return math.floor(per_meter * meters + NOISE) / per_meter if math.isfinite(meters) else meters


def up(meters: float, per_meter: int = PER_METER) -> float:
    """Round a required or reached length up to the centimetre [m].

    >>> up(2.491), up(2.5), up(0.1 + 0.7)
    (2.5, 2.5, 0.8)
    """
    return math.ceil(per_meter * meters - NOISE) / per_meter if math.isfinite(meters) else meters


def falls_short(kept: float, required: float) -> bool:
    """Return whether the kept length is less than the required one, as printed [m].

    >>> falls_short(2.499, 2.5), falls_short(2.5, 2.5)
    (True, False)
    """
    return down(kept) < up(required)


def goes_beyond(reached: float, most: float) -> bool:
    """Return whether the reached length exceeds the greatest allowed one, as printed [m]."""
    return up(reached) > down(most)
