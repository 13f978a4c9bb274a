import re
import tomllib
from pathlib import Path

import pytest

from ipoa_mission.scenario import Scenario, parse_scenario
from tools.generate import scenario_reference

PAGES = {path.name: path.read_text(encoding="utf-8") for path in scenario_reference.PAGES}
TEXT = "\n".join(PAGES.values())


@pytest.mark.parametrize("name", PAGES)
def test_the_tables_are_those_of_the_schema(name: str) -> None:
    page = PAGES[name]
    assert scenario_reference.refreshed(page) == page, "run python -m tools.generate.scenario_reference"


def test_the_index_links_every_table() -> None:
    rows = re.findall(r"^\| (\S+) \| .*\ba table\b", PAGES["scenario.md"], re.MULTILINE)
    assert len(rows) > 15
    assert not [key for key in rows if not key.startswith("[")]


def test_every_table_of_the_schema_is_explained_once() -> None:
    tables = {"Scenario"} | {n for n, d in Scenario.model_json_schema()["$defs"].items() if "properties" in d}
    assert sorted(re.findall(r"<!-- keys of (\w+) -->", TEXT)) == sorted(tables)


def test_every_key_has_a_meaning_and_a_value() -> None:
    rows = re.findall(r"^\| \[?`(\w+)`\S* \| (.*) \| (.*) \| (.*) \|$", TEXT, re.MULTILINE)
    assert len(rows) > 100
    for key, value, left_out, meaning in rows:
        assert value.strip(), key
        assert left_out.strip(), key
        assert len(meaning.strip()) > 5, key


def test_the_smallest_scenario_of_the_document_can_be_read() -> None:
    (example,) = re.findall(r"```toml\n(.*?)```", TEXT, re.DOTALL)
    assert len(tomllib.loads(example)) == 3
    assert parse_scenario(example, Path("x.toml")).goal_point == pytest.approx([120, 90, 20])
