"""MAVFTP: its messages, the transfer of whole files, and the CRC-32 of ArduPilot's lists."""

import struct
import zlib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from enum import IntEnum

from ipoa_mission.errors import MissionError
from ipoa_mission.link import wire
from ipoa_mission.link.dialogue import Ask, Dialogue, NoAnswer, Pause, SendOnce, hear
from ipoa_mission.link.messages import FileTransfer, Message, MissionType
from ipoa_mission.mission.item_words import count_words
from ipoa_mission.mission.items import Item
from ipoa_mission.progress import Progress, count, silent

HEADER = struct.Struct("<HBBBBBBI")
LONGEST_DATA = 251 - HEADER.size
MISSION_FILE = "@MISSION/mission.dat"
LIST_FILES: Mapping[int, str] = {
    MissionType.MISSION: MISSION_FILE,
    MissionType.FENCE: "@MISSION/fence.dat",
    MissionType.RALLY: "@MISSION/rally.dat",
}
#: ArduPilot's mission.dat: magic, list, options, first item, count; then MISSION_ITEM_INT payloads.
LIST_HEADER = struct.Struct("<HHHHH")
LIST_MAGIC = 0x763D


class Opcode(IntEnum):
    NONE = 0
    TERMINATE_SESSION = 1
    RESET_SESSIONS = 2
    OPEN_FILE_RO = 4
    READ_FILE = 5
    CREATE_FILE = 6
    WRITE_FILE = 7
    OPEN_FILE_WO = 11
    CALC_FILE_CRC32 = 14
    BURST_READ_FILE = 15
    ACK = 128
    NAK = 129


class FileError(IntEnum):
    """First data byte of a NAK."""

    FAIL = 1
    INVALID_SESSION = 4
    UNKNOWN_COMMAND = 7
    END_OF_FILE = 6
    FILE_NOT_FOUND = 10


@dataclass(frozen=True)
class FileMessage:
    """An answer's `sequence` is its question's plus one."""

    sequence: int
    opcode: int
    session: int = 0
    request: int = 0  # the answered opcode
    offset: int = 0
    data: bytes = b""
    size: int | None = None  # bytes to read, of READ_FILE

    @property
    def checksum(self) -> int | None:
        """Return None if unsupported."""
        return int.from_bytes(self.data[:4], "little") if self.opcode == Opcode.ACK else None

    def pack(self) -> FileTransfer:
        size = len(self.data) if self.size is None else self.size
        numbers = (self.sequence & 0xFFFF, self.session, self.opcode, size, self.request, 0, 0)
        return FileTransfer((HEADER.pack(*numbers, self.offset) + self.data).ljust(251, b"\0"))


def unpack(message: FileTransfer) -> FileMessage:
    """`size` may exceed the data."""
    sequence, session, opcode, size, request, _, _, offset = HEADER.unpack_from(message.payload)
    data = message.payload[HEADER.size : HEADER.size + size]
    return FileMessage(sequence, opcode, session, request, offset, data, size)


def nak(question: FileMessage, error: FileError) -> FileMessage:
    sequence = (question.sequence + 1) & 0xFFFF
    return FileMessage(sequence, Opcode.NAK, question.session, question.opcode, 0, bytes((error,)))


def pack_mission(items: Sequence[Item], kind: int = MissionType.MISSION) -> bytes:
    """Wire form: home first."""
    records = [wire.item_payload(seq, item, kind, (1, 1)) for seq, item in enumerate(items)]
    return LIST_HEADER.pack(LIST_MAGIC, kind, 0, 0, len(items)) + b"".join(records)


def unpack_mission(data: bytes) -> tuple[Item, ...]:
    if len(data) < LIST_HEADER.size or LIST_HEADER.unpack_from(data)[0] != LIST_MAGIC:
        words = "expected ArduPilot's mission.dat, but it does not begin like one"
        raise MissionError(words, code="wrong-format", place="mission file")
    total = LIST_HEADER.unpack_from(data)[4]
    size = wire.ITEM.layout.size
    if len(data) != LIST_HEADER.size + total * size:
        message = f"expected {count_words(total)}, but it has {len(data)} bytes"
        raise MissionError(message, code="wrong-format", place="mission file")
    return tuple(wire.item_of(data[at : at + size]) for at in range(LIST_HEADER.size, len(data), size))


class FileRefused(MissionError, code="file-refused"):
    pass


def write_file(path: str, data: bytes, progress: Progress = silent) -> Dialogue[FileMessage]:
    """The returned message closes the file."""
    session = yield from _open_session(Opcode.CREATE_FILE, path, "create")
    sequence = 4
    for at in range(0, len(data), LONGEST_DATA):
        piece = data[at : at + LONGEST_DATA]
        question = FileMessage(sequence, Opcode.WRITE_FILE, session, offset=at, data=piece)
        yield from ask_of_file(question, f"write {path}")
        sequence = sequence + 2 & 0xFFFF
        count(progress, at + len(piece), len(data))
    return FileMessage(sequence, Opcode.TERMINATE_SESSION, session)


def _open_session(opcode: Opcode, path: str, verb: str) -> Dialogue[int]:
    yield from ask_of_file(FileMessage(0, Opcode.RESET_SESSIONS), "reset the file service")
    return (yield from ask_of_file(FileMessage(2, opcode, data=path.encode()), f"{verb} {path}")).session


def read_file(path: str) -> Dialogue[bytes]:
    session = yield from _open_session(Opcode.OPEN_FILE_RO, path, "open")
    data = b""
    sequence = 4
    while True:
        question = FileMessage(sequence, Opcode.READ_FILE, session, offset=len(data), size=LONGEST_DATA)
        answer = yield from ask_of_file(question, f"read {path}", may_end=True)
        sequence = sequence + 2 & 0xFFFF
        if answer.opcode == Opcode.NAK or not answer.data:
            break
        data += answer.data
    yield from ask_of_file(FileMessage(sequence, Opcode.TERMINATE_SESSION, session), f"close {path}")
    return data


def list_checksum(kind: int, numbers: Iterator[int]) -> Dialogue[int | None]:
    """Return a list's checksum with home, None if unsupported; a repeated sequence number gets its old answer."""
    asked: set[int] = set()
    for seconds in (0.5,) * 4 + (1.0,) * 6 + (2.0,) * 8:
        yield SendOnce(checksum_question(kind, numbers, asked))
        answer = yield from hear(Pause(seconds), lambda heard: answer_in(heard, asked))
        if answer is not None:
            return answer.checksum
    raise NoAnswer(f"the vehicle does not answer when asked for the checksum of {LIST_FILES[kind]}")


def checksum_question(kind: int, numbers: Iterator[int], asked: set[int]) -> FileTransfer:
    question = FileMessage(next(numbers) & 0xFFFF, Opcode.CALC_FILE_CRC32, data=LIST_FILES[kind].encode())
    asked.add((question.sequence + 1) & 0xFFFF)
    return question.pack()


def answer_in(heard: Message, sequences: set[int], request: int = Opcode.CALC_FILE_CRC32) -> FileMessage | None:
    answer = unpack(heard) if isinstance(heard, FileTransfer) else None
    is_ours = answer is not None and answer.sequence in sequences and answer.request == request
    return answer if is_ours else None


def file_checksum(data: bytes) -> int:
    """ArduPilot's CRC-32 with initial value 0 and no final XOR."""
    return zlib.crc32(data, 0xFFFFFFFF) ^ 0xFFFFFFFF


def ask_of_file(question: FileMessage, action: str, may_end: bool = False) -> Dialogue[FileMessage]:
    sequences = {(question.sequence + 1) & 0xFFFF}
    step = Ask(question.pack(), item=True)
    try:
        answer = yield from hear(step, lambda heard: answer_in(heard, sequences, question.opcode))
    except NoAnswer:
        raise NoAnswer(f"the vehicle does not answer when asked to {action}") from None
    assert answer is not None, "only a pause ends without an answer"
    if answer.opcode == Opcode.ACK or (may_end and answer.data[:1] == bytes((FileError.END_OF_FILE,))):
        return answer
    raise FileRefused(f"the vehicle would not {action} (error {answer.data[0] if answer.data else 0})")
