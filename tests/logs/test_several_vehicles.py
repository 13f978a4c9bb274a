from pathlib import Path

import pytest

from ipoa_mission.errors import BadInput
from ipoa_mission.learn.fit import flights_in
from ipoa_mission.logs.flight_log import read_flights
from tests.logs.several import write_several
from tests.refused import refuses

LOGS = Path(__file__).parents[1] / "logs"
FIRST, OTHER = LOGS / "sitl-ardupilot.tlog", LOGS / "twice-ardupilot.tlog"
OTHERS = "the log holds {} vehicles: read is system {}, not read "


def flown(path: Path, system: int | None = None) -> list[float]:
    return [round(flight.record(flight.mission).total_s, 1) for flight in read_flights(path, system).flights]


def test_the_first_multicopter_is_read_and_the_others_are_listed(tmp_path: Path) -> None:
    path = write_several(tmp_path / "two.tlog", FIRST, {7: OTHER})
    assert flown(path) == flown(FIRST)
    words = OTHERS.format(2, 1) + "7 (ArduPilot multicopter); --system 7 reads another"
    assert words in read_flights(path).remarks
    assert not any("vehicles" in remark for remark in read_flights(FIRST).remarks)


def test_a_system_id_chooses(tmp_path: Path) -> None:
    path = write_several(tmp_path / "two.tlog", FIRST, {7: OTHER})
    alone = write_several(tmp_path / "alone.tlog", FIRST, {})
    assert len(read_flights(path, 7).flights) == len(read_flights(OTHER).flights) == 2
    assert [flight.record().total_s for flight in read_flights(path, 7).flights] == pytest.approx(
        [flight.record().total_s for flight in read_flights(OTHER).flights], abs=0.3
    )
    assert flown(path, 1) == flown(alone, 1) == flown(FIRST)
    with refuses("other-vehicle", "two.tlog", "system 9", "1 (ArduPilot multicopter), 7", kind=BadInput):
        read_flights(path, 9)
    with refuses("other-vehicle", "sitl-ardupilot.bin", "system 2", kind=BadInput):
        read_flights(LOGS / "sitl-ardupilot.bin", 2)
    _, left_out, _, _ = flights_in(path)
    assert any(words.startswith(OTHERS.format(2, 1)) for words in left_out)


def test_a_plane_heard_first_refuses_no_log(tmp_path: Path) -> None:
    path = write_several(tmp_path / "plane.tlog", FIRST, {}, plane_first=3)
    assert flown(path) == flown(FIRST)
    assert OTHERS.format(2, 1) + "3 (ArduPilot plane)" in read_flights(path).remarks
    with refuses("other-vehicle", "plane.tlog", "ArduPilot plane", "1 (ArduPilot multicopter), 3", kind=BadInput):
        read_flights(path, 3)


def test_three_vehicles_of_two_firmwares(tmp_path: Path) -> None:
    path = write_several(tmp_path / "three.tlog", FIRST, {5: LOGS / "sitl-px4.tlog"}, plane_first=3)
    assert read_flights(path).autopilot.name == "ardupilot"
    px4 = read_flights(path, 5)
    assert px4.autopilot.name == "px4"
    assert [flight.record().total_s for flight in px4.flights] == pytest.approx([66.37], abs=0.4)
    assert px4.remarks[0].startswith(OTHERS.format(3, 5) + "1 (ArduPilot multicopter), 3 (ArduPilot plane)")
