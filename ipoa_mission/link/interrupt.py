"""Ctrl-C in a conversation: noted, and read where the dialogue waits, so it cuts no instruction in two."""

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager


class Interrupt:
    """A handler for Ctrl-C: the first one is noted, the second raises KeyboardInterrupt as usual."""

    def __init__(self) -> None:
        self._is_noted = self._is_taken = False

    def __call__(self, signal_number: int, frame: object) -> None:
        """Ctrl-C was pressed."""
        if self._is_noted:
            raise KeyboardInterrupt
        self._is_noted = True

    @property
    def is_pending(self) -> bool:
        """Whether it was noted and nobody has acted upon it."""
        return self._is_noted and not self._is_taken

    def take(self) -> bool:
        """Whether it was pressed since one last asked: whoever is told so has to act upon it."""
        is_pending, self._is_taken = self.is_pending, self._is_noted
        return is_pending


@contextmanager
def noted_interrupts() -> Iterator[Interrupt]:
    """While this lasts Ctrl-C is noted; one inside another shares its note, and what nobody took is raised at the end.

    Where Ctrl-C is somebody else's business (another thread than the main one, a program with a handler of its own)
    it stays theirs, and nothing is ever noted.
    """
    present = signal.getsignal(signal.SIGINT)
    if isinstance(present, Interrupt):
        yield present
        return
    interrupt = Interrupt()
    if present is not signal.default_int_handler or threading.current_thread() is not threading.main_thread():
        yield interrupt
        return
    signal.signal(signal.SIGINT, interrupt)
    try:
        yield interrupt
    finally:
        signal.signal(signal.SIGINT, present)
    if interrupt.is_pending:
        raise KeyboardInterrupt
