from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from ipoa_mission.autopilot.autopilot import Autopilot
from ipoa_mission.geodesy import Geodetic, swap_hint
from ipoa_mission.link.codec import numbered
from ipoa_mission.link.connect import connect
from ipoa_mission.link.dialogue import NoAnswer, TimeUp
from ipoa_mission.link.flight_order import Conformance, FlightOrder
from ipoa_mission.link.messages import Position
from ipoa_mission.link.reconnect import LinkLoss
from ipoa_mission.link.vehicle_state import VehicleState
from ipoa_mission.logs.flight_log import LoggedFlight
from ipoa_mission.simulator.mock_profile import asks_every
from ipoa_mission.world.obstacles.kinds import RoundZone


def test_the_sender_and_number_of_a_frame_are_read_in_both_versions() -> None:
    assert numbered(bytes((0xFE, 0, 3, 7, 1, 0))) == ((7, 1), 3)
    assert numbered(bytes((0xFD, 0, 0, 0, 3, 9, 1, 0, 0, 0))) == ((9, 1), 3)


def test_a_log_of_our_own_frames_is_removed_where_nobody_answers(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("ipoa_mission.link.connect.PRESENCE_S", 1.2)
    for log in (tmp_path / "silent.tlog", None):
        with pytest.raises(NoAnswer):
            connect("udpout:127.0.0.1:9", log=log, retry_policy=asks_every(0.1, 0.3))
    assert not list(tmp_path.iterdir())


def test_an_order_is_under_way_while_it_has_steps() -> None:
    order = FlightOrder(VehicleState(Autopilot.PX4), lambda: 0.0)
    assert not order.is_under_way
    order.hold()
    assert order.is_under_way


def test_a_log_without_a_version_has_none() -> None:
    flight = LoggedFlight(Autopilot.PX4, "unknown", 0.0, None, {}, in_mission=True, messages=())
    assert flight.firmware_version is None


def test_exchanged_coordinates_are_named() -> None:
    assert "swapped" in swap_hint(Geodetic(47.4, 8.5, 0.0), Geodetic(8.5, 47.4, 0.0), "goal")
    assert swap_hint(Geodetic(47.4, 8.5, 0.0), Geodetic(-30.0, 100.0, 0.0), "goal") == ""


def test_zone_is_not_solid() -> None:
    assert not RoundZone("zone", 0.0, 0.0, 10.0, 0.0, 50.0).solid


def test_the_users_time_ends_the_waiting_for_a_lost_link(monkeypatch: pytest.MonkeyPatch) -> None:
    link_loss: Any = LinkLoss(SimpleNamespace(now=lambda: 10.0, reopens=True))
    monkeypatch.setattr(LinkLoss, "_report_loss", lambda self, report: None)
    monkeypatch.setattr(LinkLoss, "_identified", lambda self, *known: None)
    with pytest.raises(TimeUp):
        link_loss.end(NoAnswer("silence"), None, print, until_s=5.0)


def conformance(in_air: bool, mode: int, under_way: bool = False) -> Any:
    modes = SimpleNamespace(mission=1, returns=frozenset({2}))
    state = SimpleNamespace(
        in_air=in_air, custom_mode=mode, current=None, autopilot=SimpleNamespace(modes=modes, seq_offset=0)
    )
    order = SimpleNamespace(is_under_way=under_way, is_paused=False, is_refused=False, words="", now=lambda: 0.0)
    made: Any = Conformance(state, order)  # type: ignore[arg-type]
    seen: list[Any] = []
    monitor = SimpleNamespace(
        interrupt=lambda: seen.append("interrupted"),
        local=lambda place, height: place,
        see=lambda time, place, item: seen.append(item),
    )
    made.begin(monitor)
    made.seen = seen
    return made


def looked(made: Any) -> list[Any]:
    list(made.observe(Position(10.0, 47.4, 8.5, 500.0, 12.0), 0.0))
    return list(made.seen)


def test_places_outside_the_mission_mode_are_not_compared() -> None:
    assert looked(conformance(in_air=False, mode=1)) == []
    assert looked(conformance(in_air=True, mode=3)) == ["interrupted"]
    ordered = conformance(in_air=True, mode=1, under_way=True)
    ordered._is_ordered = True
    assert looked(ordered) == []
    assert looked(conformance(in_air=True, mode=1)) == [None]
    resumed = conformance(in_air=True, mode=1)
    resumed._is_ordered = True
    assert looked(resumed) == [None]
    assert not resumed._is_ordered


def test_a_return_at_the_end_of_a_mission_is_its_last_item() -> None:
    returns = conformance(in_air=True, mode=2)
    returns.logbook = SimpleNamespace(modes=frozenset({2}), is_flown=True, done=5, total=6)
    assert looked(returns) == [5]
    early = conformance(in_air=True, mode=2)
    early.logbook = SimpleNamespace(modes=frozenset({2}), is_flown=False, done=1, total=6)
    assert looked(early) == ["interrupted"]


def test_another_kind_of_vehicle_is_asked_for_no_positions() -> None:
    compared = conformance(in_air=True, mode=1)
    compared.positions = SimpleNamespace(note=lambda *_: True, words="lost")
    for other, count in ((None, 1), ("a plane", 0)):
        compared.state.other_kind = other
        assert len(list(compared.observe(Position(10.0, 47.4, 8.5, 500.0, 12.0), 0.0))) == count
