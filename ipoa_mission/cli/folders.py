"""Folders that a user named for files to be written."""

from pathlib import Path

from ipoa_mission.errors import BadInput


def make_folder(path: Path) -> None:
    """Make a folder and those above it, where they are not there yet.

    Raises:
        BadInput: something else has this name, or the folder above may not be written.
    """
    try:
        path.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise BadInput(f"{path}: cannot be made a folder: {error.strerror}") from error
