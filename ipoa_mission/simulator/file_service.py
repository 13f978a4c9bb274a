"""MAVFTP: ArduPilot's mission file, and the checksums of the lists."""

from collections.abc import Callable
from dataclasses import dataclass, field

from ipoa_mission.errors import MissionError
from ipoa_mission.link import mavftp
from ipoa_mission.link.codec import Target
from ipoa_mission.link.mavftp import LONGEST_DATA, FileError, FileMessage, Opcode, nak
from ipoa_mission.link.messages import FileTransfer, MissionType
from ipoa_mission.link.wire import ITEM
from ipoa_mission.mission.items import Item


@dataclass
class FileSession:
    """A repeated request gets the last answer again."""

    reading: bytes | None = None
    writing: bytearray | None = None
    last: FileMessage | None = None


@dataclass
class FileService:
    """`replace` returns False if it refuses a mission."""

    is_offered: bool
    most_items: int
    listed: Callable[[int], tuple[Item, ...]]
    replace: Callable[[tuple[Item, ...]], bool]
    _sessions: dict[Target, FileSession] = field(default_factory=dict)

    def answer(self, message: FileTransfer, client: Target) -> FileTransfer:
        question = mavftp.unpack(message)
        session = self._sessions.setdefault(client, FileSession())
        last = session.last
        if last is None or last.sequence != (question.sequence + 1) & 0xFFFF or last.request != question.opcode:
            last = self._act(question, session)
            session.last = last
        return last.pack()

    def _act(self, question: FileMessage, session: FileSession) -> FileMessage:
        match question.opcode:
            case Opcode.RESET_SESSIONS:
                session.reading = session.writing = None
                return _ack(question)
            case Opcode.OPEN_FILE_RO | Opcode.CREATE_FILE:
                return self._open(question, session)
            case Opcode.CALC_FILE_CRC32:
                return self._sum_up(question)
            case Opcode.READ_FILE if session.reading is not None:
                size = min(question.size or LONGEST_DATA, LONGEST_DATA)
                piece = session.reading[question.offset : question.offset + size]
                return _ack(question, piece) if piece else nak(question, FileError.END_OF_FILE)
            case Opcode.WRITE_FILE if session.writing is not None:
                end = question.offset + len(question.data)
                longest = mavftp.LIST_HEADER.size + self.most_items * ITEM.layout.size
                if question.offset > len(session.writing) or end > longest:
                    return nak(question, FileError.FAIL)
                session.writing[question.offset : end] = question.data
                return _ack(question)
            case Opcode.TERMINATE_SESSION:
                return self._close(question, session)
            case Opcode.READ_FILE | Opcode.WRITE_FILE:
                return nak(question, FileError.INVALID_SESSION)
        return nak(question, FileError.UNKNOWN_COMMAND)

    def _open(self, question: FileMessage, session: FileSession) -> FileMessage:
        if not self.is_offered or question.data.rstrip(b"\0") != mavftp.MISSION_FILE.encode():
            return nak(question, FileError.FILE_NOT_FOUND)
        if question.opcode == Opcode.CREATE_FILE:
            session.reading = None
            session.writing = bytearray()
            return _ack(question)
        session.reading = mavftp.pack_mission(self.listed(MissionType.MISSION))
        session.writing = None
        return _ack(question, len(session.reading).to_bytes(4, "little"))

    def _sum_up(self, question: FileMessage) -> FileMessage:
        name = question.data.rstrip(b"\0")
        kind = next((kind for kind, path in mavftp.LIST_FILES.items() if path.encode() == name), None)
        if not self.is_offered or kind is None:
            return nak(question, FileError.FAIL)
        return _ack(question, mavftp.file_checksum(mavftp.pack_mission(self.listed(kind), kind)).to_bytes(4, "little"))

    def _close(self, question: FileMessage, session: FileSession) -> FileMessage:
        written = session.writing
        session.reading = session.writing = None
        if written is None:
            return _ack(question)
        try:
            taken = self.replace(mavftp.unpack_mission(bytes(written)))
        except MissionError:
            taken = False
        return _ack(question) if taken else nak(question, FileError.FAIL)


def _ack(question: FileMessage, data: bytes = b"") -> FileMessage:
    sequence = (question.sequence + 1) & 0xFFFF
    return FileMessage(sequence, Opcode.ACK, question.session, question.opcode, question.offset, data)
