import ast
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path

import ipoa_mission
from ipoa_mission.errors import CODES, MissionError, Remedy
from ipoa_mission.rules import RULES
from tools.census import nodes

PACKAGE = Path(ipoa_mission.__file__).parent


def raised() -> Iterator[str]:
    """Yield the codes of classes, and those given by name."""
    errors = {"MissionError"}
    package = [node for path in PACKAGE.rglob("*.py") for node in nodes(path)]
    classes = [node for node in package if isinstance(node, ast.ClassDef)]
    while more := {node.name for node in classes if {ast.unparse(base) for base in node.bases} & errors} - errors:
        errors |= more
    yield MissionError.code
    coded = {node.name for node in classes if any(keyword.arg == "code" for keyword in node.keywords)}
    assert coded == errors - {"MissionError"}
    for node in package:
        if isinstance(node, ast.keyword) and node.arg == "code" and isinstance(node.value, ast.Constant):
            yield str(node.value.value)


def test_every_code_is_registered_and_raised() -> None:
    used = set(raised())
    assert len(used) > 100
    assert used - CODES - RULES.keys() == set()
    assert CODES - used == set()


def test_no_code_is_registered_twice() -> None:
    assert not CODES & RULES.keys()
    text = (PACKAGE / "errors.py").read_text(encoding="utf-8")
    listed = text.partition('_CODES = """')[2].partition('"""')[0].split()
    assert set(listed) == CODES
    assert all(before < after for before, after in pairwise(listed))


def test_an_error_is_data() -> None:
    error = MissionError("too high", "lower", code="too-far", remedies=(Remedy(("goal", "up"), 3.0),)).at("goal", None)
    assert str(error.at("a.toml")) == "a.toml: goal: too high"
    assert error.as_json() == {
        "error": "goal: too high",
        "code": "too-far",
        "place": "goal",
        "hint": "lower",
        "remedies": [{"field": ["goal", "up"], "value": 3.0}],
        "exit_code": 1,
    }
