"""Ground station's log (`.tlog`): messages from and to one vehicle.

Heartbeats come once a second. The first report since the last one in the old state times an arming.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from ipoa_mission.autopilot.autopilot import Autopilot, VehicleKind, with_article
from ipoa_mission.autopilot.commands import Command
from ipoa_mission.errors import BadInput, MissionError, NothingThere
from ipoa_mission.geometry import Vector
from ipoa_mission.link import messages as m
from ipoa_mission.link.codec import Codec, Heard, LongTexts, LostFrames, read_tlog
from ipoa_mission.link.mavftp import MISSION_FILE, Opcode, unpack, unpack_mission
from ipoa_mission.link.orders import parameter_value
from ipoa_mission.logs.logged import Battery, Held, Log, Measured, in_order, item_begun, presence, version_name
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
            self._onboard = complete
            self._list = None
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


def vehicle_time(message: m.Message) -> float | None:
    """Return the time since boot [s], if any."""
    match message:
        case m.Position() | m.Attitude() | m.LocalPosition():
            return message.time_s
        case m.SystemTime():
            return message.boot_s
        case m.TimeSync(0, nanoseconds) if 0 < nanoseconds < 1e17:  # a greater one is no boot time
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
    first = clock_at[0]
    last = clock_at[-1]
    begins = clock[0] + (stamps - first) * _pace(clock_at, clock, slice(None))
    ends = clock[-1] + (stamps - last) * _pace(clock_at, clock, slice(None, None, -1))
    return np.where(stamps < first, begins, np.where(stamps > last, ends, np.interp(stamps, clock_at, clock)))


def _pace(clock_at: Vector, clock: Vector, order: slice) -> float:
    at = clock_at[order]
    times = clock[order]
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


def read_telemetry_log(path: Path, system: int | None = None) -> Log:
    """Return positions and events of system `system`, by default of the first multicopter."""
    missing = LostFrames()
    stamps = list[float]()
    kinds = dict[int, VehicleKind]()
    reader: _Reader | None = None
    for unix_s, heard in _heard_in(path, missing):
        if heard.message is None:
            continue
        beat = heard.message if heard.component == m.AUTOPILOT_COMPONENT else None
        kind = beat.vehicle if isinstance(beat, m.Heartbeat) else None
        if kind is not None and heard.system not in kinds:
            kinds[heard.system] = kind
            if reader is None and _is_flown(kind) and system in (None, heard.system):
                reader = _Reader(heard.system, kind.autopilot)
        if reader is None:
            continue
        number = len(stamps)
        stamps.append(unix_s)
        if (heard.system, heard.component) == (reader.system, m.AUTOPILOT_COMPONENT):
            reader.note_vehicle(number, heard.message)
        elif heard.target.system in (0, reader.system):
            reader.note_station(number, heard.message)
    if reader is None:
        raise _not_in(path, kinds, system)
    log = reader.log(growing(stamps))
    return replace(log, remarks=(*_others(kinds, reader.system), *missing.remarks(reader.system), *log.remarks))


def _heard_in(path: Path, missing: LostFrames) -> Iterator[tuple[float, Heard]]:
    codec = Codec(m.STATION_SYSTEM, m.STATION_COMPONENT)
    texts = LongTexts()
    for record in read_tlog(path, missing):
        heard = codec.decode(record.frame)
        yield from ((record.unix_s, each) for each in texts.joined([heard] if heard else [], record.unix_s))


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


@dataclass
class _Reader:
    """Messages of one vehicle, and those to it, by number in the log."""

    system: int
    autopilot: Autopilot
    transfers: Transfers = field(default_factory=Transfers)
    messages: list[tuple[int, m.Message]] = field(default_factory=list)
    times: list[tuple[int, float]] = field(default_factory=list)
    state: m.Heartbeat | None = None
    ordered: bool | None = None
    changes: list[tuple[int, bool]] = field(default_factory=list)  # of arming, since the last heartbeat
    unconfirmed: bool = False  # heartbeat still in the old state
    version: str = ""
    measured: list[tuple[int, m.Attitude | m.BatteryStatus | m.SystemStatus]] = field(default_factory=list)

    def note_station(self, number: int, message: m.Message) -> None:
        match message:
            case m.CommandLong(Command.COMPONENT_ARM_DISARM, params) | m.CommandInt(
                Command.COMPONENT_ARM_DISARM, _, params
            ):
                self.ordered = params[0] >= 0.5
        self._note_transfer(number, message, by_vehicle=False)

    def note_vehicle(self, number: int, message: m.Message) -> None:
        time_s = vehicle_time(message)
        if time_s is not None:
            self.times.append((number, time_s))
        match message:
            case m.Heartbeat():
                self._beat(number, message)
            case m.CommandAck(Command.COMPONENT_ARM_DISARM, m.CommandResult.ACCEPTED):
                self._note_arming(number, not self._is_armed if self.ordered is None else self.ordered)
            case m.Text(_, text):
                arms = text.startswith(("Arming motors", "Armed by", "ARMED by"))
                disarms = text.startswith(("Disarming motors", "Disarmed by", "DISARMED by"))
                if (arms or disarms) and not self.changes:  # else an echo
                    self._note_arming(number, arms)
                if self.autopilot.protocol_profile.tells_items and (begun := item_begun(text)):
                    self.messages.append((number, begun))
            case m.AutopilotVersion(_, version):
                self.version = version_name(version)
            case m.Attitude() | m.BatteryStatus() | m.SystemStatus():
                self.measured.append((number, message))
            case m.ParamValue():
                message = replace(message, param_value=parameter_value(message, self.autopilot))
        if isinstance(message, m.Position | m.Reached | m.Current | m.HomePosition | m.ParamValue | m.Text):
            self.messages.append((number, message))
        self._note_transfer(number, message, by_vehicle=True)

    def _note_transfer(self, number: int, message: m.Message, by_vehicle: bool) -> None:
        items = self.transfers.note(message, by_vehicle)
        if items is not None:
            self.messages.append((number, Held(items)))

    @property
    def _is_armed(self) -> bool:
        return self.changes[-1][1] if self.changes else self.state is not None and self.state.armed

    def _note_arming(self, number: int, armed: bool) -> None:
        if armed != self._is_armed:
            self.changes.append((number, armed))
            self.unconfirmed = False

    def _beat(self, number: int, beat: m.Heartbeat) -> None:
        before = self.state
        if before and self.changes and self.changes[-1][1] == beat.armed:
            self._change(before.custom_mode)
        elif self.unconfirmed:
            self.changes.clear()
        self.state = beat
        self.unconfirmed = bool(self.changes)
        if before is None or (before.armed, before.custom_mode) != (beat.armed, beat.custom_mode):
            self.messages.append((number, presence(self.autopilot, beat.armed, beat.custom_mode)))

    def _change(self, mode: int) -> None:
        self.messages += [(number, presence(self.autopilot, armed, mode)) for number, armed in self.changes]
        self.changes.clear()

    def log(self, stamps: Vector) -> Log:
        if self.state and self.changes and not self.changes[-1][1]:
            self._change(self.state.custom_mode)
        known_at = stamps[[number for number, _ in self.times]] if self.times else np.empty(0)
        clock = unwrapped(known_at, np.array([time for _, time in self.times]))
        times = vehicle_times(stamps, known_at, clock).tolist()
        dated = [(times[n], message) for n, message in self.messages]
        places = [(time, message) for time, message in dated if isinstance(message, m.Position)]
        rows = [(time, p.latitude_deg, p.longitude_deg, p.altitude, p.height, *p.velocity) for time, p in places]
        events = tuple((time, message) for time, message in dated if not isinstance(message, m.Position))
        measured = _measured([(times[n], message) for n, message in self.measured])
        no_clock = "the log has no clock of the vehicle: its times are those of the ground station"
        remarks = () if len(clock) else (no_clock,)
        return Log(self.autopilot, in_order(np.array(rows).reshape(-1, 8)), events, self.version, remarks, measured)


def _measured(dated: list[tuple[float, m.Attitude | m.BatteryStatus | m.SystemStatus]]) -> Measured:
    """SYS_STATUS counts where no battery has a status of its own."""
    batteries: dict[int, list[Battery]] = {}
    general: list[Battery] = []
    attitude = []
    for time, message in dated:
        match message:
            case m.Attitude(_, roll, pitch, yaw):
                attitude.append((time, roll, pitch, yaw))
            case m.BatteryStatus(battery, voltage, current):
                batteries.setdefault(battery, []).append((time, voltage, current))
            case _:
                general.append((time, message.voltage, message.current))
    return Measured.of(batteries.values() or [general], attitude)
