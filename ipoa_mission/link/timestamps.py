"""The last timestamp that was signed, kept from one run to the next in a file of which only one process is the owner.

While it is in use the file is a second ahead of what was signed, so that a run that ends badly repeats nothing; a run
that ends well leaves the timestamp that it signed last. So it never runs ahead of the clock.
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
MOST = 2**48  # a timestamp on the wire has six bytes
LOCKED_AT = 1_000_000  # on Windows nobody can read what is locked: a byte far behind the timestamp is


class Timestamps:
    """The file of one owner, by its descriptor; `close` it for the next."""

    def __init__(self, path: Path, file: int, last: int) -> None:
        self.last = last
        self._path = path
        self._file = file
        self.close = weakref.finalize(self, os.close, file)  # once, also for one whose owner forgot to

    def keep(self, last: int) -> None:
        """Write a timestamp down; a disk that takes nothing any more does not end a flight."""
        try:
            os.lseek(self._file, 0, os.SEEK_SET)
            os.write(self._file, b"%0*d\n" % (DIGITS, last))
        except OSError as error:
            log.warning("%s: cannot be written: %s; signing may be refused next time", self._path, error.strerror)


def own_timestamps(path: Path) -> Timestamps | None:
    """The timestamp in a file, which is made if it is not there; None while another process owns it.

    Raises:
        BadInput: it cannot be opened, or holds something else than a timestamp.
    """
    try:
        file = os.open(path, os.O_RDWR | os.O_CREAT | getattr(os, "O_BINARY", 0), 0o600)
    except OSError as error:
        raise Unwritable(f"cannot be opened: {error.strerror}", place=path) from error
    try:
        _lock(file)
        words = os.read(file, DIGITS + 2).strip()
    except (BlockingIOError, PermissionError):  # it is locked: on Linux, on Windows
        os.close(file)
        return None
    except OSError as error:
        os.close(file)
        raise Unwritable(f"cannot be locked: {error.strerror}", place=path) from error
    if words and not (words.isdigit() and int(words) < MOST):
        os.close(file)
        raise BadInput(f"expected a timestamp of MAVLink signing, not {words.decode('ascii', 'replace')!r}", place=path)
    return Timestamps(path, file, int(words or b"0"))


def _lock(file: int) -> None:
    if sys.platform == "win32":
        os.lseek(file, LOCKED_AT, os.SEEK_SET)
        msvcrt.locking(file, msvcrt.LK_NBLCK, 1)
        os.lseek(file, 0, os.SEEK_SET)
    else:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
