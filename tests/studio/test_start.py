import shutil
import socket
from collections.abc import Iterator
from pathlib import Path

import pytest

from ipoa_mission import read_scenario
from ipoa_mission.studio.sessions import Lobby, Sessions
from ipoa_mission.studio.vocabulary import place_of
from ipoa_mission.studio.web_server import _listen, application
from tests.refused import refuses
from tests.studio.conftest import HOST, TOKEN, Studio, testclient

MISSIONS = Path(__file__).parents[2] / "missions"


@pytest.fixture
def start(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Studio]:
    # The planner that users start, also where the fixture `running` has put the quick one.
    monkeypatch.setattr("ipoa_mission.studio.session.PLANNER", "ipoa_mission.studio.plan_worker")
    shutil.copy(MISSIONS / "sitl.plan", tmp_path / "sitl.plan")
    sessions = Sessions()
    sessions.hosts[TOKEN] = Lobby(tmp_path, sessions.open_file)
    with testclient.TestClient(application(sessions, tmp_path, HOST), base_url=f"http://{HOST}") as client:
        yield Studio(client, tmp_path)


def opened_at(start: Studio, address: str) -> Studio:
    return Studio(start.client, start.scenario, address.strip("./"))


def test_start_page_opens_only_listed_files(start: Studio) -> None:
    with start.window() as talk:
        beginning = talk.wait("beginning")
        assert [Path(path).name for path in beginning["here"]] == ["sitl.plan"]
        talk.say(kind="open", path="/etc/passwd")
        assert "expected a file that the page offers" in talk.wait_for_trouble("file")["message"]
        talk.say(kind="open", path=beginning["examples"][0])
        talk.wait("redirect")
        assert (start.scenario / "campus.toml").read_bytes() == (MISSIONS / "campus.toml").read_bytes()
        talk.say(kind="open", path=beginning["here"][0])
        address = talk.wait("redirect")["address"]
    with opened_at(start, address).window() as talk:
        assert talk.wait("document")["name"] == "sitl"


def test_a_scenario_begins_at_a_place_over_nothing(start: Studio) -> None:
    with start.window() as talk:
        for name in ("mission.toml", "mission-2.toml"):
            talk.say(kind="begin", place="47.397742 N 8.545594 E", altitude=488.0)
            talk.wait("redirect")
            scenario = read_scenario(start.scenario / name)
            assert scenario.home.latitude_deg == 47.397742
            assert scenario.goal_point[:2] == pytest.approx((0.0, 100.0), abs=1.0)


def test_a_log_that_is_dropped_is_laid_beside_the_mission_in_it(start: Studio) -> None:
    log = (MISSIONS / "logs" / "campus-arducopter.tlog").read_bytes()
    dropped = start.client.post(
        f"/{TOKEN}/drop/a.tlog", content=log, headers={"host": HOST, "origin": f"http://{HOST}"}
    )
    with opened_at(start, dropped.json()["address"]).window() as talk:
        replay = talk.wait("replay")
    assert (replay["log"], len(replay["items"])) == ("a.tlog", 21)
    assert (replay["estimated_s"], replay["flown_s"]) == (88.1, 88.8)  # as README has it


def test_a_log_without_its_mission_says_what_else_it_lacks(tmp_path: Path) -> None:
    (tmp_path / "a.ulg").write_bytes((MISSIONS.parent / "tests/logs/sitl-px4.ulg").read_bytes()[:-9])
    with refuses("log-incomplete", "a.ulg", "damaged or truncated"):
        Lobby(tmp_path, Sessions().open_file).opened(tmp_path / "a.ulg")


@pytest.mark.parametrize("words", ["47.397742, 8.545594", "47.397742° N 8.545594° E"])
def test_a_place_is_read_as_people_write_it(words: str) -> None:
    latitude, longitude = place_of(words)
    assert (latitude, longitude) == pytest.approx((47.3977, 8.5456), abs=0.01)


@pytest.mark.parametrize("words", ["", "somewhere", "95, 8", "8FVC9GXW+3686", "32TMT6569449438"])
def test_wrong_places_are_refused(words: str) -> None:
    with refuses("bad-input", "place"):
        place_of(words)


def test_a_file_is_opened_once_and_each_start_has_another_address(tmp_path: Path) -> None:
    first, second = (shutil.copy(MISSIONS / name, tmp_path / name) for name in ("sitl.plan", "campus.toml"))
    sessions = Sessions()
    token = sessions.open_file(Path(first))
    assert sessions.open_file(Path(first).parent / "." / "sitl.plan") == token != sessions.open_file(Path(second))
    assert len(token) > 30
    assert Sessions().open_file(Path(first)) != token


def test_studio_port_in_use_is_refused() -> None:
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        with refuses("bad-input", f"--port {port}"):
            _listen(port)
        with _listen(0) as listener:
            assert listener.getsockname()[1] != port
