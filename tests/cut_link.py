"""A TCP link that can be cut and joined again."""

import select
import socket
import threading
from collections.abc import Iterator
from contextlib import contextmanager

LOOK_S = 0.01


class CutLink:
    """Carries bytes to and from `far`, a local port; refuses connections while cut."""

    def __init__(self, far: int) -> None:
        self._far = socket.create_connection(("127.0.0.1", far))
        self._door: socket.socket | None = socket.create_server(("127.0.0.1", 0))
        self.port = int(self._door.getsockname()[1])
        self._near: socket.socket | None = None
        self._cut, self._over = threading.Event(), threading.Event()

    def cut(self) -> None:
        self._cut.set()

    def join(self) -> None:
        self._cut.clear()

    def carry(self) -> None:
        while not self._over.is_set():
            if self._cut.is_set():
                self._close()
            elif self._door is None:
                self._door = socket.create_server(("127.0.0.1", self.port))
            self._carry([end for end in (self._far, self._near, self._door) if end is not None])
        self._close()
        self._far.close()

    def _carry(self, ends: list[socket.socket]) -> None:
        for end in select.select(ends, [], [], LOOK_S)[0]:
            if end is self._door:
                self._near, _ = end.accept()
                continue
            if end not in (self._far, self._near):  # closed a moment ago: what `far` sent could not be passed on
                continue
            opposite = self._near if end is self._far else self._far
            try:
                data = end.recv(65536)
            except ConnectionError:  # whoever is done closes it, at any time
                data = b""
            if not data:
                self._leave(end)
            elif opposite is not None:
                try:
                    opposite.sendall(data)
                except ConnectionError:
                    self._leave(opposite)

    def _leave(self, end: socket.socket) -> None:
        """Drop a closed end; without the vehicle, stop."""
        if end is self._far:
            self._over.set()
        elif end is self._near:
            end.close()
            self._near = None

    def _close(self) -> None:
        for end in (self._near, self._door):
            if end is not None:
                end.close()
        self._near = self._door = None

    def end(self) -> None:
        self._over.set()


@contextmanager
def cut_link(far: int) -> Iterator[CutLink]:
    link = CutLink(far)
    thread = threading.Thread(target=link.carry)
    thread.start()
    try:
        yield link
    finally:
        link.end()
        thread.join()
