import ast
import re
from pathlib import Path

import pytest

from tools import REPOSITORY
from tools.census import comments

REFERENCE = re.compile(r"[A-Za-z_]\w*(?:[./][A-Za-z_]\w*)*(?:\(\))?")
ROOMS = re.compile(r"`(?!tests/)((?:\w+/)+)(\w+)((?:\.\w+)*)`")  # room, module, names
PROSE = re.compile(r'"""(?s:.*?)"""|(?:^|  ) *#.*', re.MULTILINE)
#: Of other projects, files and data.
FOREIGN = {
    "BLDG_HEIGHT", "MAVLink_command_long_message", "SOH", "_INT", "opfunu", "pyproject.toml", "rc.mc_defaults",
    "scipy.interpolate.CubicSpline", "shape_pos_vel_accel",
}  # fmt: skip


def known() -> set[str]:
    names = set[str]()
    for folder in ("ipoa_mission", "tools"):
        for path in (REPOSITORY / folder).rglob("*.py"):
            names |= {path.stem, *path.relative_to(REPOSITORY).parts}
            names.update(re.findall(r"\w+", PROSE.sub(" ", path.read_text(encoding="utf-8"))))
    return names | {path.name for path in Path(REPOSITORY).iterdir()}


def test_names_in_backticks_exist() -> None:
    names = known()
    stale = {
        f"{place}: {reference}"
        for place, text in comments()
        for reference in re.findall(r"`([^`\n]+)`", text)
        if REFERENCE.fullmatch(reference) and reference not in FOREIGN
        if not names.issuperset(re.split(r"[./]", reference.removesuffix("()")))
    }
    assert not stale


def is_defined(module: Path, names: list[str]) -> bool:
    body = ast.parse(module.read_text(encoding="utf-8")).body if module.exists() else []
    for name in names:
        found = [node for node in body if isinstance(node, ast.ClassDef | ast.FunctionDef) and node.name == name]
        if not found:
            return False
        body = found[0].body
    return module.exists()


@pytest.mark.parametrize("page", ["life-of-a-plan.md", "life-of-a-survey.md", "glossary.md", "safety.md"])
def test_names_with_their_room_exist(page: str) -> None:
    text = (REPOSITORY / "docs" / page).read_text(encoding="utf-8")
    references = ROOMS.findall(text)
    stale = {
        f"{room}{module}{names}"
        for room, module, names in references
        if not is_defined(REPOSITORY / "ipoa_mission" / room / f"{module}.py", names.split(".")[1:])
    }
    assert references
    assert not stale


def test_formulas_of_the_guarantee_name_methods() -> None:
    text = (REPOSITORY / "docs" / "safety.md").read_text(encoding="utf-8")
    methods = set(re.findall(r"`(\w+)\(\)`", text))
    proximity = REPOSITORY / "ipoa_mission/forecast/deviation/proximity.py"
    stale = {method for method in methods if not is_defined(proximity, ["ProximityRisks", method])}
    formulas = re.findall(r"^    \S.* <?= .*$", text, re.MULTILINE)
    assert len([line for line in formulas if "()`" in line]) > 7
    assert not stale


def test_each_step_of_a_plan_names_its_room() -> None:
    text = (REPOSITORY / "docs" / "life-of-a-plan.md").read_text(encoding="utf-8")
    steps = re.split(r"^\d+\. ", text, flags=re.MULTILINE)[1:]
    assert len(steps) > 20
    assert not [step for step in steps if not ROOMS.search(step.split("\n\n#")[0])]
