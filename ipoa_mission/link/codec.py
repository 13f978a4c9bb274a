"""Convert messages to MAVLink frames and back.

pymavlink's parser drops the sender of an unknown message, and a good frame after a corrupt length. It records a
signature's timestamp unchecked.
"""

import re
import struct
from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple

from fastcrc.crc16 import mcrf4xx

from ipoa_mission.link import wire
from ipoa_mission.link.definitions import DEFINITIONS, Definition, definition_of
from ipoa_mission.link.messages import Message
from ipoa_mission.link.signing import Signer

MAGIC_1, MAGIC_2 = 0xFE, 0xFD
SIGNED = 0x01  # incompat_flags bit
HEADER_BYTES = 10
SIGNATURE_BYTES = 13
#: Start of a frame; of the MAVLink 2 flags only the signature's is known.
_BEGINNING = re.compile(rb"\xfe|\xfd(?=.[\x00\x01]|.?\Z)", re.DOTALL)
RADIO_STATUS = "RADIO_STATUS"
_HEADER = struct.Struct("<BBBBBBHB")  # after the magic byte
_MAGIC_2 = bytes((MAGIC_2,))


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


def checksum(frame: bytes, crc_extra: int) -> int:
    return mcrf4xx(frame[1:] + bytes((crc_extra,)))


class Codec:
    def __init__(self, system: int, component: int, signer: Signer | None = None) -> None:
        self.system = system
        self.component = component
        self.signer = signer
        self._sequence = 0

    def encode(self, message: Message, target: Target, unix_s: float) -> bytes:
        name, fields = wire.write(message)
        definition = definition_of(name)
        addressed = {"target_system": target.system, "target_component": target.component, **fields}
        return self.frame(definition, definition.pack(addressed), unix_s)

    def frame(self, definition: Definition, payload: bytes, unix_s: float) -> bytes:
        """`payload` has no trailing zeros."""
        signer = self.signer
        flags = SIGNED if signer else 0
        number = definition.number
        body = _HEADER.pack(
            len(payload), flags, 0, self._sequence, self.system, self.component, number & 0xFFFF, number >> 16
        )
        body += payload
        self._sequence = (self._sequence + 1) % 256
        frame = _MAGIC_2 + body + mcrf4xx(body + definition.seed).to_bytes(2, "little")
        return frame if signer is None else frame + signer.signature(frame, unix_s)

    def decode(self, frame: bytes) -> Heard | None:
        definition, system, component, payload = _parts(frame)
        if self.signer and not self.signer.accepts(frame, system, component) and definition.name != RADIO_STATUS:
            return None
        if definition.name not in wire.LAYOUTS:
            return Heard(system, component, EVERYONE, None, frame)
        raw = definition.unpack(payload)
        target = Target(getattr(raw, "target_system", 0), getattr(raw, "target_component", 0))
        return Heard(system, component, target, wire.read(definition.name, raw), frame)


class Framer:
    """Cut the bytes of one peer into whole frames."""

    def __init__(self) -> None:
        self._buffer = b""

    @property
    def is_torn(self) -> bool:
        return bool(self._buffer)

    def feed(self, data: bytes) -> Iterator[bytes]:
        """Yield completed good frames; buffer one at most."""
        self._buffer += data
        at = 0
        while (start := next_magic(self._buffer, at)) >= 0:
            length = _frame_length(self._buffer, start)
            if length is None or start + length > len(self._buffer):
                self._buffer = self._buffer[start:]
                return
            frame = frame_at(self._buffer, start)
            at = start + (len(frame) if frame else 1)
            if frame:
                yield frame
        self._buffer = b""

    def datagram(self, data: bytes) -> Iterator[bytes]:
        """Yield completed frames: some links split one over two datagrams."""
        first = frame_at(data, 0)
        if first is None:
            yield from self.feed(data)
            return
        kept, self._buffer = self._buffer, b""
        yield from frames(kept)
        yield first
        yield from self.feed(data[len(first) :])


def frames(data: bytes) -> Iterator[bytes]:
    at = 0
    while (start := next_magic(data, at)) >= 0:
        frame = frame_at(data, start)
        at = start + (len(frame) if frame else 1)
        if frame:
            yield frame


def frame_at(data: bytes, start: int) -> bytes | None:
    """Return a known message's whole frame with the right checksum."""
    length = _frame_length(data, start)
    if length is None or start + length > len(data):
        return None
    is_v2 = data[start] == MAGIC_2
    number = int.from_bytes(data[start + 7 : start + 10], "little") if is_v2 else data[start + 5]
    definition = DEFINITIONS.get(number)
    if definition is None or (data[start + 2] & ~SIGNED if is_v2 else data[start + 1] > definition.layout.size):
        return None
    frame = data[start : start + length]
    end = length - (SIGNATURE_BYTES if is_v2 and frame[2] & SIGNED else 0)
    is_whole = checksum(frame[: end - 2], definition.crc_extra) == int.from_bytes(frame[end - 2 : end], "little")
    return frame if is_whole else None


def unknown_frame(data: bytes, start: int) -> int:
    """Return the frame's length if its message is unknown, else 0."""
    length = _frame_length(data, start)
    if length is None or start + length > len(data):
        return 0
    number = int.from_bytes(data[start + 7 : start + 10], "little") if data[start] == MAGIC_2 else data[start + 5]
    return 0 if number in DEFINITIONS else length


def numbered(frame: bytes) -> tuple[tuple[int, int], int]:
    """Return the sender (system, component) and the sequence number modulo 256."""
    first = 2 if is_old(frame) else 4
    return (frame[first + 1], frame[first + 2]), frame[first]


def is_old(frame: bytes) -> bool:
    return frame[0] == MAGIC_1


def sender_of(frame: bytes) -> int:
    return frame[3 if is_old(frame) else 5]


def is_signed(frame: bytes) -> bool:
    return frame[0] == MAGIC_2 and bool(frame[2] & SIGNED)


def next_magic(data: bytes, at: int) -> int:
    match = _BEGINNING.search(data, at)
    return match.start() if match else -1


def _frame_length(data: bytes, start: int) -> int | None:
    if len(data) < start + 3 or data[start] not in (MAGIC_1, MAGIC_2):
        return None
    if data[start] == MAGIC_1:
        return 6 + data[start + 1] + 2
    return 10 + data[start + 1] + 2 + (SIGNATURE_BYTES if data[start + 2] & SIGNED else 0)


def _parts(frame: bytes) -> tuple[Definition, int, int, bytes]:
    if frame[0] == MAGIC_1:
        return DEFINITIONS[frame[5]], frame[3], frame[4], frame[6:-2]
    number = int.from_bytes(frame[7:10], "little")
    return DEFINITIONS[number], frame[5], frame[6], frame[10 : 10 + frame[1]]
