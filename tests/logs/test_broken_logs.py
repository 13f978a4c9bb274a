from pathlib import Path
from typing import Any

import numpy as np
import pytest

from ipoa_mission.autopilot.autopilot import Autopilot
from ipoa_mission.geodesy import Geodetic
from ipoa_mission.logs.flight_log import _Known, _Stretch, read_flights
from ipoa_mission.logs.logged import Begun
from ipoa_mission.mission.items import waypoint
from ipoa_mission.mission.stored_mission import home_item
from ipoa_mission.vehicles.arducopter.log import _differences
from ipoa_mission.vehicles.px4_multicopter import log as ulog
from tests.refused import refuses

HOME = Geodetic(47.397742, 8.545594, 488.0)

LOG = Path(__file__).parents[1] / "logs" / "sitl-px4.ulg"


def test_a_parameter_that_is_no_number_is_passed_over(monkeypatch: pytest.MonkeyPatch) -> None:
    opened = ulog._open

    def broken(path: Path) -> object:
        log = opened(path)
        log.initial_parameters["MC_ROLL_P"] = b""
        return log

    sound = read_flights(LOG).flights[0].parameters
    monkeypatch.setattr(ulog, "_open", broken)
    assert read_flights(LOG).flights[0].parameters == {k: v for k, v in sound.items() if k != "MC_ROLL_P"}


def test_a_topic_without_its_columns_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    opened = ulog._open

    def broken(path: Path) -> object:
        log = opened(path)
        for topic in log.data_list:
            topic.data.pop("nav_state", None)
        return log

    monkeypatch.setattr(ulog, "_open", broken)
    with refuses("wrong-format", "sitl-px4.ulg", "PX4", "'nav_state'"):
        read_flights(LOG)


def test_speeds_that_are_no_numbers_are_passed_over(monkeypatch: pytest.MonkeyPatch) -> None:
    whole = ulog._open

    def broken(path: Path) -> Any:
        log = whole(path)
        for topic in log.data_list:
            if topic.name == "vehicle_local_position":
                topic.data["vx"] = np.where(np.arange(len(topic.data["vx"])) % 2, np.inf, topic.data["vx"])
                topic.data["vy"] = np.full(len(topic.data["vy"]), 0x7FA00000, "u4").view("f4")  # NaNs that signal
        return log

    sound = [sample.speed for sample in read_flights(LOG).flights[0].record().path]
    monkeypatch.setattr(ulog, "_open", broken)
    speeds = [sample.speed for sample in read_flights(LOG).flights[0].record().path]
    assert np.isfinite(speeds).all()
    assert 0.0 < max(speeds) <= max(sound) + 0.1


def test_places_off_the_earth_have_no_speed() -> None:
    latitude = np.array([47.0, 47.00001, 4700.0, 47.00003, 47.00004])
    speeds = _differences(np.arange(5.0), latitude, np.full(5, 8.0), np.full(5, 500.0))
    assert speeds[:, 0] == pytest.approx([1.11, 1.11, 0.0, 1.11, 1.11], rel=0.01)
    one_place = np.array([47.0, 4700.0, 4700.0, 4700.0, 4700.0])
    assert not _differences(np.arange(5.0), one_place, np.full(5, 8.0), np.full(5, 500.0)).any()


def test_a_record_of_arducopter_without_its_fields_is_passed_over(tmp_path: Path) -> None:
    sound = LOG.with_name("sitl-ardupilot.bin")
    broken = tmp_path / "broken.bin"
    broken.write_bytes(sound.read_bytes().replace(b"Prm1", b"PrmX"))
    assert broken.read_bytes() != sound.read_bytes()
    assert len(read_flights(broken).flights) == len(read_flights(sound).flights)


def test_definitions_that_break_off_are_refused_at_once(tmp_path: Path) -> None:
    """pyulog looks for their end without one."""
    broken = tmp_path / "broken.ulg"
    broken.write_bytes(LOG.read_bytes()[:16] + b"\xff\xff\x00" * 100)
    with refuses("wrong-format", "broken.ulg"):
        read_flights(broken)


def test_an_item_beyond_the_list_that_was_held_is_not_looked_for_in_it() -> None:
    """A damaged record names item 7 of a list of three."""
    items = (home_item(HOME), waypoint(HOME, 20.0), waypoint(HOME, 30.0))
    known = _Known(items, HOME)
    stretch = _Stretch(True, 0.0, known, [], begun={7: Begun(7, 3, items[1])})
    assert stretch._mission(Autopilot.ARDUPILOT) is None
    stretch.begun = {1: Begun(1, 3, items[1]), 2: Begun(2, 3, items[2])}
    mission = stretch._mission(Autopilot.ARDUPILOT)
    assert mission is not None
    assert len(mission.items) == 2
