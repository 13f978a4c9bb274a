"""`.tlog`: every frame that went over the link, as ground stations keep and replay it.

A record is the time of a frame in microseconds since 1970, eight bytes big-endian, and the raw frame.
"""

import errno
import logging
import os
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO

from ipoa_mission.errors import Unwritable
from ipoa_mission.files import read_bytes
from ipoa_mission.link.codec import frame_at, next_magic

log = logging.getLogger(__name__)
STAMP_BYTES = 8


class TlogWriter:
    """A log under way; each frame is on the disk as soon as it is written.

    A disk that takes no more ends the log, not the flight: that is said once.
    """

    def __init__(self, path: str | Path) -> None:
        self._path = path
        self._is_over = False
        try:
            self._file: BinaryIO = Path(path).open("wb", buffering=0)  # noqa: SIM115
        except OSError as error:
            raise Unwritable(f"cannot be written: {error.strerror}", place=path) from error

    def write(self, frame: bytes, unix_s: float) -> None:
        """Add one frame."""
        record = round(unix_s * 1e6).to_bytes(STAMP_BYTES, "big") + frame
        try:
            if not self._is_over and self._file.write(record) < len(record):
                raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        except OSError as error:
            self._is_over = True
            log.warning("%s: cannot be written any more: %s; the log ends here", self._path, error.strerror)

    def close(self) -> None:
        """No more frames."""
        self._file.close()

    def __enter__(self) -> "TlogWriter":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


@dataclass(frozen=True)
class Record:
    """One frame of a log and when it was seen, in seconds since 1970."""

    unix_s: float
    frame: bytes


def read_tlog(path: str | Path) -> Iterator[Record]:
    """The frames of a log in their order; a torn record is passed over, as are frames with a wrong checksum.

    Raises:
        BadInput: the file cannot be read.
    """
    data, at = read_bytes(Path(path)), 0
    while (start := next_magic(data, at + STAMP_BYTES)) >= 0:
        at = start - STAMP_BYTES
        frame = frame_at(data, start)
        if frame is None:
            at += 1
            continue
        yield Record(int.from_bytes(data[at:start], "big") / 1e6, frame)
        at = start + len(frame)
