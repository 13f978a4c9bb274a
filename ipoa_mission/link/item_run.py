"""Transfer a list in order without its dialogue: the frame expected next is known.

A dialogue yields a run with its step. `Line.carry_on` answers the expected frames through `ItemFrames`.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TypeAlias

from fastcrc.crc16 import mcrf4xx

from ipoa_mission.link.codec import HEADER_BYTES, MAGIC_2, SIGNATURE_BYTES, Codec, Target
from ipoa_mission.link.definitions import definition_of
from ipoa_mission.link.item_payloads import PAYLOAD, Payloads, pack_items
from ipoa_mission.link.messages import Message, Request
from ipoa_mission.link.signing import SIGNED
from ipoa_mission.mission.items import Item


@dataclass
class _Run:
    """`at` is the item requested last, by either side; `wait_s`: timeout for its answer."""

    kind: int
    count: int
    at: int = -1
    sent_s: float = 0.0
    wait_s: float = 0.0
    round_trip_s: float = 0.0

    @property
    def is_at_last_item(self) -> bool:
        """The dialogue takes the last step."""
        return self.at >= self.count - 2


@dataclass
class ItemsSent(_Run):
    items: Sequence[Item] = ()
    packed: Payloads | None = None
    asked: Callable[[int], None] = lambda seq: None
    is_legacy: bool = False  # by MISSION_REQUEST
    doubt: int | None = None  # a refusal without a later request

    def asked_for(self, seq: int) -> None:
        self.at, self.doubt = seq, None
        self.asked(seq)

    @property
    def acted_on(self) -> Message:
        return Request(self.at, self.kind, self.is_legacy)


@dataclass
class ItemsRead(_Run):
    keep: Callable[[bytes], None] = lambda payload: None

    @property
    def question(self) -> Message:
        return Request(self.at, self.kind)


ItemRun: TypeAlias = ItemsSent | ItemsRead


class ItemFrames:
    """Take the frames of a run with one target, and make its replies."""

    SEQ, TARGET, MISSION_TYPE = (PAYLOAD.fields[name][1] for name in ("seq", "target", "mission_type"))  # type: ignore[index]

    def __init__(self, run: ItemRun, codec: Codec, target: Target) -> None:
        self.run = run
        self._codec = codec
        self._end = bytes((codec.system, codec.component, run.kind)).rstrip(b"\0")
        self._flags = SIGNED if codec.signer else 0
        self._tail = 2 + (SIGNATURE_BYTES if codec.signer else 0)
        item, request, old_request = map(definition_of, ("MISSION_ITEM_INT", "MISSION_REQUEST_INT", "MISSION_REQUEST"))
        self._old_number = old_request.number
        if isinstance(run, ItemsSent):
            expected, self._reply_definition = [request, old_request], item
            packed = (pack_items(run.items, run.kind) if run.packed is None else run.packed).copy()
            packed["target"] = target
            self._payloads = [payload.tobytes().rstrip(b"\0") for payload in packed]
        else:
            expected, self._reply_definition = [item], request
            end = bytes((*target, run.kind)).rstrip(b"\0")
            self._payloads = [seq.to_bytes(2, "little") + end for seq in range(run.count)]
        #: By the header bytes of sender and number.
        self._seeds = {bytes(target) + frame.number.to_bytes(3, "little"): frame.seed for frame in expected}

    def take(self, frame: bytes) -> bool:
        """Return whether a frame is the run's next step."""
        seed = self._seeds.get(frame[5:HEADER_BYTES])
        if seed is None or frame[0] != MAGIC_2 or frame[2] != self._flags:
            return False
        end = HEADER_BYTES + frame[1]
        if len(frame) != end + self._tail or mcrf4xx(frame[1:end] + seed) != frame[end] | frame[end + 1] << 8:
            return False
        run, payload = self.run, frame[HEADER_BYTES:end]
        if isinstance(run, ItemsRead):
            seq, size = run.at, PAYLOAD.itemsize
            payload = payload.ljust(size, b"\0")[:size]
            to = payload[self.TARGET : self.TARGET + 2] + payload[self.MISSION_TYPE :].rstrip(b"\0")
            place = payload[self.SEQ : self.SEQ + 2] + to
        else:
            seq, place = run.at + 1, payload.rstrip(b"\0")
        if place != seq.to_bytes(2, "little") + self._end:
            return False
        if (signer := self._codec.signer) and not signer.accepts(frame, frame[5], frame[6]):
            return False
        if isinstance(run, ItemsRead):
            run.keep(payload)
            run.at += 1
        else:
            run.is_legacy = frame[7] == self._old_number
            run.asked_for(seq)
        return True

    def reply(self, unix_s: float) -> bytes:
        return self._codec.frame(self._reply_definition, self._payloads[self.run.at], unix_s)
