"""MAVLink 2 signing: who may speak, and that nothing is replayed.

A signature is the first six bytes of SHA-256 over key, frame, link id and a timestamp in 10 us since 2015. Timestamps
must only grow, across restarts too: the file keeps a mark ahead of every timestamp that was ever used.
"""

import hashlib
import hmac
from collections.abc import Callable
from pathlib import Path

from ipoa_mission.errors import BadInput
from ipoa_mission.files import read_text, write_atomically

EPOCH_2015_S = 1_420_070_400
TICKS_PER_S = 100_000
NEW_STREAM_TICKS = 60 * TICKS_PER_S  # a stream first heard may be this much behind us
RESERVE_TICKS = 30 * TICKS_PER_S
SIGNED_FLAG = 0x01
KEY_BYTES = 32


def read_key(path: str | Path) -> bytes:
    """The key in a file: 32 raw bytes, 64 hexadecimal digits, or a passphrase.

    Raises:
        BadInput: the file cannot be read, or is empty.
    """
    try:
        raw = Path(path).read_bytes()
    except OSError as error:
        raise BadInput(f"{path}: cannot be read: {error.strerror}") from error
    return raw if len(raw) == KEY_BYTES else key_of(raw.decode("utf-8", "surrogateescape"))


def key_of(words: str) -> bytes:
    """The key behind 64 hexadecimal digits, or else the SHA-256 of a passphrase, as ground stations do it."""
    words = words.strip()
    if not words:
        raise BadInput("signing key: expected 64 hexadecimal digits or a passphrase, not nothing")
    try:
        key = bytes.fromhex(words)
    except ValueError:
        key = b""
    return key if len(key) == KEY_BYTES else hashlib.sha256(words.encode("utf-8", "surrogateescape")).digest()


class Signer:
    """Signs what we say and judges what we hear, with one key."""

    def __init__(self, key: bytes, link_id: int = 0, mark: int = 0, keep: Callable[[int], None] | None = None) -> None:
        self.key = key
        self.link_id = link_id
        self._last = mark
        self._mark = mark
        self._keep = keep
        self._streams: dict[tuple[int, int, int], int] = {}

    def signature(self, frame: bytes, unix_s: float) -> bytes:
        """The 13 bytes that follow a frame said at `unix_s`."""
        self._last = max(self._last + 1, round((unix_s - EPOCH_2015_S) * TICKS_PER_S))
        if self._last >= self._mark:
            self._mark = self._last + RESERVE_TICKS
            if self._keep:
                self._keep(self._mark)
        stamp = bytes((self.link_id,)) + self._last.to_bytes(6, "little")
        return stamp + self._digest(frame + stamp)

    def accepts(self, frame: bytes, system: int, component: int) -> bool:
        """Whether a frame is signed with our key, and newer than all before it in its stream."""
        if frame[0] != 0xFD or not frame[2] & SIGNED_FLAG:
            return False
        if not hmac.compare_digest(self._digest(frame[:-6]), frame[-6:]):
            return False
        stream = (frame[-13], system, component)
        stamp = int.from_bytes(frame[-12:-6], "little")
        if stamp <= self._streams.get(stream, self._last - NEW_STREAM_TICKS - 1):
            return False
        self._streams[stream] = stamp
        self._last = max(self._last, stamp)
        return True

    def _digest(self, data: bytes) -> bytes:
        return hashlib.sha256(self.key + data).digest()[:6]


def persistent_signer(key: bytes, path: str | Path, link_id: int = 0) -> Signer:
    """A signer whose timestamps go on growing from one run to the next; `path` holds the mark.

    Raises:
        BadInput: the file holds something else than a timestamp.
    """
    mark = 0
    path = Path(path)
    if path.exists():
        words = read_text(path).strip()
        if not words.isdecimal():
            raise BadInput(f"{path}: expected a timestamp of MAVLink signing, not {words[:20]!r}")
        mark = int(words)
    return Signer(key, link_id, mark, lambda ahead: write_atomically(path, f"{ahead}\n"))
