import dataclasses
import math
import random
from pathlib import Path
from typing import get_type_hints

import pytest
from fastcrc.crc16 import mcrf4xx
from hypothesis import given
from hypothesis import strategies as st
from pymavlink.dialects.v20 import ardupilotmega as dialect
from pymavlink.generator.mavcrc import x25crc

from ipoa_mission.autopilot.autopilot import Autopilot
from ipoa_mission.link import codec, wire
from ipoa_mission.link import messages as m
from ipoa_mission.link.codec import EVERYONE, Codec, Framer, Target, frames, read_tlog
from ipoa_mission.link.definitions import definition_of, message_name
from ipoa_mission.link.signing import Signer
from ipoa_mission.link.upload import Upload
from ipoa_mission.mission.items import Item
from tests.refused import refuses

NOW = 1_767_225_600.0
FIRST_GUESS = {int: 1, float: 1.5, str: "WORDS", bytes: b"\x01\x02"}
UNKNOWN_THERE = {m.Event, m.ProtocolVersion}
KINDS = sorted(wire.KINDS.values(), key=lambda kind: kind.__name__)


def example(kind: type[m.Message]) -> m.Message:
    """Return a message with values that the wire holds exactly."""
    special = {
        m.ItemAt: m.ItemAt(7, Item(16, 3, (1.0, 2.0, 3.0, 4.0), 39.1234567, 121.7654321, 12.5), 1),
        m.CommandLong: m.CommandLong(400, (1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0), 2),
        m.CommandInt: m.CommandInt(192, 6, (1.0, 2.0, 3.0, 4.0), 391234567, -10, 50.0),
        m.Position: m.Position(12.345, 39.1, -121.5, 400.25, 30.5, (1.25, -2.5, 0.5), math.pi / 2),
        m.WindVelocity: m.WindVelocity((1.5, -2.0, 0.25)),
        m.LocalPosition: m.LocalPosition(1.0, (1.0, 2.0, -3.0), (0.5, 0.25, -0.125)),
        m.FileTransfer: m.FileTransfer(bytes(range(251))),
        m.SystemTime: m.SystemTime(NOW, 5.0),
        m.Ack: m.Ack(1, 1),  # without the ids that pymavlink does not know
        m.Current: m.Current(1, 1, 1, 1),
    }
    if kind in special:
        return special[kind]
    hints = get_type_hints(kind)
    return kind(**{field.name: FIRST_GUESS.get(hints[field.name], False) for field in dataclasses.fields(kind)})


@pytest.mark.parametrize("kind", KINDS, ids=lambda kind: kind.__name__)
def test_every_message_survives_the_wire(kind: type[m.Message]) -> None:
    message = example(kind)
    (frame,) = frames(Codec(245, 190).encode(message, Target(1, 1), NOW))
    heard = Codec(1, 1).decode(frame)
    assert heard is not None
    assert (heard.system, heard.component) == (245, 190)
    for field in dataclasses.fields(message):
        received, sent = getattr(heard.message, field.name), getattr(message, field.name)
        assert received == (sent if isinstance(sent, str | bytes | Item) else pytest.approx(sent, abs=1e-6)), field.name


@pytest.mark.parametrize("kind", [kind for kind in KINDS if kind not in UNKNOWN_THERE], ids=lambda kind: kind.__name__)
def test_pymavlink_reads_our_frames_byte_for_byte(kind: type[m.Message]) -> None:
    message = example(kind)
    frame = Codec(245, 190).encode(message, Target(1, 1), NOW)
    name, fields = wire.write(message)
    (theirs,) = dialect.MAVLink(None).parse_buffer(frame)
    assert theirs.get_type() == name
    assert (theirs.get_srcSystem(), theirs.get_srcComponent()) == (245, 190)
    for field, value in fields.items():
        if isinstance(value, float):
            assert getattr(theirs, field) == pytest.approx(value, rel=1e-6)
    voice = dialect.MAVLink(None, 245, 190)
    assert theirs.pack(voice) == frame


def test_pymavlink_s_frames_of_both_versions_are_read() -> None:
    voice = dialect.MAVLink(None, 1, 1)
    message = dialect.MAVLink_mission_count_message(245, 190, 12, 0)
    for force_mavlink1 in (False, True):
        (frame,) = Framer().feed(message.pack(voice, force_mavlink1=force_mavlink1))
        heard = Codec(245, 190).decode(frame)
        assert heard is not None
        assert heard.message == m.Count(12)
        assert heard.is_for(245, 190)
        assert not heard.is_for(246, 190)
        assert not heard.is_for(245, 191)


def test_fields_that_a_newer_autopilot_adds_are_passed_over() -> None:
    # PX4 1.17's MISSION_COUNT has an opaque_id, which this dialect lacks.
    kind = dialect.MAVLink_mission_count_message
    payload = b"\x05\x00\xf5\xbe\x00" + b"\x12\x34\x56\x78"
    body = bytes((len(payload), 0, 0, 0, 1, 1, kind.id, 0, 0)) + payload
    crc = dialect.x25crc(body + bytes((kind.crc_extra,))).crc.to_bytes(2, "little")
    (frame,) = frames(b"\xfd" + body + crc)
    heard = Codec(245, 190).decode(frame)
    assert heard is not None
    assert heard.message == m.Count(5)


def test_ids_of_missions_are_read_as_px4_sends_them() -> None:
    # PX4 1.17 after an upload of seven items (recorded payloads).
    for number, crc_extra, payload, message in (
        (47, 153, "f5be00008e66bf40", m.Ack(0, 0, 0x40BF668E)),
        (42, 28, "0000070002028e66bf40", m.Current(0, 7, 2, 2, 0x40BF668E)),
    ):
        body = bytes((len(payload) // 2, 0, 0, 0, 1, 1, number, 0, 0)) + bytes.fromhex(payload)
        (frame,) = frames(b"\xfd" + body + dialect.x25crc(body + bytes((crc_extra,))).crc.to_bytes(2, "little"))
        heard = Codec(245, 190).decode(frame)
        assert heard is not None
        assert heard.message == message
        (ours,) = frames(Codec(1, 1).encode(message, Target(245, 190), NOW))
        assert Codec(245, 190).decode(ours).message == message  # type: ignore[union-attr]


@given(st.integers(-1_800_000_000, 1_800_000_000), st.sampled_from([0, 3, 5, 6, 10, 11]))
def test_degrees_survive_to_the_last_unit(value: int, frame: int) -> None:
    assert wire.coordinate(wire.degrees(value, frame), frame) == value


@pytest.mark.parametrize(("frame", "value", "sent"), [(2, 7.0, 7), (1, 12.3456, 123456), (3, math.nan, 2**31 - 1)])
def test_frames_have_their_own_scale(frame: int, value: float, sent: int) -> None:
    assert wire.coordinate(value, frame) == sent
    back = wire.degrees(sent, frame)
    assert back == value or (math.isnan(back) and math.isnan(value))


@pytest.mark.parametrize("value", [215.0, -215.0, 1e305, math.inf, -math.inf])
def test_values_out_of_range_are_errors_and_not_clamped(value: float) -> None:
    with refuses("bad-input", "coordinate"):
        wire.coordinate(value, 3)


def test_a_nan_without_a_position_is_nothing() -> None:
    assert wire.coordinate(math.nan, 2) == 0


def stream(count: int) -> tuple[bytes, list[bytes]]:
    codec = Codec(1, 1)
    sent = [codec.encode(m.Text(3, f"words {n}"), EVERYONE, NOW) for n in range(count)]
    return b"".join(sent), sent


@given(st.lists(st.integers(1, 40), min_size=1, max_size=30))
def test_frames_are_cut_from_a_stream_however_it_is_torn(sizes: list[int]) -> None:
    data, sent = stream(20)
    framer, at = Framer(), 0
    got: list[bytes] = []
    while at < len(data):
        for size in sizes:
            got += framer.feed(data[at : at + size])
            at += size
    assert got == sent


@given(st.binary(max_size=300), st.binary(max_size=300))
def test_frames_are_found_between_any_garbage(before: bytes, between: bytes) -> None:
    _, sent = stream(2)
    got = list(frames(before + sent[0] + between + sent[1]))
    assert [frame for frame in got if frame in sent] == sent


def test_a_corrupt_length_costs_one_frame_and_not_its_neighbors() -> None:
    _, sent = stream(3)
    torn = bytearray(sent[0])
    torn[1] = 255
    framer = Framer()
    got = [frame for chunk in (bytes(torn), *sent[1:], b"\0" * 300) for frame in framer.feed(chunk)]
    assert got == sent[1:]


@given(st.binary(max_size=2000))
def test_no_bytes_hurt(data: bytes) -> None:
    codec = Codec(1, 1)
    for frame in [*frames(data), *Framer().feed(data)]:
        codec.decode(frame)


@pytest.mark.parametrize("seed", range(3))
def test_no_whole_frame_of_any_known_message_hurts(seed: int) -> None:
    chance, codec, voice = random.Random(seed), Codec(1, 1), dialect.MAVLink(None, 9, 9)
    for kind in dialect.mavlink_map.values():
        payload = chance.randbytes(kind.unpacker.size)
        message = kind.__new__(kind)
        dialect.MAVLink_message.__init__(message, kind.id, kind.msgname)
        frame = message._pack(voice, kind.crc_extra, payload)
        (whole,) = frames(frame)
        assert codec.decode(whole) is not None


def test_a_framer_never_keeps_more_than_a_frame() -> None:
    framer = Framer()
    for _ in range(100):
        list(framer.feed(b"\xfd\xff\x00" * 500))
    assert len(framer.buffer) < 300


def test_frames_with_unknown_flags_or_numbers_are_passed_over() -> None:
    _, (frame,) = stream(1)
    assert list(frames(frame[:2] + b"\x02" + frame[3:])) == []
    assert list(frames(b"\xfd\x00\x00\x00\x00\x01\x01\xff\xff\xff\x00\x00")) == []


def test_the_seed_of_a_checksum_follows_from_the_fields() -> None:
    """CRC_EXTRA as the MAVLink guide defines it, of a message that pymavlink's dialect does not have."""
    seed = x25crc(b"PROTOCOL_VERSION uint16_t version uint16_t min_version uint16_t max_version ")
    for name in ("spec_version_hash", "library_version_hash"):
        seed.accumulate(f"uint8_t {name} ".encode() + bytes([8]))
    assert definition_of("PROTOCOL_VERSION").seed == bytes(((seed.crc & 0xFF) ^ (seed.crc >> 8),))


def test_names_and_numbers_belong_together() -> None:
    assert definition_of("EVENT").number == 410
    assert message_name(definition_of("HEARTBEAT").number) == "HEARTBEAT"
    assert message_name(999_999) is None


# --- signing --------------------------------------------------------------------------------------------------------

KEY = bytes(range(32))


def test_pymavlink_accepts_our_signature_and_we_theirs() -> None:
    ours = Codec(245, 190, Signer(KEY, link_id=3))
    theirs = dialect.MAVLink(None, 1, 1)
    theirs.signing.secret_key = KEY
    theirs.signing.timestamp = round((NOW - 1_420_070_400) * 1e5)
    (heard,) = theirs.parse_buffer(ours.encode(m.Count(5), Target(1, 1), NOW))
    assert heard.get_type() == "MISSION_COUNT"
    theirs.signing.sign_outgoing = True
    frame = dialect.MAVLink_mission_ack_message(245, 190, 0, 0).pack(theirs)
    decoded = ours.decode(frame)
    assert decoded is not None
    assert decoded.message == m.Ack(0)


def test_strangers_replays_and_the_unsigned_are_not_heard() -> None:
    judge = Codec(1, 1, Signer(KEY))
    friend = Codec(245, 190, Signer(KEY))
    frame = friend.encode(m.Count(5), Target(1, 1), NOW)
    assert judge.decode(frame) is not None
    assert judge.decode(frame) is None  # again
    assert judge.decode(Codec(245, 190, Signer(bytes(32))).encode(m.Count(5), Target(1, 1), NOW + 1)) is None
    assert judge.decode(Codec(245, 190).encode(m.Count(5), Target(1, 1), NOW)) is None
    assert judge.decode(friend.encode(m.Count(5), Target(1, 1), NOW + 2)) is not None


def test_a_forged_future_does_not_lock_the_friend_out() -> None:
    judge, friend = Codec(1, 1, Signer(KEY)), Codec(245, 190, Signer(KEY))
    forged = bytearray(friend.encode(m.Count(5), Target(1, 1), NOW + 1e6))
    forged[-1] ^= 1
    assert judge.decode(bytes(forged)) is None
    assert judge.decode(friend.encode(m.Count(5), Target(1, 1), NOW)) is not None


def test_a_new_stream_may_not_be_long_behind() -> None:
    judge = Codec(1, 1, Signer(KEY))
    assert judge.decode(Codec(245, 190, Signer(KEY)).encode(m.Count(1), Target(1, 1), NOW)) is not None
    assert judge.decode(Codec(246, 190, Signer(KEY)).encode(m.Count(1), Target(1, 1), NOW - 61)) is None


def test_the_radio_may_speak_unsigned() -> None:
    judge, radio = Codec(1, 1, Signer(KEY)), Codec(51, 68)
    assert judge.decode(radio.frame(definition_of("RADIO_STATUS"), b"\x64", NOW)) is not None
    assert judge.decode(radio.frame(definition_of("RADIO"), b"\x64", NOW)) is None


# --- what MAVLink cannot carry, and what is no MAVLink --------------------------------------------------------------


@pytest.mark.parametrize(
    ("message", "field"),
    [
        (m.ParamSet("MPC_XY_CRUISE", 1e300), "PARAM_SET"),
        (m.CommandLong(400, (1e300, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)), "COMMAND_LONG"),
        (m.CommandLong(70_000), "COMMAND_LONG"),
        (m.Count(70_000), "MISSION_COUNT"),
        (m.SetCurrent(-1), "MISSION_SET_CURRENT"),
    ],
)
def test_a_value_that_does_not_fit_is_an_error_that_names_its_message(message: m.Message, field: str) -> None:
    with refuses("bad-input", field):
        Codec(245, 190).encode(message, Target(1, 1), NOW)


FINE = Item(16, 3, (0.0, math.nan, math.inf, -3.3e38), 47.4, 8.5, 30.0)


@pytest.mark.parametrize(
    ("change", "expected"),
    [
        ({"params": (0.0, 1e300, 0.0, 0.0)}, ("bad-input", "item 2: param2", "1e")),
        ({"altitude": -1e39}, ("bad-input", "item 2: altitude")),
        ({"command": 70_000}, ("bad-input", "item 2: command", "65535", "70000")),
        ({"frame": 300}, ("bad-input", "item 2: frame", "255", "300")),
        ({"latitude_deg": -1e305}, ("bad-input", "item 2: coordinate")),
        ({"latitude_deg": math.inf}, ("bad-input", "item 2: coordinate")),
    ],
)
def test_an_item_that_cannot_be_said_is_an_error_before_anything_is_sent(
    change: dict[str, object], expected: tuple[str, ...]
) -> None:
    Upload((FINE, FINE), Autopilot.PX4)
    with refuses(*expected):
        Upload((FINE, dataclasses.replace(FINE, **change)), Autopilot.PX4)  # type: ignore[arg-type]


def test_more_items_than_mavlink_can_count_are_an_error_before_sending() -> None:
    with refuses("bad-input", "", "65535", "70000"):
        Upload((FINE,) * 70_000, Autopilot.PX4)


@pytest.mark.parametrize("noise", [b"\xfd", b"\xfe", b"\xfd\xff\x00", b"\xfe\x09\x00", b"\0"])
def test_the_work_on_noise_grows_with_its_length(noise: bytes, monkeypatch: pytest.MonkeyPatch) -> None:
    data = (noise * 60_000)[:60_000]
    begun: list[int] = []
    summed: list[int] = []
    search, checksum = codec.next_magic, mcrf4xx

    def searched(data: bytes, at: int) -> int:
        begun.append(at)
        return search(data, at)

    def checked(data: bytes) -> int:
        summed.append(len(data))
        return checksum(data)

    monkeypatch.setattr(codec, "next_magic", searched)
    monkeypatch.setattr(codec, "mcrf4xx", checked)
    assert list(frames(data)) == []
    assert begun == sorted(set(begun)), "a byte is looked at twice"
    assert list(Framer().feed(data)) == []
    assert len(begun) <= 2 * (len(data) + 1)
    assert max(summed, default=0) <= 280, "more than a frame is summed"


def test_a_log_of_noise_is_read(tmp_path: Path) -> None:
    path = tmp_path / "noise.tlog"
    path.write_bytes(random.Random(1).randbytes(3_000_000))
    assert list(read_tlog(path)) == []


@given(st.lists(st.integers(1, 40), min_size=1, max_size=30), st.binary(max_size=40))
def test_frames_are_put_together_from_cut_datagrams_however_they_are_cut(sizes: list[int], before: bytes) -> None:
    _, sent = stream(6)
    framer = Framer()
    got = [*framer.feed(before)]
    for frame in sent:
        at = 0
        while at < len(frame):
            for size in sizes:
                got += framer.feed(frame[at : at + size]) if at < len(frame) else ()
                at += size
    assert [frame for frame in got if frame in sent][-1] == sent[-1]
    if not any(byte in before for byte in b"\xfd\xfe"):
        assert got == sent


def test_a_whole_datagram_is_heard_at_once_behind_half_a_frame() -> None:
    _, sent = stream(2)
    framer = Framer()
    assert list(framer.feed(b"\xfd\xff\x00" + sent[0][:10])) == []
    assert list(framer.feed(sent[1])) == [sent[1]]


@pytest.mark.parametrize(("frame", "unit"), [(3, 1e-7), (2, 1.0)])
def test_coordinates_beyond_the_largest_and_smallest_are_errors(frame: int, unit: float) -> None:
    for value in (2**31 - 2, 1 - 2**31):
        item = dataclasses.replace(FINE, frame=frame, latitude_deg=0.0, longitude_deg=value * unit)
        Upload([item], Autopilot.PX4)
        assert wire.coordinate(item.longitude_deg, frame) == value
    for value in (2**31 - 1, -(2**31)):
        item = dataclasses.replace(FINE, frame=frame, longitude_deg=value * unit)
        with refuses("bad-input", "item 1: coordinate"):
            Upload([item], Autopilot.PX4)
