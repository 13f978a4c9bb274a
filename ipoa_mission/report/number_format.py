"""Significant digits only, and a real minus sign."""

import math


def seconds(value: float) -> str:
    """`43.1 s`, `103 s`, `3 min 13 s`."""
    if value < 119.5:
        digits = 1 if value < 99.95 else 0
        return f"{value:.{digits}f}\N{NO-BREAK SPACE}s"
    minutes, rest = divmod(round(value), 60)
    return f"{minutes}\N{NO-BREAK SPACE}min {rest:02d}\N{NO-BREAK SPACE}s"


def number(value: float | None, digits: int) -> str:
    """Empty if unknown or not finite."""
    if value is None or not math.isfinite(value):
        return ""
    return f"{round(value, digits) + 0.0:.{digits}f}".replace("-", "−")


def signed(value: float, digits: int, unit: str = "") -> str:
    """As `+1.2 m`; empty if not finite."""
    if not math.isfinite(value):
        return ""
    words = f"{round(value, digits) + 0.0:+.{digits}f}".replace("-", "−")
    return f"{words}\N{NO-BREAK SPACE}{unit}" if unit else words
