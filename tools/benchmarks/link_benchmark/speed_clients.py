"""Upload a mission repeatedly over a perfect link; run as a module: one client process."""

import contextlib
import json
import socket
import struct
import sys
import time
from collections.abc import Callable, Sequence

from fastcrc.crc16 import mcrf4xx

from ipoa_mission.autopilot.autopilot import autopilot_named
from ipoa_mission.link import connect as link_connect
from ipoa_mission.link import mavsdk_backend
from ipoa_mission.link import upload as upload_module
from ipoa_mission.link.messages import MissionType
from ipoa_mission.link.wire import coordinate
from ipoa_mission.mission.items import Item
from ipoa_mission.mission.stored_mission import to_wire
from tools.benchmarks.link_benchmark.vehicle import mission

#: Uploads a list: calls its argument at the final Ack, and returns after the list was read back.
Upload = Callable[[Callable[[], None]], object]


def ours(port: int, items: Sequence[Item]) -> Upload:
    """Upload by our client: read back, compared."""
    upload_module.VERDICT_S = 0.0  # the wait for PX4's verdict is no matter of speed
    here = link_connect.connect(f"udpout:127.0.0.1:{port}", fast=False)

    def upload(acknowledged: Callable[[], None]) -> None:
        here.upload_items(items, MissionType.MISSION, lambda share, words: acknowledged() if share == 1 else None)

    return upload


def mavsdk(port: int, items: Sequence[Item]) -> Upload:
    """Upload and download by MAVSDK, not compared."""
    mavsdk_backend.PRESENCE_S = 60.0
    here = mavsdk_backend.connect(f"udpout:127.0.0.1:{port}")
    rows = [here._mavsdk_item(seq, item, 0) for seq, item in enumerate(items)]

    def upload(acknowledged: Callable[[], None]) -> None:
        here._raw.upload_mission(rows)
        acknowledged()
        assert len(here._raw.download_mission()) == len(items)

    return upload


def pymavlink(port: int, items: Sequence[Item]) -> Upload:
    """Upload and download by the loop of pymavlink's examples, without repeats, not compared."""
    from pymavlink import mavutil

    link = mavutil.mavlink_connection(f"udpout:127.0.0.1:{port}", source_system=255)
    link.mav.heartbeat_send(6, 8, 0, 0, 0)
    link.wait_heartbeat(timeout=10)
    to = link.target_system, link.target_component
    rows = [
        link.mav.mission_item_int_encode(
            *to, seq, one.frame, one.command, 0, 1, *one.params, *_integers(one), one.altitude, 0
        )
        for seq, one in enumerate(items)
    ]

    def upload(acknowledged: Callable[[], None]) -> None:
        link.mav.mission_count_send(*to, len(items), 0)
        while True:
            asked = link.recv_match(
                type=["MISSION_REQUEST", "MISSION_REQUEST_INT", "MISSION_ACK"], blocking=True, timeout=5
            )
            if asked.get_type() == "MISSION_ACK":
                break
            link.mav.send(rows[asked.seq])
        acknowledged()
        link.mav.mission_request_list_send(*to, 0)
        count = link.recv_match(type="MISSION_COUNT", blocking=True, timeout=5).count
        for seq in range(count):
            link.mav.mission_request_int_send(*to, seq, 0)
            assert link.recv_match(type="MISSION_ITEM_INT", blocking=True, timeout=5).seq == seq
        link.mav.mission_ack_send(*to, 0, 0)

    return upload


def pump(port: int, items: Sequence[Item]) -> Upload:
    """Upload by the least work in Python: frames packed once, one receive and one send an item, no check, no repeat."""
    link = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    link.connect(("127.0.0.1", port))
    link.settimeout(5.0)

    def frame(number: int, payload: bytes, extra: int) -> bytes:
        payload = payload.rstrip(b"\0")
        body = struct.pack("<BBBBBBHB", len(payload), 0, 0, 0, 245, 190, number, 0) + payload
        return b"\xfd" + body + mcrf4xx(body + bytes((extra,)), 0xFFFF).to_bytes(2, "little")

    rows = [
        frame(
            73,
            struct.pack(
                "<4f2if2H6B", *one.params, *_integers(one), one.altitude, n, one.command, 1, 1, one.frame, 0, 1, 0
            ),
            38,
        )
        for n, one in enumerate(items)
    ]
    questions = [frame(51, struct.pack("<HBB", n, 1, 1), 196) for n in range(len(items))]

    def upload(acknowledged: Callable[[], None]) -> None:
        link.send(frame(44, struct.pack("<HBB", len(items), 1, 1), 221))
        while True:
            heard = link.recv(300)
            if heard[7] in (40, 51):
                link.send(rows[int.from_bytes(heard[10:12], "little") if heard[1] > 1 else heard[10]])
            elif heard[7] == 47:
                break
        acknowledged()
        for question in questions:
            link.send(question)
            while link.recv(300)[7] != 73:
                pass

    link.send(frame(0, struct.pack("<IBBBBB", 0, 6, 8, 0, 0, 3), 50))
    return upload


def _integers(item: Item) -> tuple[int, int]:
    return coordinate(item.latitude_deg, item.frame), coordinate(item.longitude_deg, item.frame)


CLIENTS: dict[str, Callable[[int, Sequence[Item]], Upload]] = {
    "ours": ours,
    "mavsdk": mavsdk,
    "pymavlink": pymavlink,
    "pump": pump,
}


def main(client: str, port: str, family: str, count: str) -> None:
    items = to_wire(mission(autopilot_named(family), int(count)))
    with contextlib.redirect_stdout(sys.stderr):
        upload = CLIENTS[client](int(port), items)
    print("ready", flush=True)
    for _ in sys.stdin:
        marks = []
        cpu_s, begun_s = time.process_time(), time.monotonic()

        def mark() -> None:
            marks.append((time.monotonic() - begun_s, time.process_time() - cpu_s))  # noqa: B023

        upload(mark)
        mark()
        print(json.dumps([marks[0], marks[-1]]), flush=True)


if __name__ == "__main__":
    main(*sys.argv[1:])
