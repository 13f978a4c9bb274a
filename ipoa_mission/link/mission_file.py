"""ArduPilot's fast path: the whole mission as one file, `@MISSION/mission.dat`, written and read by MAVFTP.

Six items go in one frame instead of one, and the vehicle takes the file whole or not at all. The file is a header of
five 16-bit numbers (magic, list, options, first item, count) and a MISSION_ITEM_INT payload of 38 bytes for each item.
"""

import struct
from collections.abc import Sequence

from ipoa_mission.errors import MissionError
from ipoa_mission.items import Item
from ipoa_mission.link.dialogue import Ask, Cancelled, Dialogue, NoAnswer, Step, TimeUp
from ipoa_mission.link.item_payloads import PAYLOAD_BYTES, pack_items, unpack_items
from ipoa_mission.link.mavftp import LONGEST_DATA, FileError, FileMessage, Opcode, unpack
from ipoa_mission.link.messages import FileTransfer, MissionType
from ipoa_mission.link.upload import ReadBackDiffers, Upload
from ipoa_mission.progress import Progress, count, silent

MISSION_FILE = "@MISSION/mission.dat"
MAGIC = 0x763D
HEADER = struct.Struct("<HHHHH")
TARGET = (1, 1)  # what each item in it is addressed to


class FileRefused(MissionError):
    """The vehicle would not do this with a file."""


def pack_mission(items: Sequence[Item], kind: int = MissionType.MISSION) -> bytes:
    """The file of a list as it stands on the wire (home first).

    Raises:
        BadInput: an item does not fit MAVLink.
    """
    packed = pack_items(items, kind)
    packed["target"] = TARGET
    return HEADER.pack(MAGIC, kind, 0, 0, len(items)) + packed.tobytes()


def unpack_mission(data: bytes) -> tuple[Item, ...]:
    """The list in a file.

    Raises:
        MissionError: this is no such file, or it breaks off.
    """
    if len(data) < HEADER.size or HEADER.unpack_from(data)[0] != MAGIC:
        raise MissionError("mission file: expected ArduPilot's mission.dat, but it does not begin like one")
    count = HEADER.unpack_from(data)[4]
    if len(data) != HEADER.size + count * PAYLOAD_BYTES:
        raise MissionError(f"mission file: expected {count} items, but it has {len(data)} bytes")
    return unpack_items(data[HEADER.size :])


def upload_by_file(job: Upload, progress: Progress = silent) -> Dialogue[None]:
    """Put a mission on the vehicle as one file, and verify it by reading the file back.

    Raises:
        FileRefused: the vehicle has no such file, or did not like what is in it; it keeps its old mission.
        NoAnswer, ReadBackDiffers, Cancelled.
    """
    total = len(job.items)
    done = 0

    def note(share: float, words: str) -> None:
        nonlocal done
        done = int(total * share)
        count(progress, done, total)

    try:
        closing = yield from write_file(MISSION_FILE, pack_mission(job.items, job.kind), note)
    except (Cancelled, TimeUp) as broken_off:  # a file that is not closed is not taken
        raise type(broken_off)(
            f"{broken_off}: the vehicle keeps the mission it had", hint=f"{done} of {total} items had been sent"
        ) from None
    try:
        yield from _settle(job, closing)
    except TimeUp as late:
        raise TimeUp(f"{late}: the vehicle holds a whole mission, the old or the new one") from None
    except Cancelled:
        raise (yield from _cancelled_late(job, closing)) from None


def _cancelled_late(job: Upload, closing: FileMessage) -> Dialogue[Cancelled]:
    """What became of a file that may have been taken before it was cancelled."""
    try:
        yield from _settle(job, closing)
    except FileRefused:
        return Cancelled("cancelled: the vehicle keeps the mission it had")
    except (NoAnswer, TimeUp, ReadBackDiffers):
        return Cancelled("cancelled: the vehicle holds a whole mission, the old or the new one, and does not say which")
    return Cancelled(
        "cancelled too late: the vehicle holds the whole new mission", hint="clear it if it must not be flown"
    )


def _settle(job: Upload, closing: FileMessage) -> Dialogue[None]:
    yield from _question(closing, f"take {MISSION_FILE}")
    stored = unpack_mission((yield from read_file(MISSION_FILE)))
    difference = job.difference(stored)
    if difference is not None:
        raise ReadBackDiffers(job.kind, difference)


def write_file(path: str, data: bytes, progress: Progress = silent) -> Dialogue[FileMessage]:
    """Write a whole file on the vehicle; it counts when the vehicle has taken the message that this returns.

    Raises:
        FileRefused, NoAnswer.
    """
    yield from _question(FileMessage(0, Opcode.RESET_SESSIONS), "reset the file service")
    opened = yield from _question(FileMessage(2, Opcode.CREATE_FILE, data=path.encode()), f"create {path}")
    sequence = 4
    for at in range(0, len(data), LONGEST_DATA):
        piece = data[at : at + LONGEST_DATA]
        question = FileMessage(sequence, Opcode.WRITE_FILE, opened.session, offset=at, data=piece)
        yield from _question(question, f"write {path}")
        sequence = sequence + 2 & 0xFFFF
        count(progress, at + len(piece), len(data))
    return FileMessage(sequence, Opcode.TERMINATE_SESSION, opened.session)


def read_file(path: str) -> Dialogue[bytes]:
    """Read a whole file of the vehicle's.

    Raises:
        FileRefused, NoAnswer.
    """
    yield from _question(FileMessage(0, Opcode.RESET_SESSIONS), "reset the file service")
    opened = yield from _question(FileMessage(2, Opcode.OPEN_FILE_RO, data=path.encode()), f"open {path}")
    data = b""
    sequence = 4
    while True:
        question = FileMessage(sequence, Opcode.READ_FILE, opened.session, offset=len(data), size=LONGEST_DATA)
        answer = yield from _question(question, f"read {path}", may_end=True)
        sequence = sequence + 2 & 0xFFFF
        if answer.opcode == Opcode.NAK or not answer.data:
            break
        data += answer.data
    yield from _question(FileMessage(sequence, Opcode.TERMINATE_SESSION, opened.session), f"close {path}")
    return data


def _question(question: FileMessage, what: str, may_end: bool = False) -> Dialogue[FileMessage]:
    """Ask until the answer comes: the one with the next number to this opcode."""
    step: Step = Ask(question.pack(), item=True)
    while True:
        try:
            heard = yield step
        except NoAnswer:
            raise NoAnswer(f"the vehicle does not answer when asked to {what}") from None
        step = None
        if not isinstance(heard, FileTransfer):
            continue
        answer = unpack(heard)
        if answer.sequence != (question.sequence + 1) & 0xFFFF or answer.request != question.opcode:
            continue
        if answer.opcode == Opcode.ACK or (may_end and answer.data[:1] == bytes((FileError.END_OF_FILE,))):
            return answer
        raise FileRefused(f"the vehicle would not {what} (error {answer.data[0] if answer.data else 0})")
