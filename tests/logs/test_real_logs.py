"""Logs of ArduCopter 4.7.0-dev and PX4 1.17.0 in simulation, and of our own link, trimmed by tools/fly/trim_log.py.

Truth: the autopilots' own records by pymavlink and pyulog; for campus the vehicle's clock beside every report.
"""

from collections.abc import Mapping
from pathlib import Path

import pytest

from ipoa_mission.autopilot.autopilot import Autopilot
from ipoa_mission.autopilot.commands import Command
from ipoa_mission.errors import BadInput
from ipoa_mission.logs.flight_log import LoggedFlight, read_flight, read_flights
from ipoa_mission.mission.flight_record import FlightRecord
from ipoa_mission.mission.items import Mission
from tests.refused import refuses

LOGS = Path(__file__).parents[1] / "logs"
CLOSE = 0.3  # [s]

#: Seconds from arming until items were done; the landing by disarming.
SITL_COPTER = {1: 12.32, 3: 23.01, 4: 37.59, 5: 68.08}
SLOW_COPTER = {1: 11.12, 3: 24.10, 4: 36.07, 5: 48.75, 6: 61.99, 7: 87.01}
TWICE_COPTER = ({1: 11.12, 3: 21.30, 4: 29.36, 5: 54.38}, {1: 11.13, 3: 20.97, 4: 29.56, 5: 54.62})
CAMPUS_COPTER = {2: 14.42, 3: 19.61, 10: 30.02, 20: 53.88, 21: 88.84}
SITL_PX4 = {2: 16.98, 3: 26.42, 4: 33.28, 5: 36.00, 6: 42.14, 7: 66.37}
FLOWN = [
    ("sitl-ardupilot.bin", 0, SITL_COPTER),
    ("sitl-ardupilot.tlog", 0, SITL_COPTER),
    ("n4_slow-ardupilot.bin", 0, SLOW_COPTER),
    ("../../missions/logs/campus-arducopter.tlog", 0, CAMPUS_COPTER),
    ("twice-ardupilot.bin", 0, TWICE_COPTER[0]),
    ("twice-ardupilot.tlog", 0, TWICE_COPTER[0]),
    ("twice-ardupilot.bin", 1, TWICE_COPTER[1]),
    ("twice-ardupilot.tlog", 1, TWICE_COPTER[1]),
    ("sitl-px4.tlog", 0, SITL_PX4),
    ("sitl-px4.ulg", 0, SITL_PX4),
]


def mission_of(name: str) -> Mission:
    mission = read_flights((LOGS / name).with_suffix(".tlog")).flights[0].mission
    assert mission is not None
    return mission


def flight_in(name: str, number: int = 0) -> tuple[LoggedFlight, FlightRecord]:
    flight = read_flights(LOGS / name).flights[number]
    return flight, flight.record(flight.mission or mission_of(name))


@pytest.mark.parametrize(("name", "number", "truth"), FLOWN)
def test_items_and_landing_are_dated_from_the_arming_as_they_were(
    name: str, number: int, truth: Mapping[int, float]
) -> None:
    _, record = flight_in(name, number)
    assert record.completed
    done = {index + 1: time for index, time in record.item_reached_s.items()}
    assert {seq: done[seq] for seq in truth} == pytest.approx(dict(truth), abs=CLOSE)
    assert record.total_s == pytest.approx(max(truth.values()), abs=CLOSE)
    assert sorted(done) == list(range(1, max(truth) + 1)), "take-off, DO items and landing too"
    assert 0 <= record.path[0].time_s < 0.6


@pytest.mark.parametrize(
    ("name", "armed"),
    [
        ("sitl-ardupilot.bin", 201.349),
        ("sitl-ardupilot.tlog", 201.349),  # the first position is heard 0.05 s after it
        ("twice-ardupilot.tlog", 41.660),
        ("sitl-px4.ulg", 173.920),
        ("sitl-px4.tlog", 173.920),
    ],
)
def test_time_zero_is_the_arming_by_the_clock_of_the_vehicle(name: str, armed: float) -> None:
    assert flight_in(name)[0].armed_s == pytest.approx(armed, abs=0.1)


def test_the_clock_goes_back_to_the_arming_as_fast_as_the_vehicle_s(tmp_path: Path) -> None:
    """Ten times as fast as the station's, without TIMESYNC or a position until well after the arming."""
    data = (LOGS / "sitl-ardupilot.tlog").read_bytes()
    path = tmp_path / "late.tlog"
    path.write_bytes(b"".join(record for record in records(data) if not tells_time_before(record, 202.2)))
    assert read_flights(path).flights[0].armed_s == pytest.approx(201.349, abs=CLOSE)


@pytest.mark.parametrize("name", ["sitl-ardupilot.bin", "sitl-ardupilot.tlog", "twice-ardupilot.bin", "sitl-px4.tlog"])
def test_the_log_has_the_mission_that_was_flown(name: str) -> None:
    """In ArduPilot's .tlog it went up as a file, which the .bin of `twice` never lists."""
    mission = flight_in(name)[0].mission
    assert mission is not None
    commands = [Command(item.command).name for item in mission.items]
    assert commands[:3] == ["NAV_TAKEOFF", "DO_CHANGE_SPEED", "NAV_WAYPOINT"]
    assert commands[-1] == "NAV_LAND"
    assert mission.autopilot is (Autopilot.PX4 if "px4" in name else Autopilot.ARDUPILOT)


def test_each_flight_of_a_log_has_its_own_mission_and_home() -> None:
    for name in ("twice-ardupilot.bin", "twice-ardupilot.tlog"):
        log = read_flights(LOGS / name)
        first, second = (flight.mission for flight in log.flights)
        assert first is not None
        assert second is not None
        assert second.items[2].latitude_deg - first.items[2].latitude_deg == pytest.approx(20 / 111_195, rel=0.01)
        assert second.home.longitude_deg - first.home.longitude_deg == pytest.approx(30 / 75_400, rel=0.01)
        (note,) = (remark for remark in log.remarks if "by their numbers" not in remark)
        assert note == "1 time it was armed without flying its mission"  # no position is missing while it was armed


def test_the_log_of_px4_has_no_mission() -> None:
    assert flight_in("sitl-px4.ulg")[0].mission is None


@pytest.mark.parametrize(
    ("name", "parameter", "value"),
    [
        ("sitl-ardupilot.bin", "WPNAV_SPEED", 1000.0),
        ("sitl-px4.ulg", "MPC_XY_CRUISE", 5.0),
        ("sitl-px4.ulg", "RTL_RETURN_ALT", 30.0),
    ],
)
def test_the_log_has_the_parameters_and_the_version(name: str, parameter: str, value: float) -> None:
    log = read_flights(LOGS / name)
    assert log.flights[0].parameters[parameter] == pytest.approx(value)
    assert log.version == ("1.17.0-dev" if "px4" in name else "4.7.0-dev")


def test_items_before_the_one_at_which_it_began_are_not_done() -> None:
    _, record = flight_in("again-px4.tlog")
    assert sorted(record.item_reached_s) == [5, 6]
    assert record.item_reached_s[5] == pytest.approx(42.4, abs=CLOSE)
    assert record.total_s == pytest.approx(65.6, abs=CLOSE)


@pytest.mark.parametrize("name", ["sitl-ardupilot.tlog", "sitl-px4.tlog"])
def test_disarming_is_dated_better_than_the_heartbeat_does(name: str, tmp_path: Path) -> None:
    data = (LOGS / name).read_bytes()
    words = b"Disarming motors" if "ardupilot" in name else b"Disarmed by landing"
    path = tmp_path / name
    path.write_bytes(data[: data.index(words) + 60])
    flight = read_flights(path).flights[0]
    truth = SITL_COPTER[5] if "ardupilot" in name else SITL_PX4[7]
    assert flight.record(flight.mission or mission_of(name)).total_s == pytest.approx(truth, abs=0.15)


def test_torn_records_do_not_spoil_the_clock(tmp_path: Path) -> None:
    data = (LOGS / "twice-ardupilot.tlog").read_bytes()
    path = tmp_path / "torn.tlog"
    path.write_bytes(b"".join(data[at : at + 1900] for at in range(0, len(data), 2000)))
    for flight, truth in zip(read_flights(path).flights, TWICE_COPTER, strict=True):
        assert flight.record(mission_of("twice-ardupilot.tlog")).total_s == pytest.approx(truth[5], abs=1.0)


def test_a_log_that_begins_in_flight_says_so(tmp_path: Path) -> None:
    data = (LOGS / "twice-ardupilot.tlog").read_bytes()
    path = tmp_path / "late.tlog"
    path.write_bytes(data[len(data) // 4 :])
    log = read_flights(path)
    assert len(log.flights) == 1
    assert log.flights[0].armed_s == pytest.approx(105.28, abs=0.1)
    assert any("the log begins in flight" in remark for remark in log.remarks)
    path.write_bytes(data[len(data) // 4 : len(data) // 2 - 2000])
    with refuses("nothing-flown", "late.tlog"):
        read_flights(path)


def test_a_log_of_another_autopilot_or_vehicle_is_refused(tmp_path: Path) -> None:
    with refuses("other-autopilot", "sitl-ardupilot.bin", "PX4"):
        read_flight(LOGS / "sitl-ardupilot.bin", mission_of("sitl-px4.tlog"))
    path = tmp_path / "plane.bin"
    path.write_bytes((LOGS / "sitl-ardupilot.bin").read_bytes().replace(b"ArduCopter V4.7", b"ArduPlane V4.71"))
    with refuses("other-vehicle", "plane.bin", kind=BadInput):
        read_flights(path)


@pytest.mark.parametrize("rest", [bytes(20_000_000), b"\xa3\x95\x80" * 700_000, b"\xa3\x95" * 1_000_000])
def test_megabytes_of_nothing_in_a_dataflash_log_end_soon(rest: bytes, tmp_path: Path) -> None:
    path = tmp_path / "nothing.bin"
    path.write_bytes((LOGS / "sitl-ardupilot.bin").read_bytes()[:3000] + rest)
    with refuses("log-incomplete", "nothing.bin", kind=BadInput):
        read_flights(path)


def records(data: bytes) -> list[bytes]:
    """The records of an unbroken .tlog of MAVLink 2."""
    frames, at = [], 0
    while at < len(data):
        length = 8 + 12 + data[at + 9] + (13 if data[at + 10] & 1 else 0)
        frames.append(data[at : at + length])
        at += length
    return frames


def tells_time_before(record: bytes, time: float) -> bool:
    number = int.from_bytes(record[15:18], "little")
    return number == 111 or (number == 33 and int.from_bytes(record[18:22], "little") < time * 1000)
