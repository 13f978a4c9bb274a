"""Folders that a user named for files to be written."""

import os
from pathlib import Path

from ipoa_mission.errors import BadInput


def expect_folder(path: Path) -> None:
    """See beforehand that `make_folder` will do: who waited for a plan wants it written.

    Raises:
        BadInput: it could not be made, or not be written.
    """
    there = next(above for above in (path, *path.absolute().parents) if above.exists())
    if not there.is_dir():
        raise BadInput(f"{path}: expected a folder, but {there} is none")
    if not os.access(there, os.W_OK | os.X_OK):
        raise BadInput(f"{path}: expected a folder that may be written, but {there} may not")


def make_folder(path: Path) -> None:
    """Make a folder and those above it, where they are not there yet.

    Raises:
        BadInput: something else has this name, or the folder above may not be written.
    """
    try:
        path.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise BadInput(f"{path}: cannot be made a folder: {error.strerror}") from error
