"""Chunks of STATUSTEXT, as PX4 1.18 and ArduCopter 4.8 send them.

PX4 numbers all texts, and ends none of exactly 50 bytes; ArduPilot numbers long ones, and ends each.
"""

from collections.abc import Sequence
from pathlib import Path

import pytest

from ipoa_mission.autopilot.autopilot import Autopilot
from ipoa_mission.link.codec import Codec, LongTexts, Target
from ipoa_mission.link.connection import Connection
from ipoa_mission.link.definitions import definition_of
from ipoa_mission.link.messages import Heartbeat, Message, Text
from ipoa_mission.logs.telemetry_log import read_telemetry_log
from ipoa_mission.simulator.built_in_autopilot import BuiltInAutopilot
from ipoa_mission.simulator.station import Loopback, Station
from tests.link.test_conformance import HOME
from tests.link_pair import far_end

RETURN = "RTL: start return at 570 m (82 m above destination)\t"
LONG = f"PreArm: {'x' * 42}{'y' * 50}{'z' * 9}"
UNSAFE = "Preflight Fail: Vehicle is in safety configuration"  # of 50 bytes, as recorded
BEAT = Heartbeat(2, 12)


def chunks(text: str, number: int, ends: bool = True) -> list[bytes]:
    raw = text.encode() + b"\0" * ends
    return [
        definition_of("STATUSTEXT").pack({"severity": 4, "text": raw[at : at + 50], "id": number, "chunk_seq": n})
        for n, at in enumerate(range(0, len(raw), 50))
    ]


def heard(sent: Sequence[bytes | Heartbeat | None], *, seconds: float = 0.01, system: int = 1) -> list[str]:
    """None is a lost frame."""
    sender = Codec(system, 1)
    texts = LongTexts()
    got = list[str]()
    for n, each in enumerate(sent):
        if each is None or isinstance(each, Heartbeat):
            frame = sender.encode(BEAT, Target(0, 0), 0.0)
        else:
            frame = sender.frame(definition_of("STATUSTEXT"), each, 0.0)
        decoded = Codec(245, 190).decode(frame)
        assert decoded is not None
        joined = texts.joined([] if each is None else [decoded], seconds * n)
        got += [one.message.text for one in joined if isinstance(one.message, Text)]
    return got


def test_chunks_of_a_text_are_one_text() -> None:
    assert heard(chunks(RETURN, 9)) == [RETURN]
    assert heard([*chunks(LONG, 0xFFFF), *chunks(RETURN, 1)]) == [LONG, RETURN]
    first, last = chunks(RETURN, 9)
    assert heard([first, BEAT, last]) == [RETURN]  # a full buffer parts them


def test_letter_that_two_chunks_share_is_whole() -> None:
    assert heard(chunks("a" * 49 + "°C", 3)) == ["a" * 49 + "°C"]
    assert heard([definition_of("STATUSTEXT").pack({"severity": 4, "text": b"a\xff"})]) == ["a\ufffd"]


@pytest.mark.parametrize("number", [0, 7])
def test_text_of_fifty_bytes_is_whole_without_an_end(number: int) -> None:
    takeoff = chunks("Takeoff", 8)
    assert heard([*chunks(UNSAFE, number, ends=False), BEAT, *takeoff]) == [UNSAFE, "Takeoff"]
    assert heard([*chunks(UNSAFE, number, ends=False), BEAT], seconds=1.1) == [UNSAFE]
    assert heard([*chunks(UNSAFE, number, ends=False), BEAT]) == [UNSAFE] * (number == 0)


def test_missing_chunk_leaves_a_mark() -> None:
    first, middle, last = chunks(LONG, 5)
    gap = LongTexts.GAP
    assert heard([first, None, last]) == [f"{LONG[:50]}{gap}{LONG[100:]}"]
    assert heard([None, middle, last]) == [f"{gap}{LONG[50:]}"]
    assert heard([None, None, last]) == [f"{gap}{gap}{LONG[100:]}"]
    assert heard([first, middle, None, *chunks(RETURN, 6)]) == [f"{LONG[:100]}{gap}", RETURN]
    assert heard([first, middle, None, BEAT, BEAT], seconds=0.6) == [f"{LONG[:100]}{gap}"]
    assert heard([first, None, None, first, middle, last]) == [f"{LONG[:50]}{gap}", LONG]


def test_texts_of_two_vehicles_are_not_mixed() -> None:
    texts = LongTexts()
    ours, theirs = (
        [Codec(245, 190).decode(Codec(system, 1).frame(definition_of("STATUSTEXT"), each, 0.0)) for each in parts]
        for system, parts in ((1, chunks(RETURN, 9)), (2, chunks(LONG, 9)))
    )
    sent = [each for pair in zip(ours, theirs, strict=False) for each in pair if each is not None]
    got = list(texts.joined(sent, 0.0))
    assert [each.raw for each in got] == [each.raw for each in sent]
    assert [each.message.text for each in got if isinstance(each.message, Text)] == [RETURN]


def test_connection_and_its_log_have_whole_texts(tmp_path: Path) -> None:
    mock = BuiltInAutopilot(Autopilot.PX4, HOME)
    log = tmp_path / "texts.tlog"
    with Connection(Loopback(Station(mock)), Codec(245, 190), log=log) as connection:
        got = list[Message | None]()
        for second in range(6):
            if second == 3:
                far_end(connection).autopilot.vehicle.send_text(4, RETURN)
            while connection.now() < second:
                got += [each.message for each in connection.receive(second)]
    assert [each.text for each in got if isinstance(each, Text)] == [RETURN]
    assert RETURN in [each.text for _, each in read_telemetry_log(log).events if isinstance(each, Text)]
