"""Handle Ctrl-C where a dialogue waits, so that no order is cut in two."""

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager


class Interrupt:
    """Note the first Ctrl-C; raise KeyboardInterrupt at the second."""

    def __init__(self) -> None:
        self._is_noted = self._is_taken = False

    def __call__(self, signal_number: int, frame: object) -> None:
        if self._is_noted:
            raise KeyboardInterrupt
        self._is_noted = True

    @property
    def is_pending(self) -> bool:
        return self._is_noted and not self._is_taken

    def take(self) -> bool:
        is_pending, self._is_taken = self.is_pending, self._is_noted
        return is_pending


@contextmanager
def noted_interrupts() -> Iterator[Interrupt]:
    """Note Ctrl-C in the main thread, unless a program has its own handler; raise an unhandled one at the end."""
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
