"""Print results to standard output, progress and errors to standard error; overwrite only what may be."""

import errno
import io
import json
import math
import os
import re
import shutil
import sys
import textwrap
import unicodedata
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from itertools import zip_longest
from pathlib import Path
from typing import Any

from ipoa_mission.errors import BadInput, MissionError, Unwritable

#: control characters, and those that change the direction of writing
_OBEYED = re.compile(r"[\x00-\x08\x0a-\x1f\x7f-\x9f\u061c\u200e\u200f\u2028-\u202e\u2066-\u2069\ufeff]")


def shown(text: str) -> str:
    """Return foreign words for one line of a terminal, control characters as `\\x1b`."""
    return _OBEYED.sub(lambda match: ascii(match[0])[1:-1], text)


def print_lines(*lines: str) -> None:
    for line in lines:
        _say(shown(line))


def _say(text: str) -> None:
    """Print; discard output that nobody reads: after `| head`, and to a closed terminal before its SIGHUP."""
    try:
        print(text, flush=True)
    except OSError as error:
        if error.errno not in (errno.EPIPE, errno.EIO):
            raise
        discard_output()


def notes(remarks: Iterable[str]) -> list[str]:
    return [f"note: {remark}" for remark in remarks]


def print_json(result: Any, indent: int | None = 2) -> None:
    """Print JSON at once, without NaN; without an indent in one line."""
    text = json.dumps(result, indent=indent, ensure_ascii=False, allow_nan=False)
    lines = (_OBEYED.sub(lambda match: json.dumps(match[0])[1:-1], line) for line in text.split("\n"))
    _say("\n".join(lines))


def picked(thing: object, *names: str, digits: int = 3) -> dict[str, Any]:
    """Return some attributes by name, floats rounded."""
    values = {name: getattr(thing, name) for name in names}
    return {name: round_finite(value, digits) if isinstance(value, float) else value for name, value in values.items()}


def round_finite(value: float, digits: int) -> float | None:
    return round(value, digits) if math.isfinite(value) else None


def print_table(title: str, columns: Sequence[str], rows: Sequence[tuple[str, ...]]) -> None:
    """Print a table, words to the left, numbers to the right, without empty columns.

    A line break in a column's name puts its unit below. Long words are folded, names last; numbers are never cut.
    """
    kept = [i for i in range(len(columns)) if any(row[i] for row in rows)]
    heads = [columns[i].split("\n") for i in kept]
    cells = [[shown(row[i]) for i in kept] for row in rows]
    numbers = [all(row[i][-1:].isdigit() or not row[i] for row in cells) for i in range(len(kept))]
    widths = [max(map(_width, (*head, *column))) for head, *column in zip(heads, *cells, strict=True)]
    words = [i for i in range(len(kept)) if not numbers[i] and any(" " in row[i] for row in cells)]
    names = [i for i in range(len(kept)) if not numbers[i] and i not in words]
    least = [max(7, *map(_width, head)) for head in heads]
    excess = sum(widths) + 2 * len(kept) - 2 - shutil.get_terminal_size().columns
    for folded in (words, names):
        while excess > 0 and any(widths[i] > least[i] for i in folded):
            widths[max(folded, key=lambda i: widths[i] - least[i])] -= 1
            excess -= 1
    tallest = max(map(len, heads), default=0)
    lines = [*_lined_up([[""] * (tallest - len(head)) + head for head in heads], widths, numbers)]
    lines.append("─" * (sum(widths) + 2 * len(kept) - 2))
    for row in cells:
        fitted = zip(row, widths, strict=True)
        wrapped = [[cell] if _width(cell) <= width else textwrap.wrap(cell, width) for cell, width in fitted]
        lines += _lined_up(wrapped, widths, numbers)
    print_lines(title, "")
    _say("\n".join(lines) + "\n")


def _width(text: str) -> int:
    return len(text) if text.isascii() else sum(1 + (unicodedata.east_asian_width(a) in "WF") for a in text)


def _lined_up(cells: Sequence[Sequence[str]], widths: Sequence[int], numbers: Sequence[bool]) -> Iterator[str]:
    """Yield the lines of a row, whose cells may have several."""
    for parts in zip_longest(*cells, fillvalue=""):
        gaps = [" " * (width - _width(part)) for width, part in zip(widths, parts, strict=True)]
        aligned = zip(parts, gaps, numbers, strict=True)
        yield "  ".join(gap + part if number else part + gap for part, gap, number in aligned).rstrip()


def print_error(error: MissionError, as_json: bool = False) -> None:
    from rich.console import Console
    from rich.markup import escape

    if as_json:
        print_json(error.as_json())
    console = Console(stderr=True, highlight=False, soft_wrap=True, emoji=False)
    for line in str(error).split("\n"):
        console.print(f"[bold red]error:[/] {escape(shown(line))}")
    if error.hint:
        console.print(f"[bold]hint:[/] {escape(shown(error.hint))}")
    written = error.known.get("written")
    for file in written if isinstance(written, list) else ():
        console.print(f"written: {escape(shown(file))}")


def replace_unencodable() -> None:
    """Replace characters outside a stream's encoding by `?`: names may not raise errors."""
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="replace")


def discard_output() -> None:
    """Stop writing to a full standard output: Python would try again at exit."""
    with Path(os.devnull).open("w") as nowhere:
        os.dup2(nowhere.fileno(), sys.stdout.fileno())


@contextmanager
def progress_bar(words: str, is_waiting: bool = False) -> Iterator[Callable[[float, str], None]]:
    """Show a bar on a terminal, else the first words once (`is_waiting`); call the result with fraction and words."""
    if not sys.stderr.isatty():
        yield _print_once(words) if is_waiting else lambda _fraction, _words: None
        return
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn

    bar = (TextColumn("{task.description}"), BarColumn(), TextColumn("{task.fields[words]}", markup=False))
    when = (TimeElapsedColumn(), TextColumn("·"), TimeRemainingColumn(), TextColumn("left"))
    with Progress(*bar, *when, console=Console(stderr=True), transient=True) as progress:
        task = progress.add_task(words, total=1.0, words="")
        yield lambda fraction, words: progress.update(task, completed=fraction, words=shown(words))


def _print_once(task: str) -> Callable[[float, str], None]:
    printed: list[str] = []

    def say(_fraction: float, words: str) -> None:
        if words and not printed:
            printed.append(words)
            print(f"{task}: {shown(words)}", file=sys.stderr, flush=True)

    return say


def confirm(question: str) -> bool:
    import typer

    try:
        return typer.confirm(question, err=True)
    except typer.Abort:
        raise KeyboardInterrupt from None


def expect_folder(path: Path) -> None:
    """Refuse a folder that cannot be created or written, before a plan."""
    there = next(above for above in (path, *path.absolute().parents) if above.exists())
    if not there.is_dir():
        raise Unwritable(f"expected a folder, not {there}", place=path)
    if not os.access(there, os.W_OK | os.X_OK):
        raise Unwritable(f"expected a writable folder, not {there}", place=path)


def expect_free(paths: Iterable[Path], force: bool, ask: bool = True) -> None:
    """Refuse to overwrite files; `ask`: a person at a terminal may say yes."""
    for path in paths:
        if path.exists() and not force:
            may_ask = ask and sys.stdin.isatty() and sys.stderr.isatty()
            if not (may_ask and confirm(f"{path} exists: overwrite it?")):
                raise BadInput("the file exists", hint="--force overwrites it", code="already-there", place=path)


def expect_log(path: Path | None) -> None:
    """Refuse to overwrite a file that is not a log."""
    if path is not None and path.is_file() and path.suffix.lower() != ".tlog":
        raise BadInput(f"expected a .tlog file, or a new file, not {path}", place="--log")
