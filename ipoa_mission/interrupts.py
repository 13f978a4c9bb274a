"""Ctrl-C, SIGTERM and SIGHUP: noted where a dialogue may end well, else a KeyboardInterrupt."""

import os
import signal
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager


class Interrupt:
    """Note the first Ctrl-C, SIGTERM or SIGHUP; raise KeyboardInterrupt at another Ctrl-C, ignore other ones."""

    def __init__(self) -> None:
        self.is_pending = self._is_noted = self.is_terminated = False

    def __call__(self, signal_number: int, frame: object) -> None:
        self.is_terminated |= signal_number != signal.SIGINT
        discard_lost_output()
        if not self._is_noted:
            self._is_noted = self.is_pending = True
        elif signal_number == signal.SIGINT:
            raise KeyboardInterrupt

    def take(self) -> bool:
        if not self.is_pending:
            return False
        self.is_pending = False
        return True


def terminate(signal_number: int, frame: object) -> None:
    """Handle SIGTERM and SIGHUP as Ctrl-C, once: a closed session sends several."""
    discard_lost_output()
    for number in terminations():
        signal.signal(number, signal.SIG_IGN)
    raise KeyboardInterrupt


def discard_lost_output() -> None:
    """Discard output to a closed terminal: it would be an error while the vehicle's mode is restored."""
    for output in (1, 2):
        try:
            os.write(output, b"")
        except OSError:
            nowhere = os.open(os.devnull, os.O_WRONLY)
            os.dup2(nowhere, output)
            os.close(nowhere)


def terminations() -> list[int]:
    return [getattr(signal, name) for name in ("SIGTERM", "SIGHUP") if hasattr(signal, name)]


def handle(handlers: Mapping[int, object], by: Callable[[int, object], None]) -> list[int]:
    """Handle the signals that have these handlers; return them: none outside the main thread."""
    handled = [number for number, present in handlers.items() if signal.getsignal(number) is present]
    try:
        for number in handled:
            signal.signal(number, by)
    except ValueError:
        return []
    return handled


@contextmanager
def noted_terminations() -> Iterator[None]:
    """Let `terminate` handle SIGTERM and SIGHUP, unless they have a handler or are ignored."""
    handled = handle(dict.fromkeys(terminations(), signal.SIG_DFL), terminate)
    try:
        yield
    finally:
        for number in handled:
            signal.signal(number, signal.SIG_DFL)


@contextmanager
def noted_interrupts() -> Iterator[Interrupt]:
    """Note Ctrl-C, and what `terminate` handles, in the main thread; raise an unhandled one at the end.

    A program's own handler remains.
    """
    usual = {signal.SIGINT: signal.default_int_handler, **dict.fromkeys(terminations(), terminate)}
    for number in usual:
        handler = signal.getsignal(number)
        if isinstance(handler, Interrupt):
            yield handler
            return
    interrupt = Interrupt()
    noted = handle(usual, interrupt)
    try:
        yield interrupt
    finally:
        for number in noted:
            is_over = interrupt.is_terminated and number != signal.SIGINT
            signal.signal(number, signal.SIG_IGN if is_over else usual[number])
    if interrupt.is_pending:
        raise KeyboardInterrupt
