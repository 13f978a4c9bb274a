import socket

import pytest

from ipoa_mission.studio import flight_worker
from ipoa_mission.studio.flight_answers import Heard


def free_port() -> int:
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        return int(free.getsockname()[1])


def test_each_link_is_told_of(monkeypatch: pytest.MonkeyPatch) -> None:
    silent, closed = f"udpin:127.0.0.1:{free_port()}", f"tcp:127.0.0.1:{free_port()}"
    monkeypatch.setattr(flight_worker, "USUAL", (silent, closed))
    monkeypatch.setattr(flight_worker, "LISTEN_S", 0.02)
    monkeypatch.setattr(flight_worker, "serial_ports", lambda: ())
    vehicles: list[Heard] = []
    flight_worker.listen({"link": "nonsense"}, vehicles.append)  # type: ignore[arg-type]
    rows = {row.link: (row.system, row.words) for row in vehicles[0].links}
    assert list(rows) == ["nonsense", silent, closed]
    assert rows[silent] == (None, "no vehicle heard")
    assert rows[closed][0] is rows["nonsense"][0] is None
    assert "cannot be opened" in rows[closed][1]
