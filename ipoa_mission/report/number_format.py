"""How the report writes numbers: with as many digits as are worth reading, and a real minus sign."""

import math


def seconds(value: float) -> str:
    """A time for reading: `43.1 s`, `103 s`, `3 min 13 s`."""
    if value < 99.95:
        return f"{value:.1f}\N{NO-BREAK SPACE}s"
    if value < 119.5:
        return f"{value:.0f}\N{NO-BREAK SPACE}s"
    minutes, rest = divmod(round(value), 60)
    return f"{minutes}\N{NO-BREAK SPACE}min {rest:02d}\N{NO-BREAK SPACE}s"


def meters(value: float, digits: int = 2) -> str:
    """A length for reading: `2.61 m`; `free` when there is nothing near."""
    return f"{number(value, digits)}\N{NO-BREAK SPACE}m" if math.isfinite(value) else "free"


def number(value: float, digits: int) -> str:
    """A number with so many decimals; an empty string when there is none."""
    return f"{round(value, digits) + 0.0:.{digits}f}".replace("-", "−") if math.isfinite(value) else ""


def share(value: float, of: float) -> str:
    """A difference in per cent with its sign: `+1.2 %`."""
    return signed(100 * (value / of - 1), 1, "%") if of else ""


def signed(value: float, digits: int, unit: str = "") -> str:
    """A difference with its sign and its unit, which stays on the same line; an empty string when there is none."""
    if not math.isfinite(value):
        return ""
    rounded = round(value, digits) + 0.0
    words = f"{rounded:+.{digits}f}".replace("-", "−")
    return f"{words}\N{NO-BREAK SPACE}{unit}" if unit else words
