"""ArduPilot's `@MISSION/mission.dat` by MAVFTP: six items a frame.

Header: five 16-bit numbers (magic, list, options, first item, count); then MISSION_ITEM_INT payloads.
"""

import struct
from collections.abc import Sequence

from ipoa_mission.errors import MissionError
from ipoa_mission.link import mavftp, wire
from ipoa_mission.link.conversations import READ_ATTEMPTS, KeepsChanging, cancelled
from ipoa_mission.link.dialogue import Cancelled, Dialogue, NoAnswer, TimeUp
from ipoa_mission.link.messages import MissionType
from ipoa_mission.link.upload import ReadBackDiffers, Upload
from ipoa_mission.mission.item_words import count_words
from ipoa_mission.mission.items import Item
from ipoa_mission.progress import Progress, count, silent

MAGIC = 0x763D
HEADER = struct.Struct("<HHHHH")


def pack_mission(items: Sequence[Item], kind: int = MissionType.MISSION) -> bytes:
    """Wire form: home first."""
    records = [wire.item_payload(seq, item, kind, (1, 1)) for seq, item in enumerate(items)]
    return HEADER.pack(MAGIC, kind, 0, 0, len(items)) + b"".join(records)


def unpack_mission(data: bytes) -> tuple[Item, ...]:
    if len(data) < HEADER.size or HEADER.unpack_from(data)[0] != MAGIC:
        words = "expected ArduPilot's mission.dat, but it does not begin like one"
        raise MissionError(words, code="wrong-format", place="mission file")
    count = HEADER.unpack_from(data)[4]
    size = wire.ITEM.layout.size
    if len(data) != HEADER.size + count * size:
        message = f"expected {count_words(count)}, but it has {len(data)} bytes"
        raise MissionError(message, code="wrong-format", place="mission file")
    return tuple(wire.item_of(data[at : at + size]) for at in range(HEADER.size, len(data), size))


def upload_by_file(job: Upload, progress: Progress = silent) -> Dialogue[int]:
    """Return the checksum of the file as read back. Raise FileRefused if the vehicle keeps its old mission."""
    total = len(job.items)
    done = 0

    def note(share: float, words: str) -> None:
        nonlocal done
        done = int(total * share)
        count(progress, done, total)

    try:
        closing = yield from mavftp.write_file(mavftp.MISSION_FILE, pack_mission(job.items, job.kind), note)
    except (Cancelled, TimeUp) as aborted:  # an unclosed file is not taken
        raise type(aborted)(
            f"{aborted}: the vehicle keeps the mission it had",
            hint=f"{done} of {count_words(total)} had been sent",
            list_on_vehicle="old",
        ) from None
    try:
        return (yield from _confirm_stored(job, closing))
    except TimeUp as late:
        words = f"{late}: the vehicle holds a whole mission, the old or the new one"
        raise TimeUp(words, list_on_vehicle="either") from None
    except Cancelled:  # the file may have been taken
        try:
            yield from _confirm_stored(job, closing)
        except mavftp.FileRefused:
            raise cancelled(job.kind, "old") from None
        except (NoAnswer, TimeUp, ReadBackDiffers, KeepsChanging):
            raise cancelled(job.kind, "either") from None
        raise cancelled(job.kind, "new") from None


def _confirm_stored(job: Upload, closing: mavftp.FileMessage) -> Dialogue[int]:
    yield from mavftp.ask_of_file(closing, f"take {mavftp.MISSION_FILE}")
    for _ in range(READ_ATTEMPTS):
        data = yield from mavftp.read_file(mavftp.MISSION_FILE)
        difference = job.difference(unpack_mission(data))
        if difference is not None:
            raise ReadBackDiffers(job.kind, difference)
        checksum = None if job.numbers is None else (yield from mavftp.list_checksum(job.kind, job.numbers))
        if checksum in (None, mavftp.file_checksum(data)):
            return checksum or 0
    raise KeepsChanging(job.kind)
