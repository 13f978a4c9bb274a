import struct
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from ipoa_mission.autopilot.autopilot import Autopilot
from ipoa_mission.errors import MissionError
from ipoa_mission.geodesy import Geodetic, LocalFrame
from ipoa_mission.link.messages import Heartbeat
from ipoa_mission.logs.flight_log import read_flight, read_flights
from ipoa_mission.mission.items import Mission, change_speed, land, takeoff, waypoint
from ipoa_mission.simulator.fly import fly_built_in
from tests.examples import vehicles
from tests.logs.log_writers import WRITERS, Flown, write_dataflash, write_ulog
from tests.refused import refuses

HOME = Geodetic(47.397742, 8.545594, 488.0)
FRAME = LocalFrame(HOME)


@pytest.fixture
def flown() -> Flown:
    """Up 20 m, 100 m north at 5 m/s, 40 m east, down: five items."""
    corners = np.array([(0, 0, 0), (0, 0, 20), (0, 100, 20), (40, 100, 20), (40, 100, 0)], float)
    at = np.array([0.0, 8.0, 28.0, 38.0, 60.0])
    times = np.arange(-1.0, 62.0, 0.1)
    local = np.column_stack([np.interp(times, at, axis) for axis in corners.T])
    east, north, up = np.gradient(local, times, axis=0).T
    latitude, longitude, _ = FRAME.to_geodetic(local)
    return Flown(
        times=times,
        latitude_deg=latitude,
        longitude_deg=longitude,
        height=local[:, 2],
        velocity=np.column_stack([north, east, -up]),
        home_altitude=HOME.altitude,
        done={0: 8.0, 1: 8.0, 2: 28.0, 3: 38.0},
        landed_s=61.2,
    )


def mission_for(autopilot: Autopilot) -> Mission:
    a, b = (FRAME.geodetic(np.array(point)) for point in ((0.0, 100.0, 20.0), (40.0, 100.0, 20.0)))
    items = (takeoff(HOME, 20.0), change_speed(5.0), waypoint(a, 20.0), waypoint(b, 20.0), land(b))
    return Mission(HOME, items, autopilot)


def read(name: str, flown: Flown, folder: Path):  # type: ignore[no-untyped-def]
    path = folder / name
    WRITERS[name](flown, path)
    return read_flight(path, mission_for(Autopilot.ARDUPILOT if name.startswith("ardupilot") else Autopilot.PX4))


@pytest.mark.parametrize("name", WRITERS)
def test_items_are_done_when_they_were(name: str, flown: Flown, tmp_path: Path) -> None:
    flight = read(name, flown, tmp_path)
    assert flight.item_reached_s == pytest.approx({**flown.done, 4: flown.landed_s}, abs=0.002)
    assert flight.completed
    assert flight.total_s == pytest.approx(flown.landed_s, abs=0.002)
    assert "Takeoff" in flight.messages


@pytest.mark.parametrize("name", WRITERS)
def test_the_path_is_where_it_was(name: str, flown: Flown, tmp_path: Path) -> None:
    flight = read(name, flown, tmp_path)
    times = np.array([sample.time_s for sample in flight.path])
    assert (np.diff(times) >= 0).all()
    assert times[-1] == pytest.approx(flown.landed_s, abs=0.2)
    for key, close in (("latitude_deg", 1.1e-7), ("longitude_deg", 1.1e-7), ("height", 2e-3)):
        want = np.interp(times, flown.times, getattr(flown, key))
        assert np.abs(np.array([getattr(sample, key) for sample in flight.path]) - want).max() < close
    speed = np.array([sample.speed for sample in flight.path])
    cruising = (times > 10) & (times < 27)
    assert speed[cruising] == pytest.approx(5.0, abs=0.02)


def test_velocity_without_an_estimate_is_that_of_positions(flown: Flown, tmp_path: Path) -> None:
    path = tmp_path / "old.bin"
    write_dataflash(flown, path)
    path.write_bytes(path.read_bytes().replace(b"XKF1", b"XKFX"))
    flight = read_flight(str(path), mission_for(Autopilot.ARDUPILOT))
    cruising = [sample.speed for sample in flight.path if 10 < sample.time_s < 27]
    assert np.median(cruising) == pytest.approx(5.0, abs=0.1)


def test_remarks_on_a_log_come_with_its_flight(flown: Flown, tmp_path: Path) -> None:
    path = tmp_path / "damaged.bin"
    write_dataflash(flown, path)
    path.write_bytes(path.read_bytes() + b"no record")
    flight = read_flight(path, mission_for(Autopilot.ARDUPILOT))
    assert "9 bytes of the log are not whole records: it is damaged or truncated" in flight.remarks


def test_a_log_of_another_mode_is_no_flight_of_the_mission(flown: Flown, tmp_path: Path) -> None:
    path = tmp_path / "loiter.ulg"
    write_ulog(flown, path)
    data = path.read_bytes().replace(struct.pack("<QBB", 100_000_000, 2, 3), struct.pack("<QBB", 100_000_000, 2, 4))
    path.write_bytes(data)
    with refuses("nothing-flown", "loiter.ulg", "PX4"):
        read_flight(path, mission_for(Autopilot.PX4))


@pytest.mark.parametrize("suffix", ["tlog", "bin", "ulg"])
@pytest.mark.parametrize(
    "content", [b"", b"hello", bytes(5000), b"\xa3\x95\x80" * 400, b"ULog\x01\x12\x35\x01" + bytes(30)]
)
def test_files_that_are_no_log_are_refused_in_words(suffix: str, content: bytes, tmp_path: Path) -> None:
    path = tmp_path / f"broken.{suffix}"
    path.write_bytes(content)
    with pytest.raises(MissionError) as refused:
        read_flight(path, mission_for(Autopilot.PX4))
    assert (refused.value.place or "").startswith(str(path))


def test_a_file_that_is_not_there_or_of_another_kind_is_bad_input(tmp_path: Path) -> None:
    for name in ("absent.tlog", "absent.bin", "absent.ulg", "flight.csv"):
        with refuses("wrong-suffix" if name == "flight.csv" else "unreadable", name):
            read_flight(tmp_path / name, mission_for(Autopilot.PX4))


@pytest.mark.parametrize("name", ["ardupilot.bin", "px4.ulg", "px4.tlog"])
@pytest.mark.parametrize("share", [0.3, 0.7])
def test_a_log_that_breaks_off_gives_what_is_in_it(name: str, share: float, flown: Flown, tmp_path: Path) -> None:
    whole = tmp_path / name
    WRITERS[name](flown, whole)
    data = whole.read_bytes()
    whole.write_bytes(data[: int(share * len(data))])
    flight = read_flight(whole, mission_for(Autopilot.ARDUPILOT if name.startswith("ardupilot") else Autopilot.PX4))
    assert not flight.completed
    assert flight.item_reached_s.items() <= {k: pytest.approx(v, abs=0.002) for k, v in flown.done.items()}.items()


@pytest.mark.parametrize("autopilot", vehicles(Autopilot.ARDUPILOT))
def test_the_log_of_a_flight_on_the_built_in_autopilot_tells_that_flight(autopilot: Autopilot, tmp_path: Path) -> None:
    log = tmp_path / "flight.tlog"
    mission = mission_for(autopilot)
    seen = fly_built_in(mission, log=log)
    logged = read_flight(log, mission)
    assert logged.completed
    assert logged.item_reached_s == pytest.approx(seen.item_reached_s, abs=0.11)  # positions come ten times a second
    assert logged.total_s == pytest.approx(seen.total_s, abs=0.11)
    last = logged.path[-1]
    assert (last.latitude_deg, last.longitude_deg) == pytest.approx(
        (seen.path[-1].latitude_deg, seen.path[-1].longitude_deg), abs=2e-7
    )


@pytest.mark.parametrize("disarmed", [0.0, 1.0])
def test_a_log_that_begins_armed_has_a_flight_only_if_arming_opened_it(
    disarmed: float, flown: Flown, tmp_path: Path
) -> None:
    path = tmp_path / "armed.bin"
    write_dataflash(flown, path)
    armed = b"\xa3\x95" + struct.pack("<BQBIBB", 14, 100_000_000, 1, 0xFFFF, 0, 0)
    definition = struct.pack("<BBB4s16s64s", 128, 20, 31, b"PARM", b"QNf", b"TimeUS,Name,Value")
    setting = struct.pack("<BQ16sf", 20, 98_000_000, b"LOG_DISARMED", disarmed)
    data = path.read_bytes()
    assert data.count(armed) == 1
    path.write_bytes(data.replace(armed, b"") + b"\xa3\x95" + definition + b"\xa3\x95" + setting)
    if disarmed:
        with refuses("nothing-flown", "armed.bin"):
            read_flights(path)
    else:
        (flight,) = read_flights(path).flights
        assert flight.armed_s == pytest.approx(97.0)  # the log's first record


@pytest.mark.parametrize("name", ["sitl-ardupilot.bin", "sitl-px4.tlog"])
def test_places_in_the_mission_mode_are_part_of_all_places(name: str) -> None:
    (flight, *_) = read_flights(Path(__file__).parent / name).flights
    whole, in_mission = flight.record().path, flight.flown_in_mission()
    assert 0.5 * len(whole) < len(in_mission) <= len(whole)
    there = {(sample.latitude_deg, sample.longitude_deg, sample.height) for sample in whole}
    assert set(in_mission) <= there
    without_heartbeats = replace(flight, messages=tuple(m for m in flight.messages if not isinstance(m, Heartbeat)))
    assert not without_heartbeats.flown_in_mission()  # nobody says in which mode it flew
