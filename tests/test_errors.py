import ast
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path

import ipoa_mission
from ipoa_mission.errors import MissionError, Remedy
from ipoa_mission.rules import RULES
from tools.census import nodes

PACKAGE = Path(ipoa_mission.__file__).parent

#: What users may ask for: a code keeps its meaning. Codes of findings, some shared, are in `RULES`.
_LISTED = """
already-there area-covered area-kept-out area-parted arming-refused backend-cannot bad-input battery-flown
battery-missing cancelled command-not-ended command-refused complex-item contested damaged-file departure-missed
endless-flight far-from-home fast-landing fence-broken fence-empty file-refused flight-under-way
frame-not-written gap-too-narrow goal-at-start heights-absurd heights-missing home-missing home-outside-fence
identity-changed in-use interrupted invalid-ring keeps-changing legs-too-near lines-too-far-apart lines-too-near
link-down link-lost link-not-opened list-unproven log-incomplete log-useless low-battery missing mission-error
mission-not-begun mission-refused no-answer no-coordinate-system no-path no-route no-such-item no-time
not-a-mission-item not-at-start not-checked not-covered not-degrees not-enough-battery not-flown not-found
not-heard not-in-the-air not-modeled not-on-ground not-planned not-ready not-split not-started-up
not-the-same-vehicle not-yet nothing-flown nothing-left nothing-there option-conflict other-autopilot
other-item-current other-kind other-rally-points outside-own-fence package-missing page-not-built parameter-kept
picture place-blocked process-killed read-back-differs replaced replaced-since ring-misplaced scenario-missing
several-vehicles signs-otherwise silence speaks-mavlink1 stale start-not-reached streams-missing survey-too-long
survey-too-low survey-too-near time-missing time-not-covered time-up too-large too-many-flights too-narrow
unflyable unknown-name unknown-parameter unknown-version unreachable unreadable unsafe unwritable upload-again
usage walled-off way-home-blocked winds-absurd wrong-format wrong-suffix
"""
LISTED = _LISTED.split()
CODES = frozenset(LISTED)


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
    assert all(before < after for before, after in pairwise(LISTED))


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
