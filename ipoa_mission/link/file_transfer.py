"""MAVFTP dialogues: whole files, and the checksum of ArduPilot's lists."""

import zlib
from collections.abc import Iterator, Mapping

from ipoa_mission.errors import MissionError
from ipoa_mission.link.dialogue import Ask, Dialogue, NoAnswer, Pause, Remark, Step
from ipoa_mission.link.mavftp import LONGEST_DATA, FileError, FileMessage, Opcode, unpack
from ipoa_mission.link.messages import FileTransfer, Message, MissionType
from ipoa_mission.progress import Progress, count, silent

MISSION_FILE = "@MISSION/mission.dat"
LIST_FILES: Mapping[int, str] = {
    MissionType.MISSION: MISSION_FILE,
    MissionType.FENCE: "@MISSION/fence.dat",
    MissionType.RALLY: "@MISSION/rally.dat",
}
CHECKSUM_S = (0.5,) * 4 + (1.0,) * 6 + (2.0,) * 8


class FileRefused(MissionError):
    pass


def write_file(path: str, data: bytes, progress: Progress = silent) -> Dialogue[FileMessage]:
    """The returned message closes the file; raise FileRefused or NoAnswer."""
    yield from ask_of_file(FileMessage(0, Opcode.RESET_SESSIONS), "reset the file service")
    opened = yield from ask_of_file(FileMessage(2, Opcode.CREATE_FILE, data=path.encode()), f"create {path}")
    sequence = 4
    for at in range(0, len(data), LONGEST_DATA):
        piece = data[at : at + LONGEST_DATA]
        question = FileMessage(sequence, Opcode.WRITE_FILE, opened.session, offset=at, data=piece)
        yield from ask_of_file(question, f"write {path}")
        sequence = sequence + 2 & 0xFFFF
        count(progress, at + len(piece), len(data))
    return FileMessage(sequence, Opcode.TERMINATE_SESSION, opened.session)


def read_file(path: str) -> Dialogue[bytes]:
    yield from ask_of_file(FileMessage(0, Opcode.RESET_SESSIONS), "reset the file service")
    opened = yield from ask_of_file(FileMessage(2, Opcode.OPEN_FILE_RO, data=path.encode()), f"open {path}")
    data = b""
    sequence = 4
    while True:
        question = FileMessage(sequence, Opcode.READ_FILE, opened.session, offset=len(data), size=LONGEST_DATA)
        answer = yield from ask_of_file(question, f"read {path}", may_end=True)
        sequence = sequence + 2 & 0xFFFF
        if answer.opcode == Opcode.NAK or not answer.data:
            break
        data += answer.data
    yield from ask_of_file(FileMessage(sequence, Opcode.TERMINATE_SESSION, opened.session), f"close {path}")
    return data


def list_checksum(kind: int, numbers: Iterator[int]) -> Dialogue[int | None]:
    """Return the checksum of a list with home, None if unsupported; raise NoAnswer.

    Each question takes a new sequence number: a repeated one gets its old answer.
    """
    asked: set[int] = set()
    for seconds in CHECKSUM_S:
        yield Remark(checksum_question(kind, numbers, asked))
        heard = yield Pause(seconds)
        while heard is not None:
            if (answer := _answer_in(heard, asked)) is not None:
                return _checksum(answer)
            heard = yield None
    raise NoAnswer(f"the vehicle does not answer when asked for the checksum of {LIST_FILES[kind]}")


def checksum_question(kind: int, numbers: Iterator[int], asked: set[int]) -> FileTransfer:
    """Add the answer's number to `asked`."""
    question = FileMessage(next(numbers) & 0xFFFF, Opcode.CALC_FILE_CRC32, data=LIST_FILES[kind].encode())
    asked.add((question.sequence + 1) & 0xFFFF)
    return question.pack()


def checksum_in(heard: Message, asked: set[int]) -> int | None:
    answer = _answer_in(heard, asked)
    return None if answer is None else _checksum(answer)


def _answer_in(heard: Message, asked: set[int]) -> FileMessage | None:
    answer = unpack(heard) if isinstance(heard, FileTransfer) else None
    is_ours = answer is not None and answer.sequence in asked and answer.request == Opcode.CALC_FILE_CRC32
    return answer if is_ours else None


def _checksum(answer: FileMessage) -> int | None:
    return int.from_bytes(answer.data[:4], "little") if answer.opcode == Opcode.ACK else None


def file_checksum(data: bytes) -> int:
    """ArduPilot's CRC-32 with initial value 0 and no final XOR."""
    return zlib.crc32(data, 0xFFFFFFFF) ^ 0xFFFFFFFF


def ask_of_file(question: FileMessage, what: str, may_end: bool = False) -> Dialogue[FileMessage]:
    """Raise FileRefused or NoAnswer."""
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
