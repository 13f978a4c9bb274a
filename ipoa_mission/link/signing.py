"""Sign MAVLink 2 frames, and reject unsigned and replayed ones.

Timestamps (10 us since 2015) only grow, also across restarts. A vehicle adopts the greatest one heard, and ignores a
station that is a minute behind.
"""

import hashlib
import hmac
import logging
import os
import re
import stat
from enum import StrEnum
from pathlib import Path

from ipoa_mission.errors import BadInput, TooLarge, Unreadable
from ipoa_mission.link.timestamps import Timestamps, own_timestamps

log = logging.getLogger(__name__)
EPOCH_2015_S = 1_420_070_400
TICKS_PER_S = 100_000
NEW_STREAM_TICKS = 60 * TICKS_PER_S  # may be this far behind us
RESERVE_TICKS = TICKS_PER_S  # the file's lead while in use
SIGNED_FLAG = 0x01
KEY_BYTES = 32
MAX_SIGNERS = 16
_HEXADECIMAL = re.compile(rb"\s*([0-9a-fA-F]{64})\s*")


def read_key(path: str | Path) -> bytes:
    """Warn if others may write the file; raise BadInput."""
    path = Path(path)
    try:
        raw = path.read_bytes()
        mode = path.stat().st_mode
    except OSError as error:
        raise Unreadable(f"cannot be read: {error.strerror}", place=path) from error
    if os.name == "posix" and mode & (stat.S_IWGRP | stat.S_IWOTH):
        log.warning("%s: others than its owner may write this key: chmod 600 %s", path, path)
    return key_of(raw)


def key_of(secret: str | bytes) -> bytes:
    """Raise BadInput, else return 32 bytes.

    `secret`: 64 hexadecimal digits, 32 bytes that are not text, or a passphrase (SHA-256 without its line end).
    """
    raw = secret.encode("utf-8", "surrogateescape") if isinstance(secret, str) else secret
    if digits := _HEXADECIMAL.fullmatch(raw):
        return bytes.fromhex(digits[1].decode())
    is_text = _is_text(raw)
    if len(raw) == KEY_BYTES and not is_text:
        return raw
    words = raw.rstrip(b"\r\n")
    if not is_text or not words.strip():
        what = "nothing" if not raw.strip() else f"{len(raw)} bytes that are no text"
        raise BadInput(f"expected 64 hexadecimal digits, 32 bytes or a passphrase, not {what}", place="signing key")
    return hashlib.sha256(words).digest()


def _is_text(raw: bytes) -> bool:
    try:
        return all(letter.isprintable() or letter.isspace() for letter in raw.decode())
    except UnicodeDecodeError:
        return False


class Doubt(StrEnum):
    UNSIGNED = "unsigned"
    FOREIGN = "foreign"  # another key
    STALE = "stale"  # our key, but not newer than the last frame


class Signer:
    def __init__(self, key: bytes, link_id: int = 0, timestamps: Timestamps | None = None) -> None:
        self.key = key
        self.link_id = link_id
        self._timestamps = timestamps
        self._last = timestamps.last if timestamps else 0
        self._mark = self._last
        self._is_warned = False
        self._streams: dict[tuple[int, int, int], int] = {}
        self.doubts: dict[tuple[int, int], Doubt] = {}
        """Last reason for rejecting a frame, by system and component."""

    def signature(self, frame: bytes, unix_s: float) -> bytes:
        """Return the 13 bytes that follow a frame sent at `unix_s`."""
        clock = round((unix_s - EPOCH_2015_S) * TICKS_PER_S)
        if self._last > clock + NEW_STREAM_TICKS and not self._is_warned:
            self._is_warned = True
            log.warning(
                "signing goes on from timestamps that are %.0f s ahead of this computer's clock: was it set back? "
                "The vehicle may refuse other stations that hold the key",
                (self._last - clock) / TICKS_PER_S,
            )
        self._last = max(self._last + 1, clock)
        if self._timestamps and self._last >= self._mark:
            self._mark = self._last + RESERVE_TICKS
            self._timestamps.keep(self._mark)
        stamp = bytes((self.link_id,)) + self._last.to_bytes(6, "little")
        return stamp + self._digest(frame + stamp)

    def close(self) -> None:
        if self._timestamps:
            self._timestamps.keep(self._last)
            self._timestamps.close()
            self._timestamps = None

    def accepts(self, frame: bytes, system: int, component: int) -> bool:
        """Check for our key, and a newer timestamp in its stream."""
        doubt = self._doubt(frame, system, component)
        if doubt is not None:
            self.doubts[system, component] = doubt
        return doubt is None

    def _doubt(self, frame: bytes, system: int, component: int) -> Doubt | None:
        if frame[0] != 0xFD or not frame[2] & SIGNED_FLAG:
            return Doubt.UNSIGNED
        if not hmac.compare_digest(self._digest(frame[:-6]), frame[-6:]):
            return Doubt.FOREIGN
        stream = (frame[-13], system, component)
        stamp = int.from_bytes(frame[-12:-6], "little")
        if stamp <= self._streams.get(stream, self._last - NEW_STREAM_TICKS - 1):
            return Doubt.STALE
        self._streams[stream] = stamp
        self._last = max(self._last, stamp)
        return None

    def _digest(self, data: bytes) -> bytes:
        return hashlib.sha256(self.key + data).digest()[:6]


def persistent_signer(key: bytes, path: str | Path) -> Signer:
    """Timestamps grow from run to run; `path` stores the last one.

    Each process has its own file and link id. Raise BadInput if the file has no timestamp, or too many sign.
    """
    path = Path(path)
    for link_id in range(MAX_SIGNERS):
        timestamps = own_timestamps(path.with_stem(f"{path.stem}-{link_id}") if link_id else path)
        if timestamps is not None:
            return Signer(key, link_id, timestamps)
    raise TooLarge(f"expected no more than {MAX_SIGNERS} processes that sign at the same time", place=path)
