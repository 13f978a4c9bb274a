"""Judge a changed file: same reading, a more cautious one, a reported change, or a loss."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

from ipoa_mission.errors import BadInput, MissionError

Outcome = Literal["same", "more cautious", "named", "lost"]


@dataclass(frozen=True)
class Reading:
    """Hold the content of a file, and the reader's remarks on what it did not take.

    `covers(before, after)` returns whether `after` obstructs at least as much; None: not applicable.
    """

    content: Any
    words: frozenset[str]
    covers: Callable[[Any, Any], bool] | None = None


def judge(path: Path, before: str | bytes, after: str | bytes, read: Callable[[Path], Reading]) -> Outcome:
    path.write_bytes(before if isinstance(before, bytes) else before.encode())
    was = read(path)
    path.write_bytes(after if isinstance(after, bytes) else after.encode())
    try:
        now = read(path)
    except (BadInput, MissionError):
        return "named"
    if now.content == was.content:
        return "same"
    if now.words - was.words:
        return "named"
    return "more cautious" if was.covers is not None and was.covers(was.content, now.content) else "lost"
