"""How many examples a property is tried on, where they are not as many as usual, and which cases are repeats."""

from collections.abc import Iterable
from typing import Any

import pytest
from hypothesis import settings

from ipoa_mission.autopilot.autopilot import Autopilot, registered

USUAL = 50


def examples(usually: int) -> int:
    """So many, and as many times more as `--hypothesis-profile` wants."""
    wanted = settings.default
    assert wanted is not None
    return max(1, usually * wanted.max_examples // USUAL)


def vehicles(soon: Autopilot) -> list[Any]:
    """Every vehicle, for what is tried on one of them `soon`, and repeated on others by the long tests."""
    return [pytest.param(one, marks=() if one is soon else pytest.mark.long) for one in registered()]


def some(count: int, cases: Iterable[Any]) -> list[Any]:
    """Cases, of which so many are tried soon, and those after them by the long tests."""
    return [
        pytest.param(*(case if isinstance(case, tuple) else (case,)), marks=() if place < count else pytest.mark.long)
        for place, case in enumerate(cases)
    ]
