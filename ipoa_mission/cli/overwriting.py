"""Overwrite files only with `--force`, or a yes on a terminal."""

import os
import sys
from collections.abc import Iterable
from pathlib import Path

from ipoa_mission.cli.interrupting import confirm
from ipoa_mission.errors import BadInput, Unwritable


def expect_folder(path: Path) -> None:
    """Refuse a folder that cannot be created or written, before a plan. Raises BadInput."""
    there = next(above for above in (path, *path.absolute().parents) if above.exists())
    if not there.is_dir():
        raise Unwritable(f"expected a folder, not {there}", place=path)
    if not os.access(there, os.W_OK | os.X_OK):
        raise Unwritable(f"expected a writable folder, not {there}", place=path)


def expect_free(paths: Iterable[Path], force: bool, ask: bool = True) -> None:
    """Refuse to overwrite files; `ask`: a person at a terminal may say yes. Raises BadInput."""
    for path in paths:
        if path.exists() and not force:
            may_ask = ask and sys.stdin.isatty() and sys.stderr.isatty()
            if not (may_ask and confirm(f"{path} exists: overwrite it?")):
                words = "the file exists"
                raise BadInput(words, hint="--force overwrites it", code="already-there", place=path)


def expect_plans(folder: Path, names: Iterable[str], report: bool, force: bool, ask: bool = True) -> None:
    """Refuse to overwrite anything but unchanged earlier plans. Raises BadInput."""
    from ipoa_mission.flight.flight import not_as_written

    expect_free((path for name in names for path in not_as_written(folder, name, report)), force, ask)


def expect_log(path: Path | None) -> None:
    """Refuse to overwrite a file that is not a log. Raises BadInput."""
    if path is not None and path.is_file() and path.suffix.lower() != ".tlog":
        raise BadInput(f"expected a .tlog file, or a new file, not {path}", place="--log")
