import tomllib
from pathlib import Path

import pytest

from ipoa_mission.errors import BadInput
from ipoa_mission.mission.mission_io import read_mission
from tests.refused import refuses

BROKEN = Path(__file__).parent.parent / "data" / "broken"
MESSAGES = tomllib.loads((BROKEN / "messages.toml").read_text(encoding="utf-8"))


def test_every_broken_file_has_a_message_and_every_message_a_file() -> None:
    assert {path.name for path in BROKEN.iterdir()} == set(MESSAGES) | {"messages.toml"}


@pytest.mark.parametrize("name", MESSAGES)
def test_a_broken_file_is_refused_with_its_message(name: str) -> None:
    path = BROKEN / name
    with pytest.raises(BadInput) as refusal:
        read_mission(path)
    assert str(refusal.value) == f"{path}: {MESSAGES[name]}"
    assert refusal.value.exit_code == 2


@pytest.mark.parametrize(
    ("text", "hint"),
    [
        ("", "the file is empty"),
        ("\n \n", "the file is empty"),
        ('{"mission": {}, }', "there is an extra comma before it"),
        ('{"items": [1, 2,\n]}', "there is an extra comma before it"),
        ('{"mission": {"items": [', "the file is cut off"),
        ('{"mission": {"items": [1 2]}}', None),
    ],
)
def test_the_commonest_reasons_why_a_plan_is_no_json_are_named(tmp_path: Path, text: str, hint: str | None) -> None:
    (tmp_path / "x.plan").write_text(text)
    with refuses("wrong-format") as caught:
        read_mission(tmp_path / "x.plan")
    assert caught.value.hint == hint
