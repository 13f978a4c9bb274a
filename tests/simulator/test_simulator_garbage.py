"""`tools/fuzz/link.py` runs longer."""

import random
from collections.abc import Callable

import pytest

from tools.fuzz.link import TARGETS


@pytest.mark.parametrize("target", TARGETS, ids=lambda target: target.__name__)
def test_garbage_does_no_harm(target: Callable[[random.Random], object]) -> None:
    for seed in range(5):
        target(random.Random(seed))
