import struct
from dataclasses import dataclass
from enum import IntEnum

from ipoa_mission.link.messages import FileTransfer

HEADER = struct.Struct("<HBBBBBBI")
LONGEST_DATA = 251 - HEADER.size


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
    ends_burst: bool = False

    def pack(self) -> FileTransfer:
        size = len(self.data) if self.size is None else self.size
        head = HEADER.pack(
            self.sequence & 0xFFFF, self.session, self.opcode, size, self.request, self.ends_burst, 0, self.offset
        )
        return FileTransfer((head + self.data).ljust(251, b"\0"))


def unpack(message: FileTransfer) -> FileMessage:
    """`size` may exceed the data."""
    sequence, session, opcode, size, request, ends_burst, _, offset = HEADER.unpack_from(message.payload)
    data = message.payload[HEADER.size : HEADER.size + size]
    return FileMessage(sequence, opcode, session, request, offset, data, size, bool(ends_burst))


def nak(question: FileMessage, error: FileError) -> FileMessage:
    return FileMessage(
        (question.sequence + 1) & 0xFFFF, Opcode.NAK, question.session, question.opcode, 0, bytes((error,))
    )
