"""Telemetry logs. A record is the time [us since 1970] as eight bytes big-endian, and the raw frame."""

import errno
import logging
import os
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import BinaryIO

from ipoa_mission.errors import Unwritable
from ipoa_mission.files import note_written, read_bytes
from ipoa_mission.link.codec import frame_at, frame_length, next_magic, number_of, numbered
from ipoa_mission.link.definitions import DEFINITIONS

log = logging.getLogger(__name__)
STAMP_BYTES = 8


class TlogWriter:
    """A full disk ends the log with a warning, not the flight."""

    def __init__(self, path: str | Path) -> None:
        self._path = path
        self._is_over = False
        try:
            self._file: BinaryIO = Path(path).open("wb", buffering=0)  # noqa: SIM115
        except OSError as error:
            raise Unwritable(f"cannot be written: {error.strerror}", place=path) from error
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
            yield f"{self.torn_bytes} bytes of the log are no whole messages: it is damaged or cut short"
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
    """Return the next record's index, else the end."""
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
