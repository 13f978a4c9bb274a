"""Reading what a user named; writing so that nothing is ever half-written: temporary files first, then renames."""

import errno
import os
import select
import sys
import tempfile
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path

from ipoa_mission.errors import BadInput, Unreadable, Unwritable, WrongFormat

PIPE_S = 5.0  # for so long something must be written into a named pipe

MISSIONS = (".plan", ".waypoints")  # suffixes of mission files


def write_atomically(path: Path, content: str | bytes) -> None:
    """Write `content` (text as UTF-8 with LF) to `path`; what was there before stays until the new file is whole.

    Raises:
        BadInput: the folder does not exist or may not be written.
    """
    write_together({path: content})


def write_together(contents: Mapping[Path, str | bytes]) -> None:
    """Write several files, as `write_atomically` does: every one is whole before the first takes its place.

    A symbolic link stays one: what it leads to is written.

    Raises:
        BadInput: one of them cannot be written; none of them was.
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
    """Make a folder and those above it, where they are not there yet.

    Raises:
        BadInput: something else has this name, or the folder above may not be written.
    """
    try:
        path.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise Unwritable(f"cannot be made a folder: {error.strerror}", place=path) from error


@contextmanager
def in_folder(path: Path) -> Iterator[None]:
    """With a folder, as `make_folder` makes it; where what is done in it fails and leaves it empty, it goes again."""
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
    """This path, or NAME-2, NAME-3, ... beside it, if there is such a file already: for logs, which nobody can repeat.

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
    """The text of a file that a user named; a byte order mark is dropped, line ends are kept.

    Raises:
        BadInput: the file is not there, is no file, or is not UTF-8; nobody writes into the pipe that it is.
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
    """Explain why a text is no JSON from a place on, where that can be seen; None where it cannot."""
    if not text.strip():
        return "the file is empty"
    if at >= len(text.rstrip()):
        return "the file is cut off"
    is_comma = text[at] == "," or text[:at].rstrip().endswith(",")
    return (
        "there is a comma too many before it" if is_comma and text[at:].lstrip(", \t\r\n")[:1] in ("]", "}") else None
    )


def read_bytes(path: Path, most: int = -1) -> bytes:
    """The bytes of a file that a user named; so many at most, if that is not negative.

    Raises:
        BadInput: the file is not there, or is no file.
    """
    try:
        with path.open("rb") as file:
            return file.read(most)
    except OSError as error:
        raise Unreadable(f"cannot be read: {error.strerror}", place=path) from error


def packed(mission: str) -> Path:
    """A file of `missions/` that comes with the program: in a wheel it is inside of the package, else beside it."""
    package = Path(__file__).parent
    inside = package / "missions" / mission
    return inside if inside.is_file() else package.parent / "missions" / mission


def copies(part: str) -> Iterator[Path]:
    """A file or folder of this package, like "compiled", in the other copies of it that Python finds.

    In a clone the folder's own package stands before the one that was installed.
    """
    package = Path(__file__).parent
    for place in sys.path:
        there = Path(place) / package.name
        if there.is_dir() and there.resolve() != package.resolve():
            yield there / part


def _read_pipe(path: Path) -> bytes:
    """What is written into a pipe, to its end, if a writer begins soon."""
    pipe = os.open(path, os.O_RDONLY | os.O_NONBLOCK)
    with os.fdopen(pipe, "rb") as file:
        if not select.select([pipe], [], [], PIPE_S)[0]:
            raise BadInput(f"expected something to be written into this pipe within {PIPE_S:g} s", place=path)
        os.set_blocking(pipe, True)
        return file.read()


def _expect_file(path: Path) -> None:
    """A folder cannot be replaced by a file: said before anything is."""
    if path.is_dir():
        raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR))


def _umask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask
