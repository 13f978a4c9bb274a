"""What a log lost is said: where it is cut or spoiled, what the numbers of messages leave out, jumps in flight."""

from collections.abc import Callable
from pathlib import Path

import pytest

from ipoa_mission.logs.flight_log import read_flights

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
        ("sitl-ardupilot.bin", lambda data: data.replace(b"PARM", b"PRAM"), "no records PARM: its parameters are unkn"),
        ("sitl-ardupilot.bin", lambda data: data.replace(b"ModeNum", b"ModeMun"), "records MODE do not have"),
        ("sitl-ardupilot.tlog", lambda data: data[:-9], "bytes of the log are no whole messages: it is damaged or cut"),
        ("sitl-ardupilot.tlog", lambda data: data[:4000] + data[6000:], "messages of system 1 are not in the log"),
        ("sitl-ardupilot.tlog", lambda data: data[:8000], "the log ends in flight: the rest of the flight is unknown"),
    ],
)
def test_what_a_log_lost_is_said(tmp_path: Path, name: str, spoil: Spoil, words: str) -> None:
    whole = (LOGS / name).read_bytes()
    path = tmp_path / name
    path.write_bytes(spoil(whole))
    before, after = set(read_flights(LOGS / name).remarks), read_flights(path).remarks
    assert [remark for remark in after if words in remark and remark not in before], after


def test_a_position_that_is_spoiled_is_said(tmp_path: Path) -> None:
    """The latitude of one record is zero."""
    data = (LOGS / "sitl-ardupilot.bin").read_bytes()
    at = data.index(round(47.3977420 * 1e7).to_bytes(4, "little")[2:], 9000) - 2
    path = tmp_path / "spoiled.bin"
    path.write_bytes(data[:at] + bytes(4) + data[at + 4 :])
    assert any("positions jump" in remark for remark in read_flights(path).remarks)
