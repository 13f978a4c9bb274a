"""The last signed timestamp in a file of one process.

In use, it is one second ahead: a crash repeats no timestamp.
"""

import logging
import os
import sys
import weakref
from pathlib import Path

from ipoa_mission.errors import BadInput, Unwritable

if sys.platform == "win32":
    import msvcrt
else:
    import fcntl

log = logging.getLogger(__name__)
DIGITS = 20
TIMESTAMP_LIMIT = 2**48  # six bytes on the wire
LOCK_OFFSET = 1_000_000  # Windows forbids reading locked bytes


class Timestamps:
    def __init__(self, path: Path, file: int, last: int) -> None:
        self.last = last
        self._path = path
        self._file = file
        self.close = weakref.finalize(self, os.close, file)  # also if the owner forgot to close

    def keep(self, last: int) -> None:
        """A full disk only warns: it must not end a flight."""
        try:
            os.lseek(self._file, 0, os.SEEK_SET)
            os.write(self._file, b"%0*d\n" % (DIGITS, last))
        except OSError as error:
            log.warning("%s: cannot be written: %s; signing may be refused next time", self._path, error.strerror)


def own_timestamps(path: Path) -> Timestamps | None:
    """None while another process owns the file. Raise BadInput."""
    try:
        file = os.open(path, os.O_RDWR | os.O_CREAT | getattr(os, "O_BINARY", 0), 0o600)
    except OSError as error:
        raise Unwritable(f"cannot be opened: {error.strerror}", place=path) from error
    try:
        _lock(file)
        words = os.read(file, DIGITS + 2).strip()
    except (BlockingIOError, PermissionError):  # on Linux, on Windows
        os.close(file)
        return None
    except OSError as error:
        os.close(file)
        raise Unwritable(f"cannot be locked: {error.strerror}", place=path) from error
    if words and not (words.isdigit() and int(words) < TIMESTAMP_LIMIT):
        os.close(file)
        raise BadInput(f"expected a timestamp of MAVLink signing, not {words.decode('ascii', 'replace')!r}", place=path)
    return Timestamps(path, file, int(words or b"0"))


def _lock(file: int) -> None:
    if sys.platform == "win32":
        os.lseek(file, LOCK_OFFSET, os.SEEK_SET)
        msvcrt.locking(file, msvcrt.LK_NBLCK, 1)
        os.lseek(file, 0, os.SEEK_SET)
    else:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
