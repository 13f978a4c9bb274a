"""Numbers of examples, and cases for long tests only."""

from collections.abc import Iterable
from typing import Any

import pytest
from hypothesis import settings

from ipoa_mission.autopilot.autopilot import Autopilot, registered

USUAL = 50


def examples(usually: int) -> int:
    """Multiply the count by `--hypothesis-profile`."""
    wanted = settings.default
    assert wanted is not None
    return max(1, usually * wanted.max_examples // USUAL)


def vehicles(soon: Autopilot) -> list[Any]:
    """Return every vehicle: `soon` at once, others in long tests."""
    return [pytest.param(autopilot, marks=() if autopilot is soon else pytest.mark.long) for autopilot in registered()]


def some(count: int, cases: Iterable[Any]) -> list[Any]:
    """Return cases, those after `count` for long tests."""
    return [
        pytest.param(*(case if isinstance(case, tuple) else (case,)), marks=() if place < count else pytest.mark.long)
        for place, case in enumerate(cases)
    ]
