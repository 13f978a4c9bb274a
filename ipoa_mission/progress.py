from collections.abc import Callable
from typing import TypeAlias

Progress: TypeAlias = Callable[[float, str], None]  # share done, 0 to 1, and a description


def silent(share: float, words: str) -> None:
    """Ignore progress."""


def count(progress: Progress, done: int, total: int, what: str = "", words: str = "") -> None:
    """Report that `done` of `total` are done.

    >>> count(lambda share, words: print(share, words), 3, 4, "item ")
    0.75 item 3 of 4
    """
    progress(done / max(total, 1), f"{what}{done} of {total}{words and '; '}{words}")
