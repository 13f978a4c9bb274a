"""Recorded sessions of this client with ArduCopter and PX4 in simulation, against both of our ends.

The vehicle's messages go into the client, the client's into the built-in autopilot: both must act as recorded.
Recordings are thinned: telemetry, sensors' words, ArduCopter's counters, the client's heartbeats.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import count, groupby
from pathlib import Path
from typing import Any

import pytest

from ipoa_mission.autopilot.autopilot import Autopilot, autopilot_named, registered
from ipoa_mission.autopilot.commands import VehicleCommand
from ipoa_mission.link.channel import Peer
from ipoa_mission.link.codec import Codec, Target, read_tlog
from ipoa_mission.link.connect import meet
from ipoa_mission.link.connection import Connection
from ipoa_mission.link.mavftp import Opcode, unpack
from ipoa_mission.link.messages import (
    Ack,
    CommandAck,
    Current,
    FileTransfer,
    Heartbeat,
    ItemAt,
    Message,
    ParamValue,
    Position,
    Reached,
    Request,
    RequestList,
    SetCurrent,
    Text,
)
from ipoa_mission.mission.mission_io import read_mission_file
from ipoa_mission.simulator.built_in_autopilot import BuiltInAutopilot as BuiltIn
from ipoa_mission.simulator.situation import Conditions
from ipoa_mission.simulator.station import Loopback
from tests.px4_waypoints import PX4_117

SESSIONS = Path(__file__).resolve().parents[1] / "data" / "sessions"
STATION, SPEEDUP = 245, 4.0
LANDS_WITHIN_S = 5.0  # of the real one
#: Seconds from arming until each item was done.
FLOWN = {
    "fly-ardupilot": (8.948, 8.948, 15.398, 20.398, 38.888),
    "fly-again-ardupilot": (8.85, 8.85, 16.65, 24.0, 42.5),
    "fly-px4": (11.168, 11.168, 15.16, 21.452, 34.692),
    "fly-again-px4": (19.62, 19.62, 24.6, 31.092, 47.48),
}
#: Depends on timing: read a list, or set an index, once more or less.
MAY_GO_UNSAID = (RequestList, Request, Ack, SetCurrent)
VERBS = ("fly", "set", "upload", "download", "clear")


@dataclass(frozen=True)
class Said:
    """One message of a recording: when [s], by whom, its frame."""

    at: float
    by_client: bool
    message: Message
    frame: bytes


def recorded_session(name: str) -> list[Said]:
    codec, records = Codec(250, 1), []
    for record in read_tlog(SESSIONS / f"{name}.tlog"):
        heard = codec.decode(record.frame)
        assert heard is not None
        assert heard.message is not None
        records.append(Said(record.unix_s, heard.system == STATION, heard.message, record.frame))
    return [Said(record.at - records[0].at, record.by_client, record.message, record.frame) for record in records]


def autopilot_of(name: str) -> Autopilot:
    return autopilot_named(name.rsplit("-", 1)[1])


# --- what the vehicle said, into our client ---------------------------------------------------------------------------


class Playback:
    """A `FarEnd` that sends each recorded message once the client has sent what came before it."""

    def __init__(self, recorded: list[Said]) -> None:
        self._ahead: list[Said] = []
        asked: Message | None = None
        acknowledged: set[Message] = set()
        for each in recorded:
            if each.by_client and each.message != asked:
                asked = each.message
                acknowledged.clear()
            elif each.by_client or each.message in acknowledged:
                continue  # repeated; a stream was requested up to three times
            elif isinstance(each.message, CommandAck) and each.message.command == VehicleCommand.SET_MESSAGE_INTERVAL:
                acknowledged.add(each.message)
            self._ahead.append(each)
        self._codec = Codec(250, 1)
        self._clock = 0.0, 0.0  # a moment of the channel, and the recorded one
        self._outbox: list[bytes] = []

    def receive(self, data: bytes, peer: Peer, now: float) -> None:
        heard = self._codec.decode(data)
        if heard is not None and heard.message is not None and (asked := self._asked(heard.message)) is not None:
            self._clock = now, self._ahead[asked].at
            before = self._ahead[:asked]
            self._outbox.extend(record.frame for record in before if not record.by_client)
            del self._ahead[: asked + 1]
        self.tick(now)

    def _asked(self, spoken: Message) -> int | None:
        """Return which message ahead this is: the next, or one after what may go unsaid."""
        if self._waits is None and not isinstance(spoken, FileTransfer):  # its repeat has another number
            return None
        for number, own in enumerate(self._ahead):
            if not own.by_client:
                continue
            if type(own.message) is type(spoken) and getattr(own.message, "params", 0) == getattr(spoken, "params", 0):
                return number
            if not isinstance(own.message, MAY_GO_UNSAID):
                return None
        return None

    def tick(self, now: float) -> None:
        while self._ahead and not self._ahead[0].by_client and self._due(self._ahead[0]) <= now:
            self._outbox.append(self._ahead.pop(0).frame)

    def outgoing(self) -> list[tuple[bytes, Peer | None]]:
        sent, self._outbox = self._outbox, []
        return [(frame, None) for frame in sent]

    @property
    def deadline(self) -> float:
        return self._due(self._ahead[0]) if self._ahead and not self._ahead[0].by_client else math.inf

    @property
    def _waits(self) -> Said | None:
        return self._ahead[0] if self._ahead and self._ahead[0].by_client else None

    def _due(self, record: Said) -> float:
        return self._clock[0] + max(record.at - self._clock[1], 0.0)


def first_checksum(recorded: list[Said]) -> int:
    """Return the number of the first question for a checksum."""
    asked = [unpack(each.message) for each in recorded if each.by_client and isinstance(each.message, FileTransfer)]
    return next((message.sequence for message in asked if message.opcode == Opcode.CALC_FILE_CRC32), 0)


@pytest.mark.parametrize("name", FLOWN)
def test_recorded_session_is_the_same_flight_to_our_client(name: str) -> None:
    autopilot = autopilot_of(name)
    vehicle = meet(Connection(Loopback(Playback(recorded_session(name))), Codec(STATION, 190)))
    vehicle._numbers = count(first_checksum(recorded_session(name)), 2)
    assert vehicle.autopilot is autopilot
    vehicle.home()
    vehicle.upload(read_mission_file(SESSIONS / f"{autopilot}.plan").mission)
    vehicle.parameters(["FENCE_ENABLE" if autopilot is Autopilot.ARDUPILOT else "GF_ACTION"])
    vehicle.prepare(permit=lambda place: None)
    vehicle.start()
    record = vehicle.watch()
    assert record.completed, record.why_not
    assert list(record.item_reached_s.values()) == pytest.approx(FLOWN[name], abs=0.6)  # telemetry is thinned


# --- what our client said, into the built-in autopilot ---------------------------------------------------------------


def clock(recorded: list[Said]) -> Iterator[tuple[float, Said]]:
    """Yield the client's messages by the vehicle's own clock."""
    known = [(r.at, r.message.time_s) for r in recorded if isinstance(r.message, Position)] or [(0.0, 100.0)]
    down = [each.at for each in recorded if isinstance(each.message, Text) and each.message.text.startswith("Disarm")]
    for record in recorded:
        at, time_s = min(known, key=lambda pair: abs(pair[0] - record.at))
        if record.by_client:
            later = LANDS_WITHIN_S if down and record.at > down[-1] else 0.0
            yield time_s + SPEEDUP * (record.at - at) + later, record


def answers(name: str) -> list[tuple[float, Message]]:
    """Return the built-in autopilot's answers, with times."""
    autopilot = autopilot_of(name)
    recorded = recorded_session(name)
    home = read_mission_file(SESSIONS / f"{autopilot}.plan").mission.home
    mock = BuiltIn(autopilot, home, conditions=Conditions(version=PX4_117.get(autopilot), cold=True))
    answered: list[tuple[float, Message]] = []

    def live(until: float) -> None:
        while mock.deadline < until:
            mock.tick(mock.deadline)
            answered.extend((mock.vehicle.now, message) for message, _ in mock.outgoing())

    session = list(clock(recorded))
    if not name.startswith("fly"):  # the mission of the flight before lies there
        for when, record in clock(recorded_session(f"upload-{autopilot}")):
            live(when)
            mock.receive(record.message, Target(STATION, 190), max(when, mock.vehicle.now))
        live(mock.vehicle.now + 3.0)
        answered.clear()
        session = [(mock.vehicle.now + SPEEDUP * record.at, record) for _, record in session]
    for when, record in session:
        live(when)
        mock.receive(record.message, Target(STATION, 190), max(when, mock.vehicle.now))
    live(mock.vehicle.now + (60.0 if name.startswith("fly") else 2.0))
    return answered


def talk(messages: list[Message]) -> dict[str, list[Any]]:
    """Return what matters of a vehicle's messages, by kind, without repetitions."""
    mine = ("Arm", "Disarm", "Mission", "Reached command", "Executing", "Climb to", "Flight plan", "Mode change")
    kinds: dict[str, list[Any]] = {
        "commands": [(message.command, message.result) for message in messages if isinstance(message, CommandAck)],
        "lists": [(message.result, message.kind) for message in messages if isinstance(message, Ack)],
        "items": [
            (message.seq, message.kind, message.item.command, message.item.frame, message.item.autocontinue)
            for message in messages
            if isinstance(message, ItemAt)
        ],
        "reached": [message.seq for message in messages if isinstance(message, Reached)],
        "words": [message.text for message in messages if isinstance(message, Text) and message.text.startswith(mine)],
        "current": [(message.seq, message.total) for message in messages if isinstance(message, Current)],
        "modes": [(each.custom_mode, each.armed) for each in messages if isinstance(each, Heartbeat)],
        "parameters": [
            (each.param_id, each.param_type, each.param_value) for each in messages if isinstance(each, ParamValue)
        ],
    }
    return {kind: [content for content, _ in groupby(contents)] for kind, contents in kinds.items()}


@pytest.mark.parametrize("name", [f"{verb}-{autopilot}" for verb in VERBS for autopilot in registered()])
def test_the_built_in_autopilot_answers_as_the_real_one_did(name: str) -> None:
    real = talk([record.message for record in recorded_session(name) if not record.by_client])
    ours = talk([message for _, message in answers(name)])
    for kind, contents in real.items():
        got = ours[kind]
        if not name.startswith("fly") and kind in (
            "current",
            "modes",
            "words",
            "reached",
        ):  # they depend on what was before
            continue
        if kind == "commands":  # the client may leave before the last answer
            got = got[: len(contents)]
        if kind == "modes":  # a short one falls between heartbeats
            heard = iter(contents)
            assert all(mode in heard for mode in got[1:]), kind
            assert got[-1] == contents[-1]
            continue
        if kind == "current":  # what it was before the session is not recorded
            got = got[-len(contents) :]
        assert got == contents, kind
