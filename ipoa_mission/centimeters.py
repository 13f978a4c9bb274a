"""Lengths that must be kept: printed to the centimetre, and by what is printed compared.

What is kept is rounded down and what is required up, so that nothing reads as more than it is: 2.478 m is 2.47 m, and
that is less than 2.50 m.
"""

import math

PER_METER = 100
NOISE = 1e-6  # centimetres that come from binary fractions: 0.1 + 0.7 is 80 of them


def down(meters: float, per_meter: int = PER_METER) -> float:
    """Rounded down to the centimetre: what is kept at least [m].

    >>> down(2.478), down(0.1 + 0.7), down(-0.001)
    (2.47, 0.8, -0.01)
    """
    return math.floor(per_meter * meters + NOISE) / per_meter if math.isfinite(meters) else meters


def up(meters: float, per_meter: int = PER_METER) -> float:
    """Rounded up to the centimetre: what is required at least, or reached at most [m].

    >>> up(2.491), up(2.5), up(0.1 + 0.7)
    (2.5, 2.5, 0.8)
    """
    return math.ceil(per_meter * meters - NOISE) / per_meter if math.isfinite(meters) else meters


def falls_short(kept: float, required: float) -> bool:
    """Whether less is kept than is required, as both are printed [m].

    >>> falls_short(2.499, 2.5), falls_short(2.5, 2.5)
    (True, False)
    """
    return down(kept) < up(required)


def goes_beyond(reached: float, most: float) -> bool:
    """Whether more is reached than is allowed at most, as both are printed [m]."""
    return up(reached) > down(most)
