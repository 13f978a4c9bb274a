"""Logs that are broken inside: what a fuzzer found."""

from pathlib import Path

import pytest

from ipoa_mission.errors import BadInput
from ipoa_mission.link import ulog
from ipoa_mission.link.flight_log import read_flights

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
    with pytest.raises(BadInput, match="cannot be read as a PX4 log: 'nav_state'"):
        read_flights(LOG)


def test_a_record_of_arducopter_without_its_fields_is_passed_over(tmp_path: Path) -> None:
    sound = LOG.with_name("sitl-ardupilot.bin")
    broken = tmp_path / "broken.bin"
    broken.write_bytes(sound.read_bytes().replace(b"Prm1", b"PrmX"))
    assert broken.read_bytes() != sound.read_bytes()
    assert len(read_flights(broken).flights) == len(read_flights(sound).flights)
