import socket
from pathlib import Path

import pytest

from ipoa_mission.studio import memory
from ipoa_mission.studio.web_server import _listen
from tests.refused import refuses


@pytest.fixture(autouse=True)
def own_state(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path))


def test_a_file_has_the_address_that_it_had() -> None:
    first, second = memory.address_of(Path("/a.toml")), memory.address_of(Path("/b.toml"))
    assert first.port == 0
    assert first.token != second.token
    memory.remember(first, 4711)
    memory.remember(second, 4712)
    again = memory.address_of(Path("/a.toml"))
    assert (again.port, again.token) == (4711, first.token)
    assert [entry.path for entry in memory.known().opened] == ["/b.toml", "/a.toml"]


def test_only_this_user_reads_what_is_kept() -> None:
    memory.remember(memory.address_of(Path("/a.toml")), 4711)
    assert memory.memory_file().stat().st_mode & 0o077 == 0
    assert memory.memory_file().parent.stat().st_mode & 0o077 == 0


@pytest.mark.parametrize("text", ["", "[]", '{"opened": [1, {"path": "/a.toml", "port": "x", "token": "y"}]}'])
def test_senseless_entries_are_forgotten(text: str) -> None:
    memory.memory_file().parent.mkdir()
    memory.memory_file().write_text(text)
    assert memory.known().opened == ()
    assert len(memory.address_of(Path("/a.toml")).token) > 20


def test_studio_port_in_use_is_replaced_unless_it_was_requested() -> None:
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        with _listen(0, port) as listener:
            assert listener.getsockname()[1] != port
        with refuses("bad-input", f"--port {port}"):
            _listen(port, 0)
