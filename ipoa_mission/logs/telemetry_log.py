"""Ground station's log (`.tlog`): messages from and to one vehicle.

Heartbeats come once a second. The first report since the last one in the old state times an arming.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from enum import IntEnum
from pathlib import Path

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from ipoa_mission.autopilot.autopilot import Autopilot
from ipoa_mission.autopilot.commands import Command
from ipoa_mission.autopilot.vehicle_kind import VehicleKind, with_article
from ipoa_mission.errors import BadInput, MissionError, NothingThere
from ipoa_mission.geometry import Vector
from ipoa_mission.link import messages as m
from ipoa_mission.link.codec import Codec
from ipoa_mission.link.mavftp import MISSION_FILE, Opcode, unpack
from ipoa_mission.link.messages import (
    AUTOPILOT_COMPONENT,
    STATION_COMPONENT,
    STATION_SYSTEM,
    CommandAck,
    CommandInt,
    CommandLong,
    CommandResult,
    Current,
    Event,
    Heartbeat,
    MavAutopilot,
    Message,
    ParamValue,
    Reached,
    Text,
    TimeSync,
)
from ipoa_mission.link.mission_upload_file import unpack_mission
from ipoa_mission.link.orders import parameter_value
from ipoa_mission.link.telemetry import (
    Attitude,
    AutopilotVersion,
    BatteryStatus,
    HomePosition,
    LocalPosition,
    Position,
    SystemStatus,
    SystemTime,
)
from ipoa_mission.link.tlog import LostFrames, read_tlog
from ipoa_mission.logs.logged import Battery, Fixes, Held, Log, Measured, item_begun, presence, version_name
from ipoa_mission.mission.items import Item

Items = tuple[Item, ...]


@dataclass
class _List:
    count: int
    to_vehicle: bool
    items: dict[int, Item] = field(default_factory=dict)

    @property
    def whole(self) -> Items | None:
        return tuple(self.items[n] for n in range(self.count)) if len(self.items) == self.count else None


class Transfers:
    """`note` returns the items that the vehicle then holds."""

    def __init__(self) -> None:
        self._onboard: Items = ()
        self._list: _List | None = None
        self._file: dict[int, bytes] | None = None  # mission.dat: data by offset
        self._written = False

    def note(self, message: m.Message, by_vehicle: bool) -> Items | None:
        complete = self._note_file(message, by_vehicle) if isinstance(message, m.FileTransfer) else None
        match message:
            case m.Count(count, m.MissionType.MISSION):
                if self._list is None or (self._list.count, self._list.to_vehicle) != (count, not by_vehicle):
                    self._list = _List(count, not by_vehicle)
                complete = () if by_vehicle and not count else None
            case m.WritePartialList(first, _, m.MissionType.MISSION) if first < len(self._onboard):
                self._list = _List(len(self._onboard), True, dict(enumerate(self._onboard)))
            case m.ClearAll(m.MissionType.MISSION | m.MissionType.ALL):
                self._list = _List(0, True)
            case m.ItemAt(seq, item, m.MissionType.MISSION) if self._list and seq < self._list.count:
                if by_vehicle != self._list.to_vehicle:
                    self._list.items[seq] = item
                    complete = self._list.whole if by_vehicle else None
            case m.Ack(result, m.MissionType.MISSION | m.MissionType.ALL) if by_vehicle and self._list:
                complete = self._list.whole if self._list.to_vehicle and result == m.Result.ACCEPTED else None
        if complete is not None:
            self._onboard, self._list = complete, None
        return complete

    def _note_file(self, message: m.FileTransfer, by_vehicle: bool) -> Items | None:
        request = unpack(message)
        match request.opcode:
            case Opcode.OPEN_FILE_RO | Opcode.CREATE_FILE | Opcode.OPEN_FILE_WO:
                ours = request.data.rstrip(b"\0").decode("utf-8", "replace") == MISSION_FILE
                self._file = {} if ours else None
                self._written = request.opcode != Opcode.OPEN_FILE_RO
            case Opcode.WRITE_FILE if self._file is not None:
                self._file[request.offset] = request.data
            case Opcode.ACK if self._file is not None and request.request in (Opcode.READ_FILE, Opcode.BURST_READ_FILE):
                self._file[request.offset] = request.data
                return None if self._written else self._whole_file()
            case Opcode.ACK if self._written and request.request == Opcode.TERMINATE_SESSION:
                return self._whole_file()
        return None

    def _whole_file(self) -> Items | None:
        data = b"".join(chunk for _, chunk in sorted((self._file or {}).items()))
        try:
            return unpack_mission(data)
        except MissionError:
            return None


def vehicle_time(message: Message) -> float | None:
    """Return the time since boot [s], if any."""
    match message:
        case Position() | Attitude() | LocalPosition():
            return message.time_s
        case SystemTime():
            return message.boot_s
        case TimeSync(0, nanoseconds) if 0 < nanoseconds < 1e17:  # a greater one is no boot time
            return nanoseconds / 1e9
    return None


def unwrapped(stamps: Vector, times: Vector) -> Vector:
    times = times.copy()
    for n in np.flatnonzero(np.diff(times) < -10.0):  # [s]: it restarted
        times[n + 1 :] += times[n] + (stamps[n + 1] - stamps[n]) - times[n + 1]
    return np.asarray(np.maximum.accumulate(times))


def vehicle_times(stamps: Vector, clock_at: Vector, clock: Vector) -> Vector:
    """Return the vehicle's time at `stamps`, from `clock` at others, all increasing; without a clock the stamps."""
    if not len(clock):
        return stamps
    first, last = clock_at[0], clock_at[-1]
    begins = clock[0] + (stamps - first) * _pace(clock_at, clock, slice(None))
    ends = clock[-1] + (stamps - last) * _pace(clock_at, clock, slice(None, None, -1))
    between = np.interp(stamps, clock_at, clock)
    return np.where(stamps < first, begins, np.where(stamps > last, ends, between))


def _pace(clock_at: Vector, clock: Vector, order: slice) -> float:
    at, times = clock_at[order], clock[order]
    near = np.abs(at - at[0]) <= 2.0  # [s], the span that gives the rate
    span = at[near][-1] - at[0]
    if not span:
        near = np.ones(len(at), bool)
        span = at[-1] - at[0]
    return float((times[near][-1] - times[0]) / span) if span else 1.0


def growing(stamps: Sequence[float]) -> Vector:
    """Return increasing stamps from the first; those over 60 s off get their neighbors' median."""
    raw = np.asarray(stamps, float)
    around = np.median(sliding_window_view(np.pad(raw, 2, mode="edge"), 5), axis=1)
    since = np.where(np.abs(raw - around) > 60.0, around, raw)
    return np.asarray(np.maximum.accumulate(since - since[0]) + 1e-9 * np.arange(len(since)))


ARMING_TEXTS = ("Arming motors", "Armed by", "ARMED by")
DISARMING_TEXTS = ("Disarming motors", "Disarmed by", "DISARMED by")
NO_CLOCK = "the log has no clock of the vehicle: its times are those of the ground station"


class PX4Event(IntEnum):
    """Events commander_armed_by, commander_disarmed_by: component 1, FNV-1a of the name."""

    ARMED_BY = 0x190CAF3
    DISARMED_BY = 0x1F46777


@dataclass
class _Gathered:
    transfers: Transfers = field(default_factory=Transfers)
    messages: list[tuple[int, Message]] = field(default_factory=list)
    times: list[tuple[int, float]] = field(default_factory=list)
    state: Heartbeat | None = None
    ordered: bool | None = None
    changes: list[tuple[int, bool]] = field(default_factory=list)  # of arming, since the last heartbeat
    unconfirmed: bool = False  # heartbeat still in the old state
    version: str = ""
    measured: list[tuple[int, Attitude | BatteryStatus | SystemStatus]] = field(default_factory=list)


def read_telemetry_log(path: Path, system: int | None = None) -> Log:
    """Return positions and events of one autopilot: this system id, or the first multicopter."""
    codec, gathered, missing = Codec(STATION_SYSTEM, STATION_COMPONENT), _Gathered(), LostFrames()
    stamps, kinds = list[float](), dict[int, VehicleKind]()
    chosen = None
    for record in read_tlog(path, missing):
        heard = codec.decode(record.frame)
        if heard is None or heard.message is None:
            continue
        beat = heard.message if heard.component == AUTOPILOT_COMPONENT else None
        if heard.system not in kinds and isinstance(beat, Heartbeat) and beat.autopilot != MavAutopilot.INVALID:
            kind = kinds[heard.system] = VehicleKind(beat.autopilot, beat.type)
            if chosen is None and _is_flown(kind) and system in (None, heard.system):
                chosen = heard.system
        if chosen is None:
            continue
        number = len(stamps)
        stamps.append(record.unix_s)
        if (heard.system, heard.component) == (chosen, AUTOPILOT_COMPONENT):
            _note_vehicle(gathered, number, heard.message, kinds[chosen].autopilot)
        elif heard.target.system in (0, chosen):
            _note_station(gathered, number, heard.message)
    if chosen is None:
        raise _not_in(path, kinds, system)
    autopilot = kinds[chosen].autopilot
    if gathered.state and gathered.changes and not gathered.changes[-1][1]:
        _change(gathered, gathered.state.custom_mode, autopilot)
    log = _dated(gathered, growing(stamps), autopilot)
    return replace(log, remarks=(*_others(kinds, chosen), *missing.remarks(chosen), *log.remarks))


def _is_flown(kind: VehicleKind) -> bool:
    return kind.is_flown or kind.mav_type in kind.autopilot.mav_types


def _listed(kinds: Mapping[int, VehicleKind]) -> str:
    return ", ".join(f"{system} ({kind})" for system, kind in sorted(kinds.items()))


def _others(kinds: Mapping[int, VehicleKind], chosen: int) -> Iterator[str]:
    if len(kinds) > 1:
        others = {system: kind for system, kind in kinds.items() if system != chosen}
        flown = [system for system, kind in others.items() if _is_flown(kind)]
        read = f"; --system {min(flown)} reads another" if flown else ""
        yield f"the log holds {len(kinds)} vehicles: read is system {chosen}, not read {_listed(others)}{read}"


def _not_in(path: Path, kinds: Mapping[int, VehicleKind], system: int | None) -> BadInput:
    if not kinds:
        return NothingThere("expected a .tlog with an autopilot's heartbeat, but there is none", place=path)
    if system is not None and system not in kinds:
        return BadInput(f"expected system {system}, but it holds {_listed(kinds)}", code="other-vehicle", place=path)
    kind = str(kinds[system] if system is not None else next(iter(kinds.values())))
    words = f"expected the log of a multicopter, not of {with_article(kind)}"
    words += f": it holds {_listed(kinds)}" if len(kinds) > 1 else ""
    return BadInput(words, code="other-vehicle", place=path)


def _note_station(gathered: _Gathered, number: int, message: Message) -> None:
    match message:
        case CommandLong(Command.COMPONENT_ARM_DISARM, params) | CommandInt(Command.COMPONENT_ARM_DISARM, _, params):
            gathered.ordered = params[0] >= 0.5
    _note_transfer(gathered, number, message, by_vehicle=False)


def _note_vehicle(gathered: _Gathered, number: int, message: Message, autopilot: Autopilot) -> None:
    if (time := vehicle_time(message)) is not None:
        gathered.times.append((number, time))
    match message:
        case Heartbeat():
            _beat(gathered, number, message, autopilot)
        case CommandAck(Command.COMPONENT_ARM_DISARM, CommandResult.ACCEPTED):
            _note_arming(gathered, number, not _is_armed(gathered) if gathered.ordered is None else gathered.ordered)
        case Event(PX4Event.ARMED_BY | PX4Event.DISARMED_BY as event):
            _note_arming(gathered, number, event == PX4Event.ARMED_BY)
        case Text(_, text):
            if text.startswith((*ARMING_TEXTS, *DISARMING_TEXTS)) and not gathered.changes:  # else an echo
                _note_arming(gathered, number, text.startswith(ARMING_TEXTS))
            if autopilot.protocol_profile.tells_items and (begun := item_begun(text)):
                gathered.messages.append((number, begun))
        case AutopilotVersion(_, version):
            gathered.version = version_name(version)
        case Attitude() | BatteryStatus() | SystemStatus():
            gathered.measured.append((number, message))
        case ParamValue():
            message = replace(message, param_value=parameter_value(message, autopilot))
    if isinstance(message, Position | Reached | Current | HomePosition | ParamValue | Text):
        gathered.messages.append((number, message))
    _note_transfer(gathered, number, message, by_vehicle=True)


def _note_transfer(gathered: _Gathered, number: int, message: Message, by_vehicle: bool) -> None:
    if (items := gathered.transfers.note(message, by_vehicle)) is not None:
        gathered.messages.append((number, Held(items)))


def _is_armed(gathered: _Gathered) -> bool:
    state = gathered.state
    return gathered.changes[-1][1] if gathered.changes else state is not None and state.armed


def _note_arming(gathered: _Gathered, number: int, armed: bool) -> None:
    if armed != _is_armed(gathered):
        gathered.changes.append((number, armed))
        gathered.unconfirmed = False


def _beat(gathered: _Gathered, number: int, beat: Heartbeat, autopilot: Autopilot) -> None:
    before = gathered.state
    if before and gathered.changes and gathered.changes[-1][1] == beat.armed:
        _change(gathered, before.custom_mode, autopilot)
    elif gathered.unconfirmed:
        gathered.changes.clear()
    gathered.state, gathered.unconfirmed = beat, bool(gathered.changes)
    if before is None or (before.armed, before.custom_mode) != (beat.armed, beat.custom_mode):
        gathered.messages.append((number, presence(autopilot, beat.armed, beat.custom_mode)))


def _change(gathered: _Gathered, mode: int, autopilot: Autopilot) -> None:
    gathered.messages += [(number, presence(autopilot, armed, mode)) for number, armed in gathered.changes]
    gathered.changes.clear()


def _dated(gathered: _Gathered, stamps: Vector, autopilot: Autopilot) -> Log:
    known_at = stamps[[number for number, _ in gathered.times]] if gathered.times else np.empty(0)
    clock = unwrapped(known_at, np.array([time for _, time in gathered.times]))
    times = vehicle_times(stamps, known_at, clock)
    placed = [(float(times[n]), message) for n, message in gathered.messages if isinstance(message, Position)]
    rows = [(time, p.latitude_deg, p.longitude_deg, p.altitude, p.height, *p.velocity) for time, p in placed]
    fixes = Fixes.of(np.array(rows).reshape(-1, 8))
    events = tuple((float(times[n]), message) for n, message in gathered.messages if not isinstance(message, Position))
    remarks = () if len(clock) else (NO_CLOCK,)
    return Log(autopilot, fixes, events, gathered.version, remarks, _measured(gathered, times))


def _measured(gathered: _Gathered, times: Vector) -> Measured:
    batteries: dict[int, list[Battery]] = {}
    general: list[Battery] = []
    attitude = []
    for number, message in gathered.measured:
        match message:
            case Attitude(_, roll, pitch, yaw):
                attitude.append((float(times[number]), roll, pitch, yaw))
            case BatteryStatus(battery, voltage, current):
                batteries.setdefault(battery, []).append((float(times[number]), voltage, current))
            case _:
                general.append((float(times[number]), message.voltage, message.current))
    return Measured.of(batteries.values() or [general], attitude)
