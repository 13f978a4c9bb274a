import gc
import hashlib
import os
from dataclasses import replace
from functools import partial
from pathlib import Path

import pytest

from ipoa_mission.autopilot.autopilot import Autopilot, registered
from ipoa_mission.geodesy import Geodetic
from ipoa_mission.link.codec import EVERYONE, Codec
from ipoa_mission.link.connect import meet
from ipoa_mission.link.connection import CAUSE_S, Connection
from ipoa_mission.link.dialogue import NoAnswer
from ipoa_mission.link.messages import Heartbeat, MissionType, Text
from ipoa_mission.link.signing import (
    EPOCH_2015_S,
    MAX_SIGNERS,
    TICKS_PER_S,
    Doubt,
    Signer,
    Timestamps,
    key_of,
    persistent_signer,
    read_key,
)
from ipoa_mission.mission.items import Mission, land, takeoff
from ipoa_mission.simulator.built_in_autopilot import BuiltInAutopilot as Mock
from ipoa_mission.simulator.station import Loopback, Station
from tests.link_pair import far_end
from tests.px4_waypoints import waypoint
from tests.refused import refuses

HOME = Geodetic(47.4, 8.5, 400.0)
THERE = Geodetic(47.4002, 8.5)
MISSION = Mission(HOME, (takeoff(HOME, 5.0), waypoint(THERE, 5.0), land(THERE)))
KEY = key_of("a passphrase")


def signed_pair(ours: bytes | None, theirs: bytes | None) -> Connection:
    station = Station(Mock(Autopilot.PX4, HOME), signer=Signer(theirs) if theirs else None)
    return Connection(Loopback(station), Codec(245, 190, Signer(ours) if ours else None))


def test_a_mission_goes_over_a_signed_link() -> None:
    meet(signed_pair(KEY, KEY)).upload(MISSION)


@pytest.mark.parametrize(("theirs", "words"), [(None, "it does not sign"), (bytes(32), "another key")])
@pytest.mark.parametrize("system", [None, 1])
def test_vehicles_without_our_key_are_named(theirs: bytes | None, words: str, system: int | None) -> None:
    connection = signed_pair(KEY, theirs)
    with refuses("signs-otherwise", "", "vehicle 1", words):
        meet(connection, system)
    assert connection.now() < 4.5


def test_an_unsigned_vehicle_is_not_taken_for_the_one_sought() -> None:
    connection = signed_pair(KEY, None)
    with refuses("not-heard", "", "system id 7", kind=NoAnswer):
        meet(connection, 7)


def test_a_replay_of_what_a_vehicle_said_before_is_named() -> None:
    codec, ours = Codec(1, 1, Signer(KEY)), Codec(245, 190, Signer(KEY))
    beat = codec.encode(Heartbeat(2, 12), EVERYONE, EPOCH_2015_S + 1e8)
    assert ours.decode(beat) is not None
    assert ours.decode(beat) is None
    assert ours.signer is not None
    assert ours.signer.doubts == {(1, 1): Doubt.STALE}


@pytest.mark.parametrize("autopilot", registered())
@pytest.mark.parametrize("is_parameter", [False, True])
def test_a_vehicle_with_a_key_does_nothing_for_a_stranger_who_is_told_why(
    autopilot: Autopilot, is_parameter: bool
) -> None:
    connection = Connection(Loopback(Station(Mock(autopilot, HOME), signer=Signer(KEY))), Codec(245, 190))
    vehicle = meet(connection)
    vehicle.state.booted = True
    mission, begun = replace(MISSION, autopilot=autopilot), connection.now()
    order = partial(vehicle.parameters, ["A"]) if is_parameter else partial(vehicle.upload, mission, checked=False)
    with refuses("signs-otherwise") as caught:
        order()
    assert "--key" in str(caught.value.hint)
    assert "mixture" not in str(caught.value.hint)
    assert connection.now() - begun < (15.0 if is_parameter else CAUSE_S + 1.0)
    assert far_end(connection).autopilot.transfers.listed(MissionType.MISSION) == ()


NOW = 1_767_225_600.0


def stamp_of(signature: bytes) -> int:
    return int.from_bytes(signature[1:7], "little")


def ticks(unix_s: float) -> int:
    return round((unix_s - EPOCH_2015_S) * TICKS_PER_S)


def test_signing_timestamps_follow_the_clock_and_only_grow(tmp_path: Path) -> None:
    last = 0
    for run in range(50):
        signer = persistent_signer(KEY, tmp_path / "timestamp")
        stamp = stamp_of(signer.signature(b"\xfd", NOW + 0.001 * run))
        signer.close()
        assert last < stamp <= ticks(NOW + 0.001 * run) + 1
        last = stamp


def test_a_run_that_was_killed_repeats_no_timestamp(tmp_path: Path) -> None:
    mark = tmp_path / "timestamp"
    killed = persistent_signer(KEY, mark)
    stamps = [stamp_of(killed.signature(b"\xfd", NOW + 0.1 * n)) for n in range(100)]
    killed._timestamps.close()  # type: ignore[union-attr]
    later = persistent_signer(KEY, mark)
    after = stamp_of(later.signature(b"\xfd", NOW + 5.0))  # and the clock was set back
    assert stamps[-1] < after <= stamps[-1] + TICKS_PER_S + 1


def test_a_clock_that_was_set_back_is_told_once(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    mark = tmp_path / "timestamp"
    first = persistent_signer(KEY, mark)
    before = stamp_of(first.signature(b"\xfd", NOW))
    first.close()
    later = persistent_signer(KEY, mark)
    stamps = [stamp_of(later.signature(b"\xfd", NOW - 3600.0)) for _ in range(5)]
    assert [stamp - before for stamp in stamps] == [1, 2, 3, 4, 5]
    assert [record.message.split(": was")[0] for record in caplog.records] == [
        "signing goes on from timestamps that are 3600 s ahead of this computer's clock"
    ]


def test_processes_that_sign_at_the_same_time_have_their_own_link_ids(tmp_path: Path) -> None:
    mark, judge = tmp_path / "timestamp", Codec(1, 1, Signer(KEY))
    first, second = (Codec(245, 190, persistent_signer(KEY, mark)) for _ in range(2))
    late = first.encode(Text(6, "late"), EVERYONE, NOW)
    assert judge.decode(second.encode(Text(6, "early"), EVERYONE, NOW + 0.01)) is not None
    assert judge.decode(late) is not None
    first.signer.close()  # type: ignore[union-attr]
    assert persistent_signer(KEY, mark).link_id == 0


def test_a_file_that_holds_no_timestamp_is_an_error(tmp_path: Path) -> None:
    for words in ("yesterday", str(2**48), "-1"):
        (tmp_path / "timestamp").write_text(words)
        with refuses("bad-input", "timestamp"):
            persistent_signer(KEY, tmp_path / "timestamp")
    with refuses("unwritable", "timestamp"):
        persistent_signer(KEY, tmp_path / "no" / "timestamp")


FULL = Path("/dev/full")
full_disk = pytest.mark.skipif(not FULL.exists(), reason="this system has no /dev/full")


@full_disk
def test_a_full_disk_does_not_end_what_is_signed(caplog: pytest.LogCaptureFixture) -> None:
    signer = Signer(KEY, 0, Timestamps(FULL, os.open(FULL, os.O_RDWR), 0))
    assert signer.signature(b"\xfd", NOW)
    assert "/dev/full: cannot be written: No space left on device" in caplog.text
    signer.close()


def test_signing_timestamps_continue_after_an_unclosed_owner(tmp_path: Path) -> None:
    forgotten = persistent_signer(KEY, tmp_path / "timestamp")
    forgotten.itself = forgotten  # type: ignore[attr-defined]
    assert persistent_signer(KEY, tmp_path / "timestamp").link_id == 1
    del forgotten
    gc.collect()
    assert persistent_signer(KEY, tmp_path / "timestamp").link_id == 0


@full_disk
def test_a_log_on_a_full_disk_ends_with_a_warning_and_the_session_goes_on(caplog: pytest.LogCaptureFixture) -> None:
    connection = Connection(Loopback(Station(Mock(Autopilot.PX4, HOME))), Codec(245, 190), FULL)
    meet(connection).upload(MISSION)
    connection.close()
    assert [record.message for record in caplog.records] == [
        "/dev/full: cannot be written any more: No space left on device; the log ends here"
    ]


@pytest.mark.parametrize("words", ["a passphrase", "p" * 31, "p" * 32, KEY.hex(), "sch\u00f6n " * 4, " spaced "])
def test_a_key_is_the_same_in_a_file_and_in_the_environment(tmp_path: Path, words: str) -> None:
    path = tmp_path / "key"
    for end in ("", "\n", "\r\n"):
        path.write_bytes((words + end).encode())
        assert read_key(path) == key_of(words)
        path.write_bytes((words + end).encode("utf-8-sig"))  # as PowerShell writes it
        assert read_key(path) == key_of(words)
    hashed = hashlib.sha256(words.encode()).digest()
    assert key_of(words) == (KEY if words == KEY.hex() else hashed)


def test_keys_are_read_as_ground_stations_write_them(tmp_path: Path) -> None:
    path = tmp_path / "key"
    for content in (KEY, KEY.hex().encode(), b"a passphrase\n"):
        path.write_bytes(content)
        assert read_key(path) == KEY
    for content in (b"", b"\n", b" \n", KEY + b"\n", b"\x00" * 16):
        path.write_bytes(content)
        with refuses("bad-input", "signing key"):
            read_key(path)
    with refuses("unreadable", "none"):
        read_key(tmp_path / "none")


def test_a_key_that_others_may_write_is_warned_of(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    path = tmp_path / "key"
    path.write_bytes(KEY)
    path.chmod(0o644)
    read_key(path)
    assert caplog.text == ""
    path.chmod(0o664)
    read_key(path)
    assert "others than its owner may write this key" in caplog.text


def test_a_line_that_is_closed_gives_its_link_id_back(tmp_path: Path) -> None:
    path = tmp_path / "timestamp"
    connection = Connection(Loopback(Station(Mock(Autopilot.PX4, HOME))), Codec(245, 190, persistent_signer(KEY, path)))
    with connection:
        assert persistent_signer(KEY, path).link_id == 1
    assert persistent_signer(KEY, path).link_id == 0


def test_every_process_with_a_link_id_can_sign_at_once(tmp_path: Path) -> None:
    signers = [persistent_signer(bytes(32), tmp_path / "stamp") for _ in range(MAX_SIGNERS)]
    assert len({signer.link_id for signer in signers}) == MAX_SIGNERS
    with refuses("too-large", "stamp", f"{MAX_SIGNERS}"):
        persistent_signer(bytes(32), tmp_path / "stamp")
    signers[3].close()
    signers[3].close()  # once more does nothing
    assert persistent_signer(bytes(32), tmp_path / "stamp").link_id == 3


def test_a_timestamp_that_cannot_be_locked_is_bad_input(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*_: object) -> None:
        raise OSError(95, "Operation not supported")

    monkeypatch.setattr("ipoa_mission.link.signing._lock", refuse)
    with refuses("unwritable", "stamp"):
        persistent_signer(bytes(32), tmp_path / "stamp")
