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
import sys
import weakref
from codecs import BOM_UTF8
from enum import StrEnum
from pathlib import Path

from ipoa_mission.errors import BadInput, TooLarge, Unwritable
from ipoa_mission.files import read_bytes

if sys.platform == "win32":
    import msvcrt
else:
    import fcntl

log = logging.getLogger(__name__)
EPOCH_2015_S = 1_420_070_400
TICKS_PER_S = 100_000
NEW_STREAM_TICKS = 60 * TICKS_PER_S  # may be this far behind us
SIGNED = 0x01  # incompat_flags bit
MAX_SIGNERS = 16


def read_key(path: str | Path) -> bytes:
    """Warn if others may write the file; raise BadInput."""
    path = Path(path)
    raw = read_bytes(path)
    if os.name == "posix" and path.stat().st_mode & (stat.S_IWGRP | stat.S_IWOTH):
        log.warning("%s: others than its owner may write this key: chmod 600 %s", path, path)
    return key_of(raw)


def key_of(secret: str | bytes) -> bytes:
    """Raise BadInput, else return 32 bytes.

    `secret`: 64 hexadecimal digits, 32 bytes that are not text, or a passphrase (SHA-256 without its line end).
    """
    raw = secret.encode("utf-8", "surrogateescape") if isinstance(secret, str) else secret
    is_text = _is_text(raw)
    raw = raw.removeprefix(BOM_UTF8) if is_text else raw
    if digits := re.fullmatch(rb"\s*([0-9a-fA-F]{64})\s*", raw):
        return bytes.fromhex(digits[1].decode())
    if len(raw) == 32 and not is_text:
        return raw
    words = raw.rstrip(b"\r\n")
    if not is_text or not words.strip():
        actual = "nothing" if not raw.strip() else f"{len(raw)} bytes that are no text"
        raise BadInput(f"expected 64 hexadecimal digits, 32 bytes or a passphrase, not {actual}", place="signing key")
    return hashlib.sha256(words).digest()


def _is_text(raw: bytes) -> bool:
    try:
        return all(letter.isprintable() or letter.isspace() for letter in raw.decode("utf-8-sig"))
    except UnicodeDecodeError:
        return False


class Doubt(StrEnum):
    UNSIGNED = "unsigned"
    FOREIGN = "foreign"  # another key
    STALE = "stale"  # our key, but not newer than the last frame


class Timestamps:
    """Store the last signed timestamp in a file of one process."""

    DIGITS = 20

    def __init__(self, path: Path, file: int, last: int) -> None:
        self.last = last
        self._path = path
        self._file = file
        self.close = weakref.finalize(self, os.close, file)  # also if the owner forgot to close

    def keep(self, last: int) -> None:
        """A full disk only warns: it must not end a flight."""
        try:
            os.lseek(self._file, 0, os.SEEK_SET)
            os.write(self._file, b"%0*d\n" % (self.DIGITS, last))
        except OSError as error:
            log.warning("%s: cannot be written: %s; signing may be refused next time", self._path, error.strerror)


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
            self._mark = self._last + TICKS_PER_S  # one second ahead in use: a crash repeats no timestamp
            self._timestamps.keep(self._mark)
        stamp = bytes((self.link_id,)) + self._last.to_bytes(6, "little")
        return stamp + self._digest(frame + stamp)

    def close(self) -> None:
        if self._timestamps:
            self._timestamps.keep(self._last)
            self._timestamps.close()
            self._timestamps = None

    def accepts(self, frame: bytes, system: int, component: int) -> bool:
        """Return whether the frame has our key, and a newer timestamp in its stream."""
        doubt = self._doubt(frame, system, component)
        if doubt is not None:
            self.doubts[system, component] = doubt
        return doubt is None

    def _doubt(self, frame: bytes, system: int, component: int) -> Doubt | None:
        if frame[0] != 0xFD or not frame[2] & SIGNED:
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
    """Return a signer whose timestamps grow over runs, by files at `path`; each process has its own link id."""
    path = Path(path)
    for link_id in range(MAX_SIGNERS):
        timestamps = _own_timestamps(path.with_stem(f"{path.stem}-{link_id}") if link_id else path)
        if timestamps is not None:
            return Signer(key, link_id, timestamps)
    raise TooLarge(f"expected no more than {MAX_SIGNERS} processes that sign at the same time", place=path)


def _own_timestamps(path: Path) -> Timestamps | None:
    try:
        file = os.open(path, os.O_RDWR | os.O_CREAT | getattr(os, "O_BINARY", 0), 0o600)
    except OSError as error:
        raise Unwritable(f"cannot be opened: {error.strerror}", place=path) from error
    try:
        _lock(file)
        words = os.read(file, Timestamps.DIGITS + 2).strip()
    except (BlockingIOError, PermissionError):  # on Linux, on Windows
        os.close(file)
        return None
    except OSError as error:
        os.close(file)
        raise Unwritable(f"cannot be locked: {error.strerror}", place=path) from error
    if words and not (words.isdigit() and int(words) < 2**48):  # six bytes on the wire
        os.close(file)
        raise BadInput(f"expected a timestamp of MAVLink signing, not {words.decode('ascii', 'replace')!r}", place=path)
    return Timestamps(path, file, int(words or b"0"))


def _lock(file: int) -> None:
    if sys.platform == "win32":
        os.lseek(file, 1_000_000, os.SEEK_SET)  # Windows forbids reading locked bytes
        msvcrt.locking(file, msvcrt.LK_NBLCK, 1)
        os.lseek(file, 0, os.SEEK_SET)
    else:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
