import json
import shutil
import subprocess
from pathlib import Path

import pytest

from ipoa_mission.studio.answers import ANSWERS, Trouble
from ipoa_mission.studio.flight_answers import State
from ipoa_mission.studio.requests import REQUESTS
from tools.generate.page_messages import schema

WEB = Path(__file__).parents[2] / "ipoa_mission" / "studio" / "web"


def test_every_message_tells_by_its_kind_what_it_is() -> None:
    definitions = schema()["$defs"]
    kinds = [definitions[kind["$ref"].rsplit("/", 1)[-1]] for kind in definitions["Answer"]["oneOf"]]
    kinds += [definitions[kind["$ref"].rsplit("/", 1)[-1]] for kind in definitions["Request"]["oneOf"]]
    names = [kind["properties"]["kind"]["const"] for kind in kinds]
    assert len(set(names)) == len(names) == 37
    assert all("kind" in kind["required"] for kind in kinds)
    assert definitions["Document"]["properties"]["scenario"] == {"$ref": "#/$defs/Scenario"}


def test_messages_are_what_they_were_when_they_come_back() -> None:
    for message in (State(phase="idle", words="x"), Trouble(of="plan", message="no")):
        assert ANSWERS.validate_json(message.model_dump_json()) == message
    with pytest.raises(ValueError, match="extra"):
        REQUESTS.validate_json('{"kind": "do", "what": "undo", "also": 1}')


def test_the_page_is_typed_by_the_schema(tmp_path: Path) -> None:
    made_by, checked_by = (str(WEB / "node_modules" / ".bin" / name) for name in ("json2ts", "tsc"))
    if shutil.which("node") is None or not (Path(made_by).exists() and Path(checked_by).exists()):
        pytest.skip("needs Node.js, and npm ci in ipoa_mission/studio/web")
    for file in (*WEB.glob("*.ts"), *WEB.glob("*.tsx"), WEB / "tsconfig.json"):
        shutil.copy(file, tmp_path / file.name)
    (tmp_path / "node_modules").symlink_to(WEB / "node_modules")
    arguments = [str(made_by), "--unreachableDefinitions", "--bannerComment", ""]
    made = subprocess.run(arguments, input=json.dumps(schema()), capture_output=True, text=True, check=True)
    (tmp_path / "messages.d.ts").write_text(made.stdout)
    checked = subprocess.run([checked_by, "--noEmit"], capture_output=True, text=True, cwd=tmp_path, check=False)
    assert checked.returncode == 0, checked.stdout


def test_the_list_of_packages_names_no_registry() -> None:
    assert "resolved" not in (WEB / "package-lock.json").read_text()
