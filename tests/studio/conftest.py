import shutil
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("tomlkit")
pytest.importorskip("uvicorn")
testclient = pytest.importorskip("starlette.testclient")

from ipoa_mission.studio.session import Session  # noqa: E402
from ipoa_mission.studio.sessions import Sessions  # noqa: E402
from ipoa_mission.studio.web_server import application  # noqa: E402
from tests.studio.quick_studio import hasten  # noqa: E402

TOKEN, HOST = "secret-token", "127.0.0.1:8123"
MEADOW = Path(__file__).parent / "meadow.toml"


class Talk:
    def __init__(self, socket: Any) -> None:
        self._socket = socket
        self.heard: list[dict[str, Any]] = []

    def say(self, **request: Any) -> None:
        self._socket.send_json(request)

    def wait(self, kind: str, meant: Callable[[dict[str, Any]], bool] = lambda answer: True) -> dict[str, Any]:
        """Return the next answer of a kind that is meant; unexpected trouble fails the test."""
        while True:
            answer = dict(self._socket.receive_json())
            self.heard.append(answer)
            if answer["kind"] == kind and meant(answer):
                return answer
            assert answer["kind"] != "trouble", answer

    def has(self, kind: str, meant: Callable[[dict[str, Any]], bool] = lambda answer: True) -> dict[str, Any]:
        """Return the latest answer that is meant, or else the next: processes answer in any order."""
        for answer in reversed(self.heard):
            if answer["kind"] == kind and meant(answer):
                return answer
        return self.wait(kind, meant)

    def wait_for_trouble(self, of: str) -> dict[str, Any]:
        while True:
            answer = dict(self._socket.receive_json())
            if answer["kind"] == "trouble" and answer["of"] == of:
                return answer


class Studio:
    def __init__(self, client: Any, scenario: Path, token: str = TOKEN) -> None:
        self.client = client
        self.scenario = scenario
        self._token = token

    @contextmanager
    def window(self) -> Iterator[Talk]:
        headers = {"host": HOST, "origin": f"http://{HOST}"}
        with self.client.websocket_connect(f"/{self._token}/talk", headers=headers) as socket:
            yield Talk(socket)


@pytest.fixture(scope="session")
def running(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Studio]:
    """One server for all tests that ask for it: its workers need seconds to begin."""
    folder = tmp_path_factory.mktemp("studio")
    bundle = folder / "bundle"
    bundle.mkdir()
    (bundle / "index.html").write_text("<!doctype html><title>studio</title>")
    scenario = Path(shutil.copy(MEADOW, folder / "meadow.toml"))
    with pytest.MonkeyPatch.context() as patch:
        hasten(patch.setattr)
        sessions = Sessions()
        sessions.hosts[TOKEN] = Session(scenario)
        app = application(sessions, bundle, HOST)
        with testclient.TestClient(app, base_url=f"http://{HOST}") as client:
            yield Studio(client, scenario)


@pytest.fixture
def studio(running: Studio) -> Iterator[Studio]:
    """Restore the scenario after each test."""
    yield running
    with running.window() as talk:
        text = MEADOW.read_text()
        document = talk.wait("document")
        if document["text"] != text:
            talk.say(kind="rewrite", seen=document["revision"], text=text)
            talk.wait("document")
        talk.say(kind="do", what="save_over")
        talk.wait("document", lambda document: not document["unsaved"])
