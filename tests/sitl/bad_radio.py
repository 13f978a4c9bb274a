import random
import select
import socket
import threading
from collections.abc import Iterator
from contextlib import contextmanager

from ipoa_mission.link.channel import Transport, parse_address


@contextmanager
def bad_radio(link: str, loss: float, seed: int) -> Iterator[str]:
    """Relay a link and lose datagrams; return the near end's link (udpin, udpout, tcp)."""
    far, near, chance = _open(link), socket.socket(socket.AF_INET, socket.SOCK_DGRAM), random.Random(seed)
    near.bind(("127.0.0.1", 0))
    enough = threading.Event()
    thread = threading.Thread(target=_carry, args=(far, near, loss, chance, enough))
    thread.start()
    try:
        yield f"udpout:127.0.0.1:{near.getsockname()[1]}"
    finally:
        enough.set()
        thread.join()
        far.close()
        near.close()


def _open(link: str) -> socket.socket:
    address = parse_address(link)
    place = (address.host, address.port)
    if address.transport is Transport.TCP_OUT:
        return socket.create_connection(place)
    far = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    if address.transport is Transport.UDP_OUT:
        far.connect(place)
    else:
        far.bind(place)
    return far


def _carry(
    far: socket.socket, near: socket.socket, loss: float, chance: random.Random, enough: threading.Event
) -> None:
    client = vehicle = None
    is_stream = far.type == socket.SOCK_STREAM
    while not enough.is_set():
        for ready in select.select([far, near], [], [], 0.05)[0]:
            data, sender = ready.recvfrom(65536)
            if ready is far:
                vehicle = sender
            else:
                client = sender
            if chance.random() < loss:
                continue
            if ready is far and client is not None:
                near.sendto(data, client)
            elif ready is near and (is_stream or vehicle is None):
                far.send(data) if is_stream or _is_connected(far) else None
            elif ready is near and vehicle is not None:
                far.sendto(data, vehicle)


def _is_connected(far: socket.socket) -> bool:
    try:
        far.getpeername()
    except OSError:
        return False
    return True
