import sys
from collections.abc import Callable
from contextlib import closing
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pymavlink.dialects.v20 import ardupilotmega as dialect

from ipoa_mission.autopilot.autopilot import Autopilot
from ipoa_mission.errors import BadInput
from ipoa_mission.link.codec import EVERYONE, Codec, Target, TlogWriter
from ipoa_mission.link.messages import (
    ARMED_FLAG,
    CommandAck,
    CommandLong,
    CommandResult,
    Count,
    Heartbeat,
    ItemAt,
    Message,
    ParamValue,
    Position,
    Reached,
    SystemTime,
    Text,
)
from ipoa_mission.logs.flight_log import read_flights
from ipoa_mission.logs.logged import Log, messages_of
from ipoa_mission.logs.telemetry_log import read_telemetry_log, unwrapped, vehicle_times
from ipoa_mission.mission.items import Item
from ipoa_mission.vehicles.px4_multicopter import log as ulog
from tests.refused import refuses

LOG = Path(__file__).parents[1] / "logs" / "sitl-px4.ulg"
Break = Callable[[dict[str, Any]], None]


def spoiled(monkeypatch: pytest.MonkeyPatch, spoil: Break) -> None:
    """Change a log's topics by name."""
    opened = ulog._open

    def broken(path: Path) -> object:
        log = opened(path)
        topics = {topic.name: topic for topic in log.data_list}
        spoil(topics)
        log.data_list[:] = list(topics.values())
        return log

    monkeypatch.setattr(ulog, "_open", broken)


def without(*names: str) -> Break:
    def spoil(topics: dict[str, Any]) -> None:
        for name in names:
            topics.pop(name, None)

    return spoil


def column(topic: str, name: str, value: float) -> Break:
    def spoil(topics: dict[str, Any]) -> None:
        data = topics[topic].data
        data[name] = np.full(len(data["timestamp"]), value)

    return spoil


@pytest.mark.parametrize(
    ("spoil", "words"),
    [
        (without("vehicle_status"), ("log-incomplete", "sitl-px4.ulg", "PX4", "vehicle_status")),
        (without(ulog.POSITION), ("log-incomplete", "sitl-px4.ulg", "PX4", "vehicle_global_position")),
        (column("vehicle_status", "vehicle_type", 2.0), ("other-vehicle", "sitl-px4.ulg")),
    ],
)
def test_missing_topics_of_a_px4_log_are_named(
    monkeypatch: pytest.MonkeyPatch, spoil: Break, words: tuple[str, ...]
) -> None:
    spoiled(monkeypatch, spoil)
    with refuses(*words):
        read_flights(LOG)


def test_places_remain_without_home_velocity_and_results(monkeypatch: pytest.MonkeyPatch) -> None:
    whole = read_flights(LOG).flights[0].record().path
    spoiled(monkeypatch, without("home_position", "vehicle_local_position", "mission_result"))
    bare = ulog.read_ulog(LOG)
    assert bare.fixes[0, 4] == 0.0
    assert not bare.fixes[:, 5:].any()
    assert bare.fixes[-1, 1] == pytest.approx(whole[-1].latitude_deg, abs=1e-4)


def test_a_log_that_its_reader_stumbles_over_and_no_reader_are_errors(monkeypatch: pytest.MonkeyPatch) -> None:
    pyulog = pytest.importorskip("pyulog")

    def stumble(*_: object) -> None:
        raise IndexError("index out of range")

    monkeypatch.setattr(pyulog, "ULog", stumble)
    with refuses("wrong-format", "sitl-px4.ulg", "PX4"):
        read_flights(LOG)
    monkeypatch.setitem(sys.modules, "pyulog", None)
    with refuses("package-missing") as missing:
        read_flights(LOG)
    assert missing.value.hint == "pip install 'ipoa-mission[logs]'"


def heartbeat(armed: bool, kind: int = 2) -> Heartbeat:
    return Heartbeat(kind, Autopilot.PX4.mav_autopilot, (ARMED_FLAG if armed else 0) | 1, 4 << 16 | 4 << 24)


def written(folder: Path, *messages: tuple[float, Message]) -> Path:
    """Write a log of a vehicle's messages at these times."""
    path = folder / "said.tlog"
    vehicle, station = Codec(1, 1), Codec(245, 190)
    with closing(TlogWriter(path)) as log:
        for at, message in messages:
            codec = station if isinstance(message, CommandLong) else vehicle
            log.write(codec.encode(message, EVERYONE, 1.8e9 + at), 1.8e9 + at)
    return path


def states(path: Path) -> list[bool]:
    return [event.armed for _, event in read_telemetry_log(path).events if isinstance(event, Heartbeat)]


def test_log_messages_before_the_first_heartbeat_are_ignored(tmp_path: Path) -> None:
    path = written(
        tmp_path, (0.0, Text(6, "early")), (1.0, heartbeat(False)), (2.0, ParamValue("MC_ROLL_P", 6.5, 9, 1, 0))
    )
    unread = dialect.MAVLink_meminfo_message(0, 0).pack(dialect.MAVLink(None, 1, 1))
    with path.open("ab") as log:
        log.write((1_800_000_003_000_000).to_bytes(8, "big") + unread)
        log.write((1_800_000_003_000_000).to_bytes(8, "big") + b"\xfd\x03\x00\x00\x00\x01\x01\xff\xff\xffabc\x00\x00")
    events = [event for _, event in read_telemetry_log(path).events]
    assert not [event for event in events if isinstance(event, Text)]
    assert [event.param_value for event in events if isinstance(event, ParamValue)] == [6.5]


def test_a_log_of_no_multicopter_is_refused(tmp_path: Path) -> None:
    with refuses("other-vehicle", "said.tlog", "PX4", kind=BadInput):
        read_telemetry_log(written(tmp_path, (0.0, heartbeat(False, kind=1))))


def test_arming_that_two_heartbeats_know_nothing_of_did_not_happen(tmp_path: Path) -> None:
    path = written(
        tmp_path,
        (0.0, heartbeat(False)),
        (0.5, CommandLong(400, (1.0, *(0.0,) * 6))),
        (0.6, CommandAck(400, CommandResult.ACCEPTED)),
        (1.0, heartbeat(False)),
        (2.0, heartbeat(False)),
        (3.0, heartbeat(True)),
    )
    assert states(path) == [False, True]


def test_arming_that_is_told_of_before_the_first_heartbeat_was_a_change(tmp_path: Path) -> None:
    path = written(tmp_path, (0.0, heartbeat(False)), (1.0, Text(6, "Disarmed")), (2.0, heartbeat(False)))
    assert states(path) == [False]


def test_events_without_positions_are_told_by_time_alone() -> None:
    log = Log(Autopilot.PX4, np.empty((0, 8)), ((2.0, Text(6, "armed")),), "")
    assert list(messages_of(log)) == [SystemTime(0.0, 2.0), Text(6, "armed")]


def test_a_clock_reported_rarely_runs_at_its_mean_rate_over_the_log() -> None:
    stamps, at, clock = np.array([0.0, 50.0, 100.0]), np.array([10.0, 90.0]), np.array([5.0, 165.0])
    assert vehicle_times(stamps, at, clock) == pytest.approx([-15.0, 85.0, 185.0])
    assert vehicle_times(stamps, at[:1], clock[:1]) == pytest.approx([-5.0, 45.0, 95.0])
    assert vehicle_times(stamps, at[:0], clock[:0]) is stamps


def test_a_log_that_began_anew_twice_at_once_goes_on_over_both() -> None:
    stamps = np.array([0.0, 1.0, 2.0, 3.0])
    assert unwrapped(stamps, np.array([100.0, 60.0, 20.0, 21.0])) == pytest.approx([100.0, 101.0, 102.0, 103.0])


def test_arming_is_dated_by_its_acknowledgement(tmp_path: Path) -> None:
    order, agreed = CommandLong(400, (1.0, *(0.0,) * 6)), CommandAck(400, CommandResult.ACCEPTED)
    place = Position(5.0, 47.4, 8.5, 420.0, 20.0, (0.0, 0.0, 0.0))
    path = written(tmp_path, (0.0, heartbeat(False)), (0.5, order), (0.6, agreed), (0.7, place), (1.0, heartbeat(True)))
    stray = Codec(245, 190).encode(CommandLong(400, (0.0,) * 7), Target(9, 1), 1.8e9 + 2.0)
    with path.open("ab") as log:
        log.write(round((1.8e9 + 2.0) * 1e6).to_bytes(8, "big") + stray)
    events = [(at, event.armed) for at, event in read_telemetry_log(path).events if isinstance(event, Heartbeat)]
    assert [armed for _, armed in events] == [False, True, True]  # agreed to, and shown
    assert events[1][0] - events[0][0] == pytest.approx(0.6, abs=0.01)


def begun_armed(is_reported: bool) -> Break:
    """The first state is armed; `is_reported`: with the time of the arming."""

    def spoil(topics: dict[str, Any]) -> None:
        status = topics["vehicle_status"].data
        first = int(np.argmax(status["arming_state"] == ulog.ARMED))
        status.update({name: values[first:] for name, values in status.items()})
        if not is_reported:
            del status["armed_time"]

    return spoil


def opened_by_arming(folder: Path) -> Path:
    """The log with SDLOG_MODE 0."""
    path = folder / "armed.ulg"
    path.write_bytes(LOG.read_bytes().replace(b"SDLOG_MODE\x01", b"SDLOG_MODE\x00"))
    return path


def test_px4_log_that_begins_armed_has_an_arming_time(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    armed_s = read_flights(LOG).flights[0].armed_s
    with monkeypatch.context() as patch:
        spoiled(patch, begun_armed(is_reported=True))
        assert [flight.armed_s for flight in read_flights(LOG).flights] == [armed_s]
    spoiled(monkeypatch, begun_armed(is_reported=False))
    begins_s = ulog._open(LOG).start_timestamp / 1e6
    assert [flight.armed_s for flight in read_flights(opened_by_arming(tmp_path)).flights] == [begins_s]
    with refuses("nothing-flown", "sitl-px4.ulg"):
        read_flights(LOG)


def test_a_flight_without_positions_has_no_home_and_so_no_mission(tmp_path: Path) -> None:
    item = Item(16, 3, latitude_deg=47.4, longitude_deg=8.5, altitude=10.0)
    messages = (heartbeat(False), Count(1), ItemAt(0, item), heartbeat(True), Reached(0))
    path = written(tmp_path, *((float(at), message) for at, message in enumerate(messages)))
    (flight,) = read_flights(path).flights
    assert flight.in_mission
    assert flight.mission is None
    assert flight.record().path == ()
