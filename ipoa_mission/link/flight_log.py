"""Flights out of logs: what ground stations (`.tlog`), ArduPilot (`.bin`) and PX4 (`.ulg`) wrote down on the way.

All three are told to one `Logbook`, as a live link would tell it, so that a flight means the same wherever it comes
from. What an autopilot writes down more finely than it sends is told at its own time.
"""

from collections.abc import Iterable, Iterator
from pathlib import Path

from ipoa_mission.errors import BadInput, MissionError
from ipoa_mission.link.codec import Codec
from ipoa_mission.link.dataflash import read_dataflash
from ipoa_mission.link.logbook import FlightRecord, Logbook
from ipoa_mission.link.logged import told
from ipoa_mission.link.messages import (
    AUTOPILOT_COMPONENT,
    STATION_COMPONENT,
    STATION_SYSTEM,
    CommandAck,
    CommandResult,
    Firmware,
    Heartbeat,
    Message,
)
from ipoa_mission.link.modes import MISSION_MODE
from ipoa_mission.link.orders import COMPONENT_ARM_DISARM, DO_SET_MODE, MISSION_START
from ipoa_mission.link.tlog import read_tlog
from ipoa_mission.link.ulog import read_ulog
from ipoa_mission.mission.firmware_facts import FIRMWARE
from ipoa_mission.mission.items import Mission


def read_flight(path: str | Path, mission: Mission) -> FlightRecord:
    """The first flight of `mission` in a `.tlog`, `.bin` or `.ulg`: from armed in the mission mode until disarmed.

    Raises:
        BadInput: another ending, or not a log of that kind.
        MissionError: nothing in it was flown in the mission mode, or a package to read it is missing.
    """
    path = Path(path)
    match path.suffix.lower():
        case ".tlog":
            return flight_of(_heard(path), mission, path)
        case ".bin":
            return flight_of(told(*read_dataflash(path)), mission, path)
        case ".ulg":
            return flight_of(told(*read_ulog(path)), mission, path)
    raise BadInput(f"{path}: expected a log whose name ends in .tlog, .bin or .ulg")


def flight_of(messages: Iterable[Message], mission: Mission, path: Path) -> FlightRecord:
    """The first flight in what a vehicle said.

    A heartbeat comes once a second. So the flight begins where, since the last heartbeat that knew nothing of it, the
    vehicle agreed to arm, to change its mode or to start; and only failing that with the heartbeat that shows it.
    """
    mode = MISSION_MODE[mission.autopilot]
    logbook = Logbook(mission.items, mission.autopilot)
    coming = iter(messages)
    since_beat: list[Message] = []
    for message in coming:
        since_beat.append(message)
        if not isinstance(message, Heartbeat):
            continue
        begins = message.armed and message.custom_mode == mode
        agreed = [n for n, said in enumerate(since_beat) if _agrees(said)]
        first = agreed[-1] + 1 if agreed and begins else len(since_beat)
        _note(logbook, since_beat[:first])
        if begins:
            _note(logbook, since_beat[first:])
            for later in coming:
                logbook.note(later)
                if logbook.disarmed_s is not None:
                    break
            return logbook.record()
        since_beat.clear()
    raise MissionError(
        f"{path}: nothing in it was flown in {FIRMWARE[mission.autopilot].name}'s mission mode",
        hint="is it the log of this flight, and of this autopilot?",
    )


def _note(logbook: Logbook, messages: Iterable[Message]) -> None:
    for message in messages:
        logbook.note(message)


def _agrees(message: Message) -> bool:
    return (
        isinstance(message, CommandAck)
        and message.command in (COMPONENT_ARM_DISARM, DO_SET_MODE, MISSION_START)
        and message.result == CommandResult.ACCEPTED
    )


def _heard(path: Path) -> Iterator[Message]:
    """What the first autopilot that is heard in a `.tlog` said."""
    codec, system = Codec(STATION_SYSTEM, STATION_COMPONENT), None
    for record in read_tlog(path):
        heard = codec.decode(record.frame)
        if heard is None or heard.message is None or heard.component != AUTOPILOT_COMPONENT:
            continue
        if system is None and isinstance(heard.message, Heartbeat) and heard.message.autopilot != Firmware.INVALID:
            system = heard.system
        if heard.system == system:
            yield heard.message
