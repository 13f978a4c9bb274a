"""Print results to standard output, progress and errors to standard error; overwrite only what may be."""

import io
import json
import math
import os
import re
import sys
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from itertools import repeat, zip_longest
from pathlib import Path
from typing import Any, Literal

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
    """Print; ignore a reader that has closed it (`| head`)."""
    try:
        print(text, flush=True)
    except BrokenPipeError:
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
    cells = [[shown(row[i]) for i in kept] for row in rows]
    numbers = {place for place, i in enumerate(kept) if all(row[i][-1:].isdigit() or not row[i] for row in rows)}
    heads = [columns[i] for i in kept]
    drawn = _simple_table(heads, cells, numbers) or _folded_table(heads, cells, numbers)
    print_lines(title, "")
    _say("\n".join(line.rstrip() for line in drawn) + "\n")


def _simple_table(heads: list[str], rows: list[list[str]], numbers: set[int]) -> list[str]:
    """Draw a narrow ASCII table without Rich, not on a terminal; else none."""
    above = [*zip_longest(*(head.split("\n")[::-1] for head in heads), fillvalue="")][::-1]
    columns = [*zip(*above, *rows, strict=True)]
    widths = [max(map(len, column)) for column in columns]
    width = sum(widths) + 2 * len(widths)
    is_ascii = all(text.isascii() and text.isprintable() for row in rows for text in row)
    if sys.stdout.isatty() or width > _columns() or not is_ascii:
        return []
    sides = [str.rjust if i in numbers else str.ljust for i in range(len(heads))]
    cells = [map(side, column, repeat(size)) for side, column, size in zip(sides, columns, widths, strict=True)]
    lines = ["  ".join(line) for line in zip(*cells, strict=True)]
    lines.insert(len(above), "─" * (width - 2))
    return lines


def _folded_table(heads: list[str], rows: list[list[str]], numbers: set[int]) -> list[str]:
    from rich.align import Align
    from rich.box import SIMPLE_HEAD
    from rich.cells import cell_len
    from rich.console import Console
    from rich.table import Table
    from rich.text import Text

    widths = [max(map(cell_len, (*head.split("\n"), *column))) for head, *column in zip(heads, *rows, strict=True)]
    names = {i for i in range(len(heads)) if i not in numbers and not any(" " in row[i] for row in rows)}
    console = Console(highlight=False, width=None if sys.stdout.isatty() else _columns())

    def needed(whole: set[int], gap: int = 2, least: int = 7) -> int:  # characters
        return sum(gap + (width if i in whole else min(width, least)) for i, width in enumerate(widths))

    whole = numbers | names if needed(numbers | names) <= console.width else numbers
    console.width = max(console.width, needed(whole))
    table = Table(box=SIMPLE_HEAD, pad_edge=False, show_edge=False, padding=(0, 1, 0, 0))
    for i, head in enumerate(heads):
        side: Literal["left", "right"] = "right" if i in numbers else "left"
        table.add_column(Align(head, side, vertical="bottom"), justify=side, no_wrap=i in whole, overflow="fold")
    for row in rows:
        table.add_row(*map(Text, row))
    with console.capture() as drawn:
        console.print(table)
    return drawn.get().splitlines()


def _columns() -> int:
    width = os.environ.get("COLUMNS", "")
    return int(width) if width.isdecimal() and 20 <= int(width) <= 1000 else 80


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
                words = "the file exists"
                raise BadInput(words, hint="--force overwrites it", code="already-there", place=path)


def expect_log(path: Path | None) -> None:
    """Refuse to overwrite a file that is not a log."""
    if path is not None and path.is_file() and path.suffix.lower() != ".tlog":
        raise BadInput(f"expected a .tlog file, or a new file, not {path}", place="--log")
