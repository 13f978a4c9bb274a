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
            self._carry([one for one in (self._far, self._near, self._door) if one is not None])
        self._close()
        self._far.close()

    def _carry(self, ends: list[socket.socket]) -> None:
        for one in select.select(ends, [], [], LOOK_S)[0]:
            if one is self._door:
                self._near, _ = one.accept()
                continue
            other = self._near if one is self._far else self._far
            try:
                data = one.recv(65536)
            except ConnectionError:  # whoever is done closes it, at any time
                data = b""
            if not data:
                self._leave(one)
            elif other is not None:
                try:
                    other.sendall(data)
                except ConnectionError:
                    self._leave(other)

    def _leave(self, one: socket.socket) -> None:
        """Drop a closed end; without the vehicle, stop."""
        if one is self._far:
            self._over.set()
        elif one is self._near:
            one.close()
            self._near = None

    def _close(self) -> None:
        for one in (self._near, self._door):
            if one is not None:
                one.close()
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
