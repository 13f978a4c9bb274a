"""Read user files; write files atomically; list plug-ins."""

import errno
import json
import os
import sys
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from functools import cache
from importlib.metadata import EntryPoints, entry_points
from pathlib import Path

from ipoa_mission.errors import TooLarge, Unreadable, Unwritable, WrongFormat, hint_of

MISSIONS = (".plan", ".waypoints")
_records: list[list[Path]] = []  # of `recorded_writes`
_entry_points = cache(entry_points)  # slow


def write_atomically(path: Path, content: str | bytes) -> None:
    write_together({path: content})


def write_together(contents: Mapping[Path, str | bytes | None]) -> None:
    """Write files, text as UTF-8; remove those of None. All are on disk before any is renamed.

    Raises:
        BadInput: one cannot be written or removed; none was, unless a later rename failed.
    """
    for path in contents:
        if "\0" in str(path):
            raise Unwritable("expected a name without a NUL character", place=path)
    texts = {path: content for path, content in contents.items() if content is not None}
    targets = {path: Path(os.path.realpath(path)) for path in texts}
    hidden = {path: targets.get(path, path).with_name(f".{path.name}.{os.urandom(4).hex()}") for path in contents}
    removed = [path for path in contents if path not in texts]
    try:
        for path, text in texts.items():
            _stage(hidden[path], text)
            with suppress(FileNotFoundError):
                hidden[path].chmod(targets[path].stat().st_mode & 0o777)
            if path.is_dir():
                raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR))
        for path in removed:
            with suppress(FileNotFoundError):
                path.replace(hidden[path])
        for path, target in targets.items():
            note_written(path)
            hidden[path].replace(target)
    except BaseException as error:
        for each in removed:
            with suppress(OSError):
                hidden.pop(each).replace(each)
        if isinstance(error, OSError):
            change = "removed" if path in removed else "written"
            raise Unwritable(f"cannot be {change}: {error.strerror}", place=path) from error
        raise
    finally:
        for temporary in hidden.values():
            temporary.unlink(missing_ok=True)


def _stage(path: Path, content: str | bytes) -> None:
    with path.open("xb") as file:
        file.write(content.encode() if isinstance(content, str) else content)
        file.flush()
        os.fsync(file.fileno())


@contextmanager
def recorded_writes(record: list[Path]) -> Iterator[None]:
    """Append each file that this process writes."""
    _records.append(record)
    try:
        yield
    finally:
        _records.pop()


def note_written(path: Path) -> None:
    for record in _records:
        if path not in record:
            record.append(path)


def make_folder(path: Path) -> None:
    try:
        path.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise Unwritable(f"this folder cannot be created: {error.strerror}", place=path) from error


@contextmanager
def in_folder(path: Path) -> Iterator[None]:
    """Make a folder for a block; remove new, empty ones if the block fails."""
    made = [folder for folder in (path, *path.parents) if not folder.exists()]
    make_folder(path)
    try:
        yield
    except BaseException:
        with suppress(OSError):
            for folder in made:
                folder.rmdir()
        raise


def unused(path: Path) -> Path:
    """Return the first free of NAME, NAME-2, NAME-3, ...

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
    """Return UTF-8 text without a byte order mark, with its line ends."""
    try:
        return read_bytes(path).decode("utf-8-sig")
    except UnicodeDecodeError as error:
        words = f"expected UTF-8 text, but byte {error.start} is {error.object[error.start]:#04x}"
        raise WrongFormat(words, place=path) from error


@contextmanager
def reading(path: Path, text: str = "") -> Iterator[None]:
    """Raise BadInput where a file cannot be read, or its `text` is no JSON."""
    try:
        yield
    except OSError as error:
        hint = near_name(path) if isinstance(error, FileNotFoundError) else None
        raise Unreadable(f"cannot be read: {error.strerror or error}", hint=hint, place=path) from error
    except json.JSONDecodeError as error:
        place = f"{path}: line {error.lineno}, column {error.colno}"
        raise WrongFormat(f"expected JSON: {error.msg}", hint=_why_no_json(text, error.pos), place=place) from error
    except RecursionError:
        raise TooLarge("expected a file without endlessly nested brackets", place=path) from None
    except ValueError:
        raise TooLarge("expected numbers that fit in 64 bits, not one of thousands of digits", place=path) from None


def near_name(path: Path) -> str | None:
    """Ask for a file of nearly this name in the folder."""
    with suppress(OSError):
        return hint_of(path.name, (each.name for each in path.parent.iterdir()), sureness=0.8)
    return None


@contextmanager
def reading_xml(path: Path) -> Iterator[None]:
    from xml.etree import ElementTree  # slow import

    with reading(path):
        try:
            yield
        except ElementTree.ParseError as error:
            raise WrongFormat("expected well-formed XML", place=f"{path}: line {error.position[0]}") from error
        except (LookupError, ValueError) as error:  # unknown or multi-byte encoding
            raise WrongFormat(f"expected XML in an encoding such as UTF-8: {error}", place=path) from error


def _why_no_json(text: str, offset: int) -> str | None:
    if not text.strip():
        return "the file is empty"
    if offset >= len(text.rstrip()):
        return "the file is cut off"

    follows_comma = text[offset] == "," or text[:offset].rstrip().endswith(",")
    closes = text[offset:].lstrip(", \t\r\n")[:1] in ("]", "}")
    return "there is an extra comma before it" if follows_comma and closes else None


def read_bytes(path: Path, most: int = -1) -> bytes:
    if "\0" in str(path):
        raise Unreadable("expected a name without a NUL character", place=path)
    with reading(path), path.open("rb") as file:
        return file.read(most)


def packed(mission: str) -> Path:
    """Return a path of `missions/`, inside a wheel's package or next to it."""
    package = Path(__file__).parent
    inside = package / "missions" / mission
    return inside if inside.is_file() else package.parent / "missions" / mission


def plug_ins(group: str) -> EntryPoints:
    return _entry_points().select(group=f"ipoa_mission.{group}")


def copies(part: str) -> Iterator[Path]:
    """Yield a part of other copies of this package on `sys.path`, which a clone shadows."""
    package = Path(__file__).parent
    for folder in sys.path:
        copy = Path(folder) / package.name
        if copy.is_dir() and copy.resolve() != package.resolve():
            yield copy / part
