"""Garbage at both ends, a little of what `tools/fuzz/link.py` throws for as long as one likes."""

import random
from collections.abc import Callable

import pytest

from tools.fuzz.link import TARGETS


@pytest.mark.parametrize("target", TARGETS, ids=lambda target: target.__name__)
def test_garbage_does_no_harm(target: Callable[[random.Random], object]) -> None:
    for seed in range(5):
        target(random.Random(seed))
