"""Where a user wants files written: nothing is lost but with `--force`, or a yes on a terminal."""

import os
import sys
from collections.abc import Iterable
from pathlib import Path

import typer

from ipoa_mission.errors import BadInput, Unwritable


def expect_folder(path: Path) -> None:
    """See beforehand that a folder is there or can be made: who waited for a plan wants it written.

    Raises:
        BadInput: it could not be made, or not be written.
    """
    there = next(above for above in (path, *path.absolute().parents) if above.exists())
    if not there.is_dir():
        raise Unwritable(f"expected a folder, but {there} is none", place=path)
    if not os.access(there, os.W_OK | os.X_OK):
        raise Unwritable(f"expected a folder that may be written, but {there} may not", place=path)


def expect_free(paths: Iterable[Path], force: bool, ask: bool = True) -> None:
    """See that nothing is written over against the user's will; `ask`: a person at a terminal may say yes.

    Raises:
        BadInput: a file is there, and neither `force` nor the user said to write over it.
    """
    for path in paths:
        if path.exists() and not force:
            may_ask = ask and sys.stdin.isatty() and sys.stderr.isatty()
            if not (may_ask and typer.confirm(f"{path} is there already: write over it?", err=True)):
                words = "there is such a file already"
                raise BadInput(words, hint="--force writes over it", code="already-there", place=path)


def expect_plans(folder: Path, names: Iterable[str], report: bool, force: bool, ask: bool = True) -> None:
    """See that plans of these names are written over nothing but what was planned here, and nobody changed since.

    Raises:
        BadInput: as `expect_free`.
    """
    from ipoa_mission.flight.written import not_as_written

    expect_free((path for name in names for path in not_as_written(folder, name, report)), force, ask)


def expect_log(path: Path | None) -> None:
    """See that `--log` does not write over a file that is no log.

    Raises:
        BadInput: there is a file of another kind.
    """
    if path is not None and path.is_file() and path.suffix.lower() != ".tlog":
        raise BadInput(f"expected a .tlog file, or one that is not there yet, not {path}", place="--log")
