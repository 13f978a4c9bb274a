"""Read user files; write files atomically: temporary files first, then renames."""

import errno
import os
import select
import sys
import tempfile
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path

from ipoa_mission.errors import BadInput, Unreadable, Unwritable, WrongFormat

PIPE_TIMEOUT_S = 5.0  # timeout for the first data in a named pipe [s]

MISSIONS = (".plan", ".waypoints")  # suffixes of mission files


def write_atomically(path: Path, content: str | bytes) -> None:
    """Write `content` (text as UTF-8 with LF) to `path`; the old file stays until the new one is complete.

    Raises:
        BadInput: the folder does not exist or is not writable.
    """
    write_together({path: content})


def write_together(contents: Mapping[Path, str | bytes]) -> None:
    """Write several files: each is complete before the first is renamed.

    A symbolic link stays; its target is written.

    Raises:
        BadInput: one of them cannot be written; none was.
    """
    staged: dict[Path, Path] = {}
    targets = {path: Path(os.path.realpath(path)) for path in contents}
    try:
        for path, content in contents.items():
            try:
                handle, temporary = tempfile.mkstemp(prefix=f".{path.name}.", dir=targets[path].parent)
                staged[path] = Path(temporary)
                with os.fdopen(handle, "wb") as file:
                    file.write(content.encode() if isinstance(content, str) else content)
                staged[path].chmod(0o666 & ~_umask())
                _expect_file(path)
            except OSError as error:
                raise Unwritable(f"cannot be written: {error.strerror}", place=path) from error
        for path, target in targets.items():
            try:
                staged[path].replace(target)
            except OSError as error:
                raise Unwritable(f"cannot be written: {error.strerror}", place=path) from error
    finally:
        for left in staged.values():
            left.unlink(missing_ok=True)


def make_folder(path: Path) -> None:
    """Make a folder and its parents if missing.

    Raises:
        BadInput: a file has this name, or the parent is not writable.
    """
    try:
        path.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise Unwritable(f"this folder cannot be created: {error.strerror}", place=path) from error


@contextmanager
def in_folder(path: Path) -> Iterator[None]:
    """Make a folder for a block; remove the new folders if the block fails and leaves them empty."""
    made = [one for one in (path, *path.parents) if not one.exists()]
    make_folder(path)
    try:
        yield
    except BaseException:
        with suppress(OSError):  # it is not empty
            for one in made:
                one.rmdir()
        raise


def unused(path: Path) -> Path:
    """Return this path, or NAME-2, NAME-3, ... next to it if it exists: logs cannot be repeated.

    >>> unused(Path("nowhere/flight.tlog")).name
    'flight.tlog'
    """
    number = 1
    free = path
    while free.exists():
        number += 1
        free = path.with_stem(f"{path.stem}-{number}")
    return free


def read_text(path: Path) -> str:
    """Read the text of a user's file; drop a byte order mark, keep line ends.

    Raises:
        BadInput: the file is missing, not a file, or not UTF-8; or nothing is written into a pipe.
    """
    try:
        data = _read_pipe(path) if path.is_fifo() else path.read_bytes()
        return data.decode("utf-8-sig")
    except OSError as error:
        raise Unreadable(f"cannot be read: {error.strerror}", place=path) from error
    except UnicodeDecodeError as error:
        words = f"expected UTF-8 text, but byte {error.start} is {error.object[error.start]:#04x}"
        raise WrongFormat(words, place=path) from error


def why_no_json(text: str, at: int) -> str | None:
    """Explain why a text is not JSON from offset `at` on, or return None."""
    if not text.strip():
        return "the file is empty"
    if at >= len(text.rstrip()):
        return "the file is cut off"
    is_comma = text[at] == "," or text[:at].rstrip().endswith(",")
    return "there is an extra comma before it" if is_comma and text[at:].lstrip(", \t\r\n")[:1] in ("]", "}") else None


def read_bytes(path: Path, most: int = -1) -> bytes:
    """Read a user's file, at most `most` bytes unless negative.

    Raises:
        BadInput: the file is missing or not a file.
    """
    try:
        with path.open("rb") as file:
            return file.read(most)
    except OSError as error:
        raise Unreadable(f"cannot be read: {error.strerror}", place=path) from error


def packed(mission: str) -> Path:
    """Return the path of a file of `missions/`: within the package in a wheel, else next to it."""
    package = Path(__file__).parent
    inside = package / "missions" / mission
    return inside if inside.is_file() else package.parent / "missions" / mission


def copies(part: str) -> Iterator[Path]:
    """Yield a file or folder, like "compiled", in other copies of this package on `sys.path`.

    In a clone, the clone's package shadows the installed one.
    """
    package = Path(__file__).parent
    for place in sys.path:
        there = Path(place) / package.name
        if there.is_dir() and there.resolve() != package.resolve():
            yield there / part


def _read_pipe(path: Path) -> bytes:
    """Read a pipe to its end, if a writer begins within `PIPE_TIMEOUT_S`."""
    pipe = os.open(path, os.O_RDONLY | os.O_NONBLOCK)
    with os.fdopen(pipe, "rb") as file:
        if not select.select([pipe], [], [], PIPE_TIMEOUT_S)[0]:
            raise BadInput(f"expected data in this pipe within {PIPE_TIMEOUT_S:g} s", place=path)
        os.set_blocking(pipe, True)
        return file.read()


def _expect_file(path: Path) -> None:
    """Raise if the path is a folder, which a file cannot replace."""
    if path.is_dir():
        raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR))


def _umask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask
