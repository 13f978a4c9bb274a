import ast
from pathlib import Path

import pytest

import ipoa_mission
from ipoa_mission.checks.check import check_mission
from ipoa_mission.geodesy import Geodetic
from ipoa_mission.mission.items import Mission, takeoff, waypoint
from ipoa_mission.rules import RULES
from ipoa_mission.scenario import Scenario
from tests.refused import refuses
from tools.census import nodes

PACKAGE = Path(ipoa_mission.__file__).parent
HOME = Geodetic(47.397742, 8.545594, 488.0)
OPEN_END = Mission(HOME, (takeoff(HOME, 20.0), waypoint(Geodetic(47.6, 8.545594), 20.0)))
MAKERS = {"Finding", "error", "warning", "report"}


def codes_given() -> set[str]:
    codes = set()
    for path in [*PACKAGE.glob("checks/*.py"), *PACKAGE.glob("mission/*.py"), *PACKAGE.glob("maps/*.py")]:
        for node in nodes(path):
            if isinstance(node, ast.Call) and ast.unparse(node.func).rpartition(".")[-1] in MAKERS:
                first = node.args[0]
                if not (path.name == "items.py" and isinstance(first, ast.Name)):
                    assert isinstance(first, ast.Constant), f"{path}:{node.lineno}: expected a code"
                    codes.add(str(first.value))
    return codes


def test_every_finding_is_of_a_rule_and_every_rule_is_used() -> None:
    assert codes_given() == set(RULES)


def test_the_page_has_them_all() -> None:
    page = (PACKAGE.parent / "docs" / "findings.md").read_text(encoding="utf-8")
    rows = [[cell.strip() for cell in line.split("|")[1:-1]] for line in page.splitlines() if line.startswith("| `")]
    assert all(means and do and ignored in ("", "yes") for _, means, do, ignored in rows)
    codes = [code.strip("`") for code, *_ in rows]
    assert len(codes) == len(RULES)
    assert {code: row[-1] == "" for code, row in zip(codes, rows, strict=True)} == RULES


def test_harmless_findings_can_be_ignored_and_crashes_cannot() -> None:
    codes = {finding.code for finding in check_mission(OPEN_END)}
    assert codes == {"far", "ends-in-the-air"}
    assert {finding.code for finding in check_mission(OPEN_END, ignore=["far"])} == {"ends-in-the-air"}
    with refuses("bad-input", "ends-in-the-air"):
        check_mission(OPEN_END, ignore=["ends-in-the-air"])
    with refuses("unknown-name", "fax"):
        check_mission(OPEN_END, ignore=["fax"])


@pytest.mark.parametrize("code", RULES)
def test_a_scenario_ignores_what_may_be_ignored(code: str) -> None:
    scenario = {
        "safety": {"ignore": [code]},
        "home": {"latitude_deg": 47.4, "longitude_deg": 8.5, "altitude_amsl": 488.0},
        "start": {"east": 0.0, "north": 0.0, "up": 10.0},
        "goal": {"east": 50.0, "north": 0.0, "up": 10.0},
        "bounds": {"east": [-20.0, 80.0], "north": [-20.0, 20.0], "up": [0.0, 40.0]},
    }
    if RULES[code]:
        with refuses("bad-input", "safety.ignore"):
            Scenario.from_dict(scenario)
    else:
        assert Scenario.from_dict(scenario).safety.ignored == {code}
