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
from ipoa_mission.link.codec import Codec, Target
from ipoa_mission.link.connect import meet
from ipoa_mission.link.line import Line
from ipoa_mission.link.loopback import Loopback
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
    Reached,
    Request,
    RequestList,
    SetCurrent,
    Text,
)
from ipoa_mission.link.telemetry import Position
from ipoa_mission.link.tlog import read_tlog
from ipoa_mission.mission.mission_io import read_mission_file
from ipoa_mission.simulator.built_in_autopilot import BuiltInAutopilot as BuiltIn
from ipoa_mission.simulator.situation import Conditions
from tests.px4_waypoints import PX4_117

SESSIONS = Path(__file__).resolve().parents[1] / "sessions"
STATION, SPEEDUP = 245, 4.0
LANDS_WITHIN_S = 5.0  # of the real one
#: Seconds from arming until each item was done.
FLOWN = {
    "fly-ardupilot": (9.518, 9.518, 15.868, 20.82, 39.32),
    "fly-again-ardupilot": (9.65, 9.65, 17.348, 24.7, 43.2),
    "fly-px4": (10.4, 10.4, 14.44, 20.32, 36.4),
    "fly-again-px4": (19.7, 19.7, 24.636, 30.54, 43.28),
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


def said(name: str) -> list[Said]:
    codec, told = Codec(250, 1), []
    for record in read_tlog(SESSIONS / f"{name}.tlog"):
        heard = codec.decode(record.frame)
        assert heard is not None
        assert heard.message is not None
        told.append(Said(record.unix_s, heard.system == STATION, heard.message, record.frame))
    return [Said(one.at - told[0].at, one.by_client, one.message, one.frame) for one in told]


def autopilot_of(name: str) -> Autopilot:
    return autopilot_named(name.rsplit("-", 1)[1])


# --- what the vehicle said, into our client ---------------------------------------------------------------------------


class Playback:
    """A `FarEnd` that sends each recorded message once the client has sent what came before it."""

    def __init__(self, recorded: list[Said]) -> None:
        self._ahead: list[Said] = []
        asked: Message | None = None
        acknowledged: set[Message] = set()
        for one in recorded:
            if one.by_client and one.message != asked:
                asked = one.message
                acknowledged.clear()
            elif one.by_client or one.message in acknowledged:
                continue  # repeated; a stream was requested up to three times
            elif isinstance(one.message, CommandAck) and one.message.command == VehicleCommand.SET_MESSAGE_INTERVAL:
                acknowledged.add(one.message)
            self._ahead.append(one)
        self._codec = Codec(250, 1)
        self._clock = 0.0, 0.0  # a moment of the channel, and the recorded one
        self._outbox: list[bytes] = []

    def receive(self, data: bytes, peer: Peer, now: float) -> None:
        heard = self._codec.decode(data)
        if heard is not None and heard.message is not None and (asked := self._asked(heard.message)) is not None:
            self._clock = now, self._ahead[asked].at
            before = self._ahead[:asked]
            self._outbox.extend(one.frame for one in before if not one.by_client)
            del self._ahead[: asked + 1]
        self.tick(now)

    def _asked(self, spoken: Message) -> int | None:
        """Return which message ahead this is: the next, or one after what may go unsaid."""
        if self._waits is None:
            return None
        for number, one in enumerate(self._ahead):
            if not one.by_client:
                continue
            if type(one.message) is type(spoken) and getattr(one.message, "params", 0) == getattr(spoken, "params", 0):
                return number
            if not isinstance(one.message, MAY_GO_UNSAID):
                return None
        return None

    def tick(self, now: float) -> None:
        while self._ahead and not self._ahead[0].by_client and self._due(self._ahead[0]) <= now:
            self._outbox.append(self._ahead.pop(0).frame)

    def outgoing(self) -> list[tuple[bytes, Peer | None]]:
        told, self._outbox = self._outbox, []
        return [(frame, None) for frame in told]

    @property
    def deadline(self) -> float:
        return self._due(self._ahead[0]) if self._ahead and not self._ahead[0].by_client else math.inf

    @property
    def _waits(self) -> Said | None:
        return self._ahead[0] if self._ahead and self._ahead[0].by_client else None

    def _due(self, one: Said) -> float:
        return self._clock[0] + max(one.at - self._clock[1], 0.0)


def first_checksum(recorded: list[Said]) -> int:
    """Return the number of the first question for a checksum."""
    asked = [unpack(one.message) for one in recorded if one.by_client and isinstance(one.message, FileTransfer)]
    return next((one.sequence for one in asked if one.opcode == Opcode.CALC_FILE_CRC32), 0)


@pytest.mark.parametrize("name", FLOWN)
def test_what_the_real_one_said_is_the_same_flight_to_our_client(name: str) -> None:
    autopilot = autopilot_of(name)
    vehicle = meet(Line(Loopback(Playback(said(name))), Codec(STATION, 190)))
    vehicle._numbers = count(first_checksum(said(name)), 2)
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
    known = [(one.at, one.message.time_s) for one in recorded if isinstance(one.message, Position)] or [(0.0, 100.0)]
    down = [one.at for one in recorded if isinstance(one.message, Text) and one.message.text.startswith("Disarm")]
    for one in recorded:
        at, time_s = min(known, key=lambda pair: abs(pair[0] - one.at))
        if one.by_client:
            later = LANDS_WITHIN_S if down and one.at > down[-1] else 0.0
            yield time_s + SPEEDUP * (one.at - at) + later, one


def answers(name: str) -> list[tuple[float, Message]]:
    """Return the built-in autopilot's answers, with times."""
    autopilot = autopilot_of(name)
    recorded = said(name)
    home = read_mission_file(SESSIONS / f"{autopilot}.plan").mission.home
    mock = BuiltIn(autopilot, home, conditions=Conditions(version=PX4_117.get(autopilot), cold=True))
    told: list[tuple[float, Message]] = []

    def live(until: float) -> None:
        while mock.deadline < until:
            mock.tick(mock.deadline)
            told.extend((mock.vehicle.now, message) for message, _ in mock.outgoing())

    session = list(clock(recorded))
    if not name.startswith("fly"):  # the mission of the flight before lies there
        for when, one in clock(said(f"upload-{autopilot}")):
            live(when)
            mock.receive(one.message, Target(STATION, 190), max(when, mock.vehicle.now))
        live(mock.vehicle.now + 3.0)
        told.clear()
        session = [(mock.vehicle.now + SPEEDUP * one.at, one) for _, one in session]
    for when, one in session:
        live(when)
        mock.receive(one.message, Target(STATION, 190), max(when, mock.vehicle.now))
    live(mock.vehicle.now + (60.0 if name.startswith("fly") else 2.0))
    return told


def talk(messages: list[Message]) -> dict[str, list[Any]]:
    """Return what matters of a vehicle's messages, by kind, without repetitions."""
    mine = ("Arm", "Disarm", "Mission", "Reached command", "Executing", "Climb to", "Flight plan", "Mode change")
    kinds: dict[str, list[Any]] = {
        "commands": [(one.command, one.result) for one in messages if isinstance(one, CommandAck)],
        "lists": [(one.result, one.kind) for one in messages if isinstance(one, Ack)],
        "items": [
            (one.seq, one.kind, one.item.command, one.item.frame, one.item.autocontinue)
            for one in messages
            if isinstance(one, ItemAt)
        ],
        "reached": [one.seq for one in messages if isinstance(one, Reached)],
        "words": [one.text for one in messages if isinstance(one, Text) and one.text.startswith(mine)],
        "current": [(one.seq, one.total) for one in messages if isinstance(one, Current)],
        "modes": [(one.custom_mode, one.armed) for one in messages if isinstance(one, Heartbeat)],
        "parameters": [
            (one.param_id, one.param_type, one.param_value) for one in messages if isinstance(one, ParamValue)
        ],
    }
    return {kind: [one for one, _ in groupby(told)] for kind, told in kinds.items()}


@pytest.mark.parametrize("name", [f"{verb}-{autopilot}" for verb in VERBS for autopilot in registered()])
def test_the_built_in_autopilot_answers_as_the_real_one_did(name: str) -> None:
    real = talk([one.message for one in said(name) if not one.by_client])
    ours = talk([message for _, message in answers(name)])
    for kind, told in real.items():
        got = ours[kind]
        if not name.startswith("fly") and kind in (
            "current",
            "modes",
            "words",
            "reached",
        ):  # they depend on what was before
            continue
        if kind == "commands":  # the client may leave before the last answer
            got = got[: len(told)]
        if kind == "modes":  # a short one falls between heartbeats
            heard = iter(told)
            assert all(mode in heard for mode in got[1:]), kind
            assert got[-1] == told[-1]
            continue
        if kind == "current":  # what it was before the session is not recorded
            got = got[-len(told) :]
        assert got == told, kind
