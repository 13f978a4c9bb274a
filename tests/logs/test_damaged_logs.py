import struct
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace

import pytest

from ipoa_mission.logs.flight_log import LoggedFlight, read_flights
from ipoa_mission.vehicles.arducopter.log import read_records
from ipoa_mission.vehicles.px4_multicopter import log as px4_log

LOGS = Path(__file__).parents[1] / "logs"
Spoil = Callable[[bytes], bytes]


@pytest.mark.parametrize(
    ("name", "spoil", "words"),
    [
        ("sitl-px4.ulg", lambda data: data[:-9], "the log is damaged or truncated from byte 46"),
        ("sitl-px4.ulg", lambda data: data[:45000] + data[45300:], "the log is damaged"),
        ("sitl-px4.ulg", lambda data: data.replace(b"mission_result", b"mission_rseult"), "no topics mission_result"),
        (
            "sitl-ardupilot.bin",
            lambda data: data[:-9],
            "bytes of the log are not whole records: it is damaged or trunc",
        ),
        ("sitl-ardupilot.bin", lambda data: data[:9000] + bytes(300) + data[9300:], "bytes of the log are not whole"),
        ("sitl-ardupilot.bin", lambda data: data[:12000], "the log ends in flight"),
        # holes at whose end another record begins: no byte is left over
        ("sitl-ardupilot.bin", lambda data: data[:2953] + data[4953:], "positions are missing 1 time in flight, for 8"),
        ("sitl-ardupilot.bin", lambda data: data[:1467] + data[3467:], "the log does not name its firmware"),
        ("twice-ardupilot.bin", lambda data: data[:3611] + data[5611:], "positions are missing 1 time in flight, for"),
        ("twice-ardupilot.bin", lambda data: data[:3132] + data[4132:], "the log lacks 1 change of arming, the first"),
        ("sitl-ardupilot.bin", lambda data: data.replace(b"PARM", b"PRAM"), "no records PARM: its parameters are unkn"),
        ("sitl-ardupilot.bin", lambda data: data.replace(b"ModeNum", b"ModeMun"), "records MODE do not have"),
        ("sitl-ardupilot.tlog", lambda data: data + b"\0", "1 byte of the log in no whole message"),
        ("sitl-ardupilot.tlog", lambda data: data[:-9], "bytes of the log in no whole message: it is damaged or cut"),
        ("sitl-ardupilot.tlog", lambda data: data[:4000] + data[6000:], "messages of system 1 are not in the log"),
        ("sitl-ardupilot.tlog", lambda data: data[:8000], "the log ends in flight: the rest of the flight is unknown"),
    ],
)
def test_losses_of_a_log_are_remarked(tmp_path: Path, name: str, spoil: Spoil, words: str) -> None:
    whole = (LOGS / name).read_bytes()
    path = tmp_path / name
    path.write_bytes(spoil(whole))
    before, after = set(read_flights(LOGS / name).remarks), read_flights(path).remarks
    assert [remark for remark in after if words in remark and remark not in before], after


def test_a_position_that_is_spoiled_is_said(tmp_path: Path) -> None:
    data = (LOGS / "sitl-ardupilot.bin").read_bytes()
    at = data.index(round(47.3977420 * 1e7).to_bytes(4, "little")[2:], 9000) - 2
    path = tmp_path / "spoiled.bin"
    path.write_bytes(data[:at] + bytes(4) + data[at + 4 :])
    assert any("positions jump 2 times, as" in remark for remark in read_flights(path).remarks)


def test_a_ulog_with_corruption_or_dropouts_is_named(tmp_path: Path) -> None:
    path = tmp_path / "a.ulg"
    path.write_bytes(bytes(px4_log.HEADER))
    ulog = SimpleNamespace(
        file_corruption=True, dropouts=[SimpleNamespace(duration=1500)] * 2, initial_parameters={"A": 1.0}
    )
    remarks = list(px4_log._remarks(path, ulog, {"mission_result", "home_position", *px4_log.TOPICS}))
    assert remarks[:2] == ["the log is damaged", "PX4 lost log data 2 times, 3.0 s in all"]


def test_records_of_another_layout_are_counted(tmp_path: Path) -> None:
    path, torn = tmp_path / "a.bin", Counter[str]()
    path.write_bytes(struct.pack("<2sBBB4s16s64s", b"\xa3\x95", 128, 129, 10, b"GPS", b"BI", b"Status,TimeUS"))
    assert list(read_records(path, frozenset({"GPS"}), torn)) == []
    assert torn["GPS"] == 1


def test_a_version_that_cannot_be_read_is_none() -> None:
    flight = LoggedFlight.__new__(LoggedFlight)
    object.__setattr__(flight, "version", "nonsense")
    assert flight.firmware_version is None
