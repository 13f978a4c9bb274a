"""Transfer a list in order past its dialogue, which yields the run and takes the last item."""

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import ClassVar

from fastcrc.crc16 import mcrf4xx

from ipoa_mission.link.codec import HEADER_BYTES, MAGIC_2, SIGNATURE_BYTES, Codec, Target
from ipoa_mission.link.definitions import Definition, definition_of
from ipoa_mission.link.signing import SIGNED
from ipoa_mission.link.wire import ITEM
from ipoa_mission.mission.items import Item

REQUEST = definition_of("MISSION_REQUEST_INT")
OLD_REQUEST = definition_of("MISSION_REQUEST")


@dataclass
class ItemRun(ABC):
    """`at` is the item requested last, by either side; `wait_s` the time for its answer."""

    EXPECTED: ClassVar[Mapping[int, Definition]]
    REPLY: ClassVar[Definition]

    kind: int
    count: int
    at: int
    sent_s: float = field(default=0.0, init=False)
    wait_s: float = field(default=0.0, init=False)
    round_trip_s: float = field(default=0.0, init=False)

    @property
    def is_at_last_item(self) -> bool:
        return self.at >= self.count - 2

    def join(self, codec: Codec, target: Target) -> None:
        self._codec = codec
        self._target = target
        self._theirs = bytes(target)
        self._to_us = bytes((codec.system, codec.component, self.kind))
        self._to_them = bytes((*target, self.kind))
        self._flags, self._tail = (SIGNED, 2 + SIGNATURE_BYTES) if codec.signer else (0, 2)

    def answer(self, frame: bytes, unix_s: float) -> bytes | None:
        """Return the next frame to send, or None if `frame` is not the expected one."""
        codec = self._codec
        number = int.from_bytes(frame[7:HEADER_BYTES], "little")
        expected = self.EXPECTED.get(number)
        if expected is None or frame[5:7] != self._theirs or frame[0] != MAGIC_2 or frame[2] != self._flags:
            return None
        end = HEADER_BYTES + frame[1]
        if len(frame) != end + self._tail or mcrf4xx(frame[1:end] + expected.seed) != frame[end] | frame[end + 1] << 8:
            return None
        payload = frame[HEADER_BYTES:end]
        if not self.expects(payload) or (codec.signer and not codec.signer.accepts(frame, *self._target)):
            return None
        return codec.frame(self.REPLY, self.step(number, payload).rstrip(b"\0"), unix_s)

    @abstractmethod
    def expects(self, payload: bytes) -> bool: ...

    @abstractmethod
    def step(self, number: int, payload: bytes) -> bytes:
        """Take the expected message; return the payload of the reply."""


@dataclass
class ItemsSent(ItemRun):
    """`payloads`: for any target."""

    EXPECTED: ClassVar = {REQUEST.number: REQUEST, OLD_REQUEST.number: OLD_REQUEST}
    REPLY = ITEM

    payloads: Sequence[bytes] = ()
    asked: Callable[[int], None] = lambda seq: None
    doubt: int | None = None  # a refusal without a later request
    is_legacy: bool = False  # by MISSION_REQUEST

    def asked_for(self, seq: int) -> None:
        self.at = seq
        self.doubt = None
        self.asked(seq)

    def expects(self, payload: bytes) -> bool:
        return payload.ljust(REQUEST.layout.size, b"\0") == (self.at + 1).to_bytes(2, "little") + self._to_us

    def step(self, number: int, payload: bytes) -> bytes:
        self.is_legacy = number == OLD_REQUEST.number
        self.asked_for(self.at + 1)
        item = self.payloads[self.at]
        return item[:32] + self._theirs + item[34:]


@dataclass
class ItemsRead(ItemRun):
    EXPECTED: ClassVar = {ITEM.number: ITEM}
    REPLY = REQUEST

    take: Callable[[int, Item | bytes], int]

    def expects(self, payload: bytes) -> bool:
        place = payload[28:30] + payload[32:34] + (payload[37:] or b"\0")
        return place == self.at.to_bytes(2, "little") + self._to_us

    def step(self, number: int, payload: bytes) -> bytes:
        self.take(self.at, payload.ljust(ITEM.layout.size, b"\0"))
        self.at += 1
        return self.at.to_bytes(2, "little") + self._to_them
