"""Convert messages to MAVLink frames and back; keep unknown senders, and good frames after a corrupt length.

A record of a telemetry log (`.tlog`) is the time [us since 1970] as eight bytes big-endian, and the raw frame.
"""

import errno
import logging
import os
import re
import struct
from collections import Counter
from collections.abc import Generator, Iterable, Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import BinaryIO, NamedTuple

from fastcrc.crc16 import mcrf4xx

from ipoa_mission.errors import Unwritable
from ipoa_mission.files import note_written, read_bytes
from ipoa_mission.link import wire
from ipoa_mission.link.definitions import DEFINITIONS, Definition, definition_of
from ipoa_mission.link.messages import ItemAt, Message, Text
from ipoa_mission.link.signing import SIGNED, Signer
from ipoa_mission.mission.item_words import count_words

log = logging.getLogger(__name__)
MAGIC_1 = 0xFE
MAGIC_2 = 0xFD
HEADER_BYTES = 10
SIGNATURE_BYTES = 13
STAMP_BYTES = 8
#: Start of a frame; of the MAVLink 2 flags only the signature's is known.
_BEGINNING = re.compile(rb"\xfe|\xfd(?=.[\x00\x01]|.?\Z)", re.DOTALL)


class Target(NamedTuple):
    system: int
    component: int


EVERYONE = Target(0, 0)


@dataclass(frozen=True)
class Heard:
    """`raw` is its frame, `message` None if unused."""

    system: int
    component: int
    target: Target
    message: Message | None
    raw: bytes

    def is_for(self, system: int, component: int) -> bool:
        return self.target.system in (0, system) and self.target.component in (0, component)


@dataclass
class Codec:
    system: int
    component: int
    signer: Signer | None = None
    _sequence: int = 0

    def encode(self, message: Message, target: Target, unix_s: float) -> bytes:
        if isinstance(message, ItemAt):
            payload = wire.item_payload(message.seq, message.item, message.kind, target)
            return self.frame(wire.ITEM, payload.rstrip(b"\0"), unix_s)
        name, fields = wire.write(message)
        definition = definition_of(name)
        addressed = {"target_system": target.system, "target_component": target.component, **fields}
        return self.frame(definition, definition.pack(addressed), unix_s)

    def frame(self, definition: Definition, payload: bytes, unix_s: float) -> bytes:
        """`payload` has no trailing zeros."""
        flags = SIGNED if self.signer else 0
        sender = (self._sequence, self.system, self.component)
        body = struct.pack("<6B", len(payload), flags, 0, *sender) + definition.number.to_bytes(3, "little") + payload
        self._sequence = (self._sequence + 1) % 256
        frame = b"\xfd" + body + mcrf4xx(body + definition.seed).to_bytes(2, "little")
        return frame if self.signer is None else frame + self.signer.signature(frame, unix_s)

    def decode(self, frame: bytes) -> Heard | None:
        definition = DEFINITIONS[number_of(frame)]
        (system, component), _ = numbered(frame)
        is_radio = definition.name == "RADIO_STATUS"  # never signed
        if self.signer and not self.signer.accepts(frame, system, component) and not is_radio:
            return None
        if not wire.is_read(definition.name):
            return Heard(system, component, EVERYONE, None, frame)
        raw = definition.unpack(frame[6:-2] if is_old(frame) else frame[HEADER_BYTES : HEADER_BYTES + frame[1]])
        target = Target(getattr(raw, "target_system", 0), getattr(raw, "target_component", 0))
        return Heard(system, component, target, wire.read(definition.name, raw), frame)


class _Begun(NamedTuple):
    text: Text  # chunks so far
    number: int  # of the sender's last frame
    ends_s: float
    end: str = ""

    @property
    def whole(self) -> Text:
        raw = f"{self.text.text}{self.end}".encode("utf-8", "surrogateescape")
        return replace(self.text, text=raw.decode("utf-8", "replace"), chunk_seq=0)


class LongTexts:
    """Join chunks of STATUSTEXT; `GAP` is a missing one. After one of 50 bytes PX4 may send no other."""

    GAP = "[...]"
    WAIT_S = 1.0

    def __init__(self) -> None:
        self._begun: dict[Target, _Begun] = {}

    def joined(self, heard: Iterable[Heard], now_s: float) -> Iterator[Heard]:
        """Yield each frame; a text that none ended has no `raw`."""
        for each in heard:
            sender = Target(each.system, each.component)
            number = numbered(each.raw)[1] if each.raw else 0
            begun = self._begun.pop(sender, None)
            if begun is not None and number != (begun.number + 1) % 256 and each.raw:
                begun = begun._replace(end=self.GAP)
            chunk = each.message
            if begun is not None and not isinstance(chunk, Text):
                self._begun[sender] = begun._replace(number=number)
            if not isinstance(chunk, Text):
                yield each
                continue
            if begun is not None and (chunk.id != begun.text.id or chunk.chunk_seq <= begun.text.chunk_seq):
                yield replace(each, message=begun.whole, raw=b"")
                begun = None
            before = replace(chunk, text="", chunk_seq=-1) if begun is None else begun.text
            text = before.text + self.GAP * (chunk.chunk_seq - before.chunk_seq - 1) + chunk.text
            begun = _Begun(replace(chunk, text=text), number, now_s + self.WAIT_S)
            is_last = chunk.id == 0 or len(chunk.text.encode("utf-8", "surrogateescape")) < 50
            self._begun |= {} if is_last else {sender: begun}
            yield replace(each, message=begun.whole if is_last else None)
        for sender in [sender for sender, begun in self._begun.items() if now_s > begun.ends_s]:
            yield Heard(*sender, EVERYONE, self._begun.pop(sender).whole, b"")


class Framer:
    def __init__(self) -> None:
        self.buffer = b""

    def feed(self, data: bytes) -> Iterator[bytes]:
        """Yield completed good frames; buffer one at most."""
        if self.buffer and frame_at(data, 0):  # the rest of the buffered one is lost
            yield from frames(self.buffer)
            self.buffer = b""
        self.buffer = yield from frames(self.buffer + data, more_follows=True)


def frames(data: bytes, more_follows: bool = False) -> Generator[bytes, None, bytes]:
    """Yield good frames; return a begun one if `more_follows`."""
    start = next_magic(data, 0)
    while start >= 0:
        if more_follows and not frame_length(data, start):
            return data[start:]
        frame = frame_at(data, start)
        if frame:
            yield frame
        start = next_magic(data, start + (len(frame) if frame else 1))
    return b""


def frame_at(data: bytes, start: int) -> bytes | None:
    """Return a known message's whole frame with the right checksum."""
    frame = data[start : start + frame_length(data, start)]
    definition = DEFINITIONS.get(number_of(frame)) if frame else None
    if definition is None or (frame[1] > definition.layout.size if is_old(frame) else frame[2] & ~SIGNED):
        return None
    end = len(frame) - (SIGNATURE_BYTES if is_signed(frame) else 0)
    is_whole = mcrf4xx(frame[1 : end - 2] + definition.seed) == int.from_bytes(frame[end - 2 : end], "little")
    return frame if is_whole else None


def number_of(frame: bytes) -> int:
    return frame[5] if is_old(frame) else int.from_bytes(frame[7:10], "little")


def numbered(frame: bytes) -> tuple[tuple[int, int], int]:
    """Return the sender (system, component) and the sequence number modulo 256."""
    first = 2 if is_old(frame) else 4
    return (frame[first + 1], frame[first + 2]), frame[first]


def is_old(frame: bytes) -> bool:
    return frame[0] == MAGIC_1


def is_signed(frame: bytes) -> bool:
    return frame[0] == MAGIC_2 and bool(frame[2] & SIGNED)


def next_magic(data: bytes, at: int) -> int:
    match = _BEGINNING.search(data, at)
    return match.start() if match else -1


def frame_length(data: bytes, start: int) -> int:
    """Return 0 unless the header and all its bytes are there."""
    if len(data) < start + 3 or data[start] not in (MAGIC_1, MAGIC_2):
        return 0
    length = data[start + 1] + 2 + (6 if data[start] == MAGIC_1 else HEADER_BYTES)
    if data[start] == MAGIC_2 and data[start + 2] & SIGNED:
        length += SIGNATURE_BYTES
    return length if start + length <= len(data) else 0


class TlogWriter:
    """A full disk ends the log with a warning, not the flight."""

    def __init__(self, path: str | Path) -> None:
        self._path = path
        self._is_over = False
        try:
            self._file: BinaryIO = Path(path).open("wb", buffering=0)  # noqa: SIM115
        except OSError as error:
            raise Unwritable(f"cannot be written: {error.strerror}", place=path) from error
        except ValueError as error:
            raise Unwritable("expected a name without a NUL character", place=path) from error
        note_written(Path(path))

    def write(self, frame: bytes, unix_s: float) -> None:
        record = round(unix_s * 1e6).to_bytes(STAMP_BYTES, "big") + frame
        try:
            if not self._is_over and self._file.write(record) < len(record):
                raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        except OSError as error:
            self._is_over = True
            log.warning("%s: cannot be written any more: %s; the log ends here", self._path, error.strerror)

    def close(self) -> None:
        self._file.close()


@dataclass(frozen=True)
class Record:
    unix_s: float
    frame: bytes


@dataclass
class LostFrames:
    """Bytes outside frames, and missing sequence numbers by system."""

    torn_bytes: int = 0
    frames: Counter[int] = field(default_factory=Counter)
    there: Counter[int] = field(default_factory=Counter)

    def remarks(self, system: int) -> Iterator[str]:
        if self.torn_bytes:
            yield f"{count_words(self.torn_bytes, 'byte')} of the log in no whole message: it is damaged or cut short"
        if self.frames[system]:
            there = self.frames[system] + self.there[system]
            yield f"{self.frames[system]} of {there} messages of system {system} are not in the log, by their numbers"


def read_tlog(path: str | Path, missing: LostFrames | None = None) -> Iterator[Record]:
    """Skip torn records and wrong checksums, counted in `missing`; raise BadInput."""
    data = read_bytes(Path(path))
    at = 0
    missing = LostFrames() if missing is None else missing
    last: dict[tuple[int, int], int] = {}
    while at < len(data):
        start = at + STAMP_BYTES
        known = frame_at(data, start)
        frame = known or _unknown_frame(data, start)
        if frame is None:
            next_record = _next_record(data, start + 1)
            missing.torn_bytes += next_record - at
            at = next_record
            continue
        sender, number = numbered(frame)
        lost = (number - last.get(sender, number - 1) - 1) % 256
        missing.frames[sender[0]] += lost if lost < 128 else 0  # else it is reordered
        missing.there[sender[0]] += 1
        last[sender] = number
        if known:
            yield Record(int.from_bytes(data[at:start], "big") / 1e6, frame)
        at = start + len(frame)


def _next_record(data: bytes, at: int) -> int:
    start = next_magic(data, at)
    while start >= 0 and not frame_at(data, start):
        start = next_magic(data, start + 1)
    return len(data) if start < 0 else start - STAMP_BYTES


def _unknown_frame(data: bytes, start: int) -> bytes | None:
    """Return an unknown message's frame before another record or the end."""
    frame = data[start : start + frame_length(data, start)]
    if not frame or number_of(frame) in DEFINITIONS:
        return None
    end = start + len(frame)
    is_followed = end == len(data) or next_magic(data, end + STAMP_BYTES) == end + STAMP_BYTES
    return frame if is_followed else None
