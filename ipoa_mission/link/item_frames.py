"""Exchange frames of a run of items, whose next frame is known."""

from fastcrc.crc16 import mcrf4xx

from ipoa_mission.link.codec import HEADER_BYTES, MAGIC_2, SIGNATURE_BYTES, SIGNED, Codec, Target
from ipoa_mission.link.definitions import definition_of
from ipoa_mission.link.item_payloads import MISSION_TYPE, PAYLOAD_BYTES, SEQ, TARGET
from ipoa_mission.link.item_run import ItemRun, ItemsRead, ItemsSent

_ITEM = definition_of("MISSION_ITEM_INT")
_REQUEST = definition_of("MISSION_REQUEST_INT")
_OLD_REQUEST = definition_of("MISSION_REQUEST")


class ItemFrames:
    def __init__(self, run: ItemRun, codec: Codec, target: Target) -> None:
        self.run = run
        self._codec = codec
        self._end = bytes((codec.system, codec.component, run.kind)).rstrip(b"\0")
        self._flags = SIGNED if codec.signer else 0
        self._tail = 2 + (SIGNATURE_BYTES if codec.signer else 0)
        heard = (_ITEM,) if isinstance(run, ItemsRead) else (_REQUEST, _OLD_REQUEST)
        #: By the header bytes of sender and number.
        self._extras = {bytes(target) + one.number.to_bytes(3, "little"): bytes((one.crc_extra,)) for one in heard}
        if isinstance(run, ItemsSent):
            packed = run.payloads.copy()
            packed["target"] = target
            whole = packed.tobytes()
            self._reply_definition = _ITEM
            self._payloads = [
                whole[at : at + PAYLOAD_BYTES].rstrip(b"\0") for at in range(0, len(whole), PAYLOAD_BYTES)
            ]
        else:
            end = bytes((*target, run.kind)).rstrip(b"\0")
            self._reply_definition = _REQUEST
            self._payloads = [seq.to_bytes(2, "little") + end for seq in range(run.count)]

    def take(self, frame: bytes) -> bool:
        """Return whether a frame is the run's next step."""
        extra = self._extras.get(frame[5:HEADER_BYTES])
        if extra is None or frame[0] != MAGIC_2 or frame[2] != self._flags:
            return False
        end = HEADER_BYTES + frame[1]
        if len(frame) != end + self._tail or mcrf4xx(frame[1:end] + extra) != frame[end] | frame[end + 1] << 8:
            return False
        run, payload = self.run, frame[HEADER_BYTES:end]
        if isinstance(run, ItemsRead):
            payload = payload.ljust(PAYLOAD_BYTES, b"\0")[:PAYLOAD_BYTES]
            place = payload[SEQ : SEQ + 2] + payload[TARGET : TARGET + 2] + payload[MISSION_TYPE:].rstrip(b"\0")
        else:
            place = payload.rstrip(b"\0")
        seq = run.at if isinstance(run, ItemsRead) else run.at + 1
        if place != seq.to_bytes(2, "little") + self._end:
            return False
        if (signer := self._codec.signer) and not signer.accepts(frame, frame[5], frame[6]):
            return False
        if isinstance(run, ItemsRead):
            run.keep(payload)
            run.at += 1
        else:
            run.is_legacy = frame[7] == _OLD_REQUEST.number
            run.asked_for(seq)
        return True

    def reply(self, unix_s: float) -> bytes:
        return self._codec.frame(self._reply_definition, self._payloads[self.run.at], unix_s)
