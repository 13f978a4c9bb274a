"""Writing files so that nothing is ever half-written: a temporary file beside the target, then a rename."""

import os
import tempfile
from pathlib import Path

from ipoa_mission.errors import BadInput


def write_atomically(path: Path, content: str | bytes) -> None:
    """Write `content` (text as UTF-8 with LF) to `path`; what was there before stays until the new file is whole.

    Raises:
        BadInput: the folder does not exist or may not be written.
    """
    data = content.encode() if isinstance(content, str) else content
    try:
        handle, temporary = tempfile.mkstemp(prefix=f".{path.name}.", dir=path.parent)
    except OSError as error:
        raise BadInput(f"{path}: cannot be written: {error.strerror}") from error
    try:
        with os.fdopen(handle, "wb") as file:
            file.write(data)
        Path(temporary).chmod(0o666 & ~_umask())
        Path(temporary).replace(path)
    except OSError as error:
        Path(temporary).unlink(missing_ok=True)
        raise BadInput(f"{path}: cannot be written: {error.strerror}") from error


def read_text(path: Path) -> str:
    """The text of a file that a user named; a byte order mark is dropped, line ends are kept.

    Raises:
        BadInput: the file is not there, is no file, or is not UTF-8.
    """
    try:
        return path.read_bytes().decode("utf-8-sig")
    except OSError as error:
        raise BadInput(f"{path}: cannot be read: {error.strerror}") from error
    except UnicodeDecodeError as error:
        raise BadInput(
            f"{path}: expected UTF-8 text, but byte {error.start} is {error.object[error.start]:#04x}"
        ) from error


def _umask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask
