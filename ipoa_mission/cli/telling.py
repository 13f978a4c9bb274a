"""What the command line says: results to standard output, progress and errors to standard error."""

import json
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any

from ipoa_mission.errors import MissionError


def tell(*lines: str) -> None:
    """Print lines of a result; words between square brackets may set a style, which vanishes off a terminal."""
    from rich.console import Console

    console = Console(highlight=False, soft_wrap=True)
    for line in lines:
        console.print(line)


def tell_json(result: Any) -> None:
    """Print a result for machines: JSON, without NaN."""
    print(json.dumps(result, indent=2, ensure_ascii=False, allow_nan=False))


def tell_table(title: str, columns: list[str], rows: Sequence[tuple[str, ...]]) -> None:
    """Print a table: words to the left, numbers to the right; a column in which nothing stands is left out."""
    from rich.box import SIMPLE_HEAD
    from rich.console import Console
    from rich.table import Table

    kept = [i for i in range(len(columns)) if any(row[i] for row in rows)]
    table = Table(title=title, title_justify="left", box=SIMPLE_HEAD, pad_edge=False)
    for i in kept:
        numbers = all(row[i][-1:].isdigit() or not row[i] for row in rows)
        table.add_column(columns[i], justify="right" if numbers else "left", no_wrap=i < kept[-1])
    for row in rows:
        table.add_row(*(row[i] for i in kept))
    Console(highlight=False, width=None if sys.stdout.isatty() else 160).print(table)


def tell_error(error: MissionError) -> None:
    """Print what went wrong, and what may help."""
    from rich.console import Console
    from rich.markup import escape

    console = Console(stderr=True, highlight=False, soft_wrap=True)
    for line in str(error).splitlines():
        console.print(f"[bold red]error:[/] {escape(line)}")
    if error.hint:
        console.print(f"[bold]hint:[/] {escape(error.hint)}")


@contextmanager
def progress_bar(words: str) -> Iterator[Callable[[float, str], None]]:
    """A bar on a terminal, nothing elsewhere. Call what you get with the fraction done and a few words."""
    if not sys.stderr.isatty():
        yield lambda _fraction, _words: None
        return
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

    columns = (TextColumn("{task.description}"), BarColumn(), TextColumn("{task.fields[words]}"), TimeElapsedColumn())
    with Progress(*columns, console=Console(stderr=True), transient=True) as progress:
        task = progress.add_task(words, total=1.0, words="")
        yield lambda fraction, said: progress.update(task, completed=fraction, words=said)
