"""Send garbage to both ends of the link.

Built-in autopilots get bytes, torn and damaged frames, and whole frames of every MAVLink message with absurd fields, in
floods, before and in flight. They must not raise or grow, and with a key they must not let a stranger arm them or
change a list. The client's conversations get random messages of the mission service, and must end with a result or a
`MissionError`. The reader of logs gets damaged logs.
"""

import contextlib
import math
import random
import struct
import tempfile
from collections.abc import Callable
from contextlib import closing
from pathlib import Path
from typing import Any

import pytest
from pymavlink.dialects.v20 import ardupilotmega as dialect

from ipoa_mission.autopilot.autopilot import Autopilot, registered
from ipoa_mission.errors import MissionError
from ipoa_mission.geodesy import Geodetic
from ipoa_mission.link import messages as m
from ipoa_mission.link.codec import EVERYONE, Codec, Framer, Target, TlogWriter, frames, read_tlog
from ipoa_mission.link.conversations import clear, download
from ipoa_mission.link.departure import Departure, depart, prepare
from ipoa_mission.link.dialogue import SPECIFIED, Cancelled, Exchange, TimeUp
from ipoa_mission.link.mavftp import FileMessage, Opcode, read_file
from ipoa_mission.link.orders import request_parameters, set_current
from ipoa_mission.link.signing import Signer
from ipoa_mission.link.upload import Upload, upload, upload_by_file
from ipoa_mission.link.vehicle_state import VehicleState
from ipoa_mission.link.vehicle_words import event_number
from ipoa_mission.mission.items import Item
from ipoa_mission.simulator.built_in_autopilot import BuiltInAutopilot as Mock
from ipoa_mission.simulator.station import Station

HOME = Geodetic(47.4, 8.5, 400.0)
KINDS = list(dialect.mavlink_map.values())
MISSION_KINDS = [
    dialect.mavlink_map[n] for n in (11, 39, 40, 41, 43, 44, 45, 47, 51, 73, 75, 76, 23, 20, 21, 110, 111, 4)
]
COMMANDS = [16, 20, 21, 22, 176, 177, 193, 224, 300, 400, 410, 510, 511, 512, 520]
ITEMS = (Item(22, 3, (0.0,) * 4, 47.4, 8.5, 20.0), Item(16, 3, (0.0,) * 4, 47.401, 8.5, 30.0))
EVENTS = [event_number(f"navigator_mis_{name}") for name in ("unsup_cmd", "takeoff_too_low", "land_missing")]
ABSURD = [0.0, 1.0, -1.0, math.nan, math.inf, -math.inf, 1e38, 2.0, 3.0, 4.0, 33.0, 242.0]


def frame(chance: random.Random, voice: dialect.MAVLink, system: int) -> bytes:
    """Return a whole frame with random or absurd fields, often addressed to the vehicle."""
    kind = chance.choice(MISSION_KINDS if chance.random() < 0.7 else KINDS)
    payload = bytearray(chance.randbytes(kind.unpacker.size))
    if chance.random() < 0.7:
        values = kind.unpacker.unpack(payload)
        sane = []
        for name, value in zip(kind.ordered_fieldnames, values, strict=False):
            if name == "target_system":
                value = chance.choice([0, 1, 1, 1, system])
            elif name == "target_component":
                value = chance.choice([0, 1])
            elif name in ("seq", "count", "start_index", "end_index", "frame", "mission_type"):
                value = chance.choice([0, 0, 1, 1, 2, 3, 7, 255 if isinstance(value, int) and value < 256 else 650])
            elif name == "command":
                value = chance.choice(COMMANDS)
            elif isinstance(value, float):
                value = chance.choice(ABSURD)
            sane.append(value)
        with contextlib.suppress(struct.error):
            payload = bytearray(kind.unpacker.pack(*sane, *values[len(sane) :]))
    message = kind.__new__(kind)
    dialect.MAVLink_message.__init__(message, kind.id, kind.msgname)
    return bytes(message._pack(voice, kind.crc_extra, bytes(payload)))


def spoil(chance: random.Random, data: bytes) -> bytes:
    """Return the bytes with one place cut, doubled or overwritten."""
    at = chance.randrange(len(data) + 1)
    return chance.choice([data[:at], data[at:] + data, data[:at] + chance.randbytes(3) + data[at + 3 :]])


def absurd_item(chance: random.Random) -> Item:
    params = tuple(chance.choice(ABSURD) for _ in range(4))
    command = chance.choice([16, 17, 19, 20, 21, 22, 82, 93, 177, 178, 18])
    place = (chance.choice([47.4, 0.0, 95.0, -200.0, 47.40001]), chance.choice([8.5, 0.0, 200.0]))
    return Item(command, chance.choice([0, 2, 3, 3, 3, 6, 10]), params, *place, chance.choice(ABSURD))  # type: ignore[arg-type]


def fly_something_absurd(chance: random.Random) -> None:
    family = chance.choice(list(registered()))
    mock, now, client = Mock(family, HOME), 1.0, Target(245, 190)
    items = [*ITEMS[: chance.randrange(3)], *(absurd_item(chance) for _ in range(chance.randrange(1, 5)))]
    if family is Autopilot.ARDUPILOT:
        items = [Item(16, 0, (0.0,) * 4, 47.4, 8.5, 400.0), *items]
    orders = [m.Count(len(items)), *(m.ItemAt(seq, item) for seq, item in enumerate(items))]
    orders += [
        m.CommandLong(400, (1.0,) + (0.0,) * 6),
        m.CommandLong(300),
        m.CommandLong(176, (1.0, 4.0, 4.0) + (0.0,) * 4),
    ]
    codec = Codec(1, 1)
    for message in orders:
        mock.receive(message, client, now)
    for _ in range(60):
        now += chance.choice([0.02, 0.5, 5.0])
        mock.tick(now)
        if chance.random() < 0.2:
            number = chance.choice(COMMANDS)
            params = tuple(chance.choice(ABSURD) for _ in range(7))
            mock.receive(m.CommandLong(number, params), client, now)  # type: ignore[arg-type]
        for answer, target in mock.outgoing():
            codec.encode(answer, target, 0.0)


def storm_an_autopilot(chance: random.Random) -> None:
    """Send garbage to a vehicle for a second or more."""
    signed = chance.random() < 0.3
    family = chance.choice(list(registered()))
    mock = Mock(family, HOME)
    station = Station(mock, signer=Signer(bytes(32)) if signed else None)
    voice, now = dialect.MAVLink(None, 245, 190), 0.0
    for _ in range(chance.randrange(1, 300)):
        now += chance.choice([0.0, 0.0, 0.01, 0.3, 2.0])
        data = frame(chance, voice, 245)
        if chance.random() < 0.2:
            data = spoil(chance, data)
        station.receive(data, f"peer {chance.randrange(50)}", now)
        station.tick(now)
        frames = station.outgoing()
        assert len(frames) < 5000, f"{len(frames)} messages at once"
    if signed:
        assert not mock.flight.armed, "a stranger has armed a vehicle with a key"
        assert not any(store.items for store in mock.transfers.stores.values()), "a stranger has changed a list"
    for store in mock.transfers.stores.values():
        assert len(store.items) <= 10_000


def random_message(chance: random.Random) -> m.Message:
    """Return a message of a mission, file or parameter conversation."""
    small = chance.choice([0, 0, 1, 2, 3, 65535])
    kind = chance.choice([0, 0, 0, 1, 255])
    return chance.choice(
        [
            m.Request(small, kind, legacy=chance.random() < 0.5),
            m.Count(small, kind),
            m.Ack(chance.randrange(20), kind),
            m.ItemAt(small, chance.choice(ITEMS), kind),
            m.Text(chance.randrange(8), "words"),
            m.Current(small, 2, chance.randrange(6)),
            m.Event(chance.choice([chance.getrandbits(32), *EVENTS]), 0, chance.randbytes(chance.randrange(12))),
            m.CommandAck(chance.choice(COMMANDS), chance.randrange(8)),
            m.ParamValue("A", chance.choice(ABSURD), chance.randrange(12), 1, 0),
            m.FileTransfer(chance.randbytes(251)),
            FileMessage(chance.randrange(12), Opcode.ACK, 0, chance.randrange(12), 0, b"\x3d" * 200).pack(),
            m.Heartbeat(2, 12),
            m.AutopilotVersion(chance.getrandbits(60)),
        ]
    )  # fmt: skip


def mislead_a_client(chance: random.Random) -> None:
    """Hold a conversation with a vehicle that answers at random."""
    family = chance.choice(list(registered()))
    job = Upload(ITEMS, family)
    departure = Departure(VehicleState(family), 1, 1)
    dialogues: list[Callable[[], Any]] = [
        lambda: upload(job),
        lambda: upload_by_file(job),
        lambda: download(0),
        lambda: clear(255),
        lambda: set_current(1, 0),
        lambda: prepare(departure),
        lambda: depart(departure),
        lambda: request_parameters(("A", "B"), family),
        lambda: read_file("x"),
    ]
    dialogue = chance.choice(dialogues)()
    now = 0.0
    try:
        exchange: Exchange[object] = Exchange(dialogue, now, SPECIFIED)
        for _ in range(3000):
            if exchange.finished:
                return
            exchange.outgoing()
            if chance.random() < 0.002:
                exchange.interrupt(chance.choice([Cancelled, TimeUp])("broken off"), now)
            elif chance.random() < 0.8:
                now += 0.15
                exchange.receive(random_message(chance), now)
            else:
                now = max(now, min(exchange.deadline, now + 40.0))
                exchange.tick(now)
    except MissionError:
        return


def spoil_a_log(chance: random.Random) -> None:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "a.tlog"
        codec = Codec(1, 1)
        with closing(TlogWriter(path)) as log:
            for n in range(chance.randrange(30)):
                log.write(codec.encode(m.Text(3, f"words {n}"), EVERYONE, 0.0), 1.7e9 + n)
        path.write_bytes(spoil(chance, path.read_bytes()))
        for record in read_tlog(path):
            codec.decode(record.frame)


def tear_a_stream(chance: random.Random) -> None:
    """Read frames and garbage, cut anywhere."""
    voice, judge = dialect.MAVLink(None, 1, 1), Codec(245, 190)
    data = b"".join(
        frame(chance, voice, 245) if chance.random() < 0.6 else chance.randbytes(chance.randrange(40))
        for _ in range(20)
    )
    framer = Framer()
    while data:
        size = chance.randrange(1, 80)
        for piece in [*framer.feed(data[:size]), *frames(data[:size])]:
            heard = judge.decode(piece)
            assert heard is None or isinstance(heard.target, Target)
        data = data[size:]
        assert len(framer.buffer) <= 300, "the framer hoards"


TARGETS = (fly_something_absurd, storm_an_autopilot, mislead_a_client, spoil_a_log, tear_a_stream)


@pytest.mark.parametrize("target", TARGETS, ids=lambda target: target.__name__)
def test_garbage_does_no_harm(target: Callable[[random.Random], object]) -> None:
    for seed in range(5):
        target(random.Random(seed))
