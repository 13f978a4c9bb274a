"""How far a long task is: one kind of callback for all of them."""

from collections.abc import Callable
from typing import TypeAlias

Progress: TypeAlias = Callable[[float, str], None]  # hears which share of the work is done, 0 to 1, and a few words


def silent(share: float, words: str) -> None:
    """The progress callback that tells nobody."""


def count(progress: Progress, done: int, total: int, what: str = "", words: str = "") -> None:
    """Tell that so many of all are done, and what else there is to say.

    >>> count(lambda share, words: print(share, words), 3, 4, "item ")
    0.75 item 3 of 4
    """
    progress(done / max(total, 1), f"{what}{done} of {total}{words and '; '}{words}")
