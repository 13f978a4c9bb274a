"""Garbage at both ends, a little of what `tools/fuzz_link.py` throws for as long as one likes."""

import importlib.util
import random
from pathlib import Path
from types import ModuleType

import pytest

PATH = Path(__file__).parents[2] / "tools" / "fuzz_link.py"


def fuzzer() -> ModuleType:
    spec = importlib.util.spec_from_file_location("fuzz_link", PATH)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


FUZZ = fuzzer()


@pytest.mark.parametrize("target", FUZZ.TARGETS, ids=lambda target: target.__name__)
def test_garbage_does_no_harm(target: object) -> None:
    for seed in range(5):
        target(random.Random(seed))  # type: ignore[operator]
