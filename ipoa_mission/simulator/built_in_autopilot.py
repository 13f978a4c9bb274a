import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

from ipoa_mission.autopilot.autopilot import Autopilot
from ipoa_mission.autopilot.commands import Frame, VehicleCommand
from ipoa_mission.autopilot.parameters import REAL32, Parameters, defaults
from ipoa_mission.autopilot.version import Version
from ipoa_mission.errors import MissionError
from ipoa_mission.geodesy import Geodetic
from ipoa_mission.link import mavftp
from ipoa_mission.link import messages as m
from ipoa_mission.link.codec import Target
from ipoa_mission.link.definitions import message_name
from ipoa_mission.link.mavftp import LONGEST_DATA, FileError, FileMessage, Opcode, nak
from ipoa_mission.link.orders import parameter_value, spelled_parameter
from ipoa_mission.link.wire import ITEM, degrees
from ipoa_mission.mission.items import Item
from ipoa_mission.simulator.commander import Commander, as_integer
from ipoa_mission.simulator.mock_profile import mock_profile
from ipoa_mission.simulator.mock_vehicle import Schedule
from ipoa_mission.simulator.simulated_flight import SimulatedFlight
from ipoa_mission.simulator.situation import STANDARD_CONDITIONS, STEP_S, Conditions

#: The message that each command older than REQUEST_MESSAGE requests.
OLD_REQUESTS: Mapping[int, str] = {
    VehicleCommand.GET_HOME_POSITION: "HOME_POSITION",
    VehicleCommand.REQUEST_PROTOCOL_VERSION: "PROTOCOL_VERSION",
    VehicleCommand.REQUEST_AUTOPILOT_CAPABILITIES: "AUTOPILOT_VERSION",
}
#: ArduPilot's PARAM_VALUE.param_index of a named request.
BY_NAME = 65535


class BuiltInAutopilot:
    """One simulated vehicle, without I/O; the time is an argument."""

    def __init__(
        self,
        family: Autopilot,
        home: Geodetic,
        parameters: Parameters | None = None,
        conditions: Conditions = STANDARD_CONDITIONS,
    ) -> None:
        self.profile = profile = mock_profile(family, conditions.version)
        self.table = ParameterServer(family, parameters or {}, conditions.version)
        self.flight = SimulatedFlight(family, home, self.table.values, conditions)
        powered_s = 0.0 if conditions.cold else -math.inf
        self.vehicle = Commander(profile, self.flight, self.table.values, powered_s)
        self.transfers = transfers = self.vehicle.transfers
        takes_file = profile.autopilot.protocol_profile.takes_mission_file
        limit = profile.limits[m.MissionType.MISSION]
        self._files = FileService(takes_file, limit, transfers.listed, transfers.replace)
        self._schedule = Schedule(profile.streams, profile.fixed_streams)

    def receive(self, message: m.Message, source: Target, now: float) -> None:
        self.tick(now)
        if not self.transfers.receive(message, source, now):
            self._answer(message, source, now)
        self.vehicle.report_changes()

    def _answer(self, message: m.Message, source: Target, now: float) -> None:
        send = self.vehicle.send
        match message:
            case m.CommandLong(number, params):
                self._command(number, params, source)
            case m.CommandInt(number, _, params, x, y, z):
                self._command(number, (*params, degrees(x, Frame.GLOBAL), degrees(y, Frame.GLOBAL), z), source)
            case m.SetMode(_, custom_mode):
                self.vehicle.set_mode(custom_mode)
            case m.SetCurrent(seq):
                if not self.vehicle.set_current(seq) and self.profile.no_item_text:
                    self.vehicle.send_text(m.CRITICAL, self.profile.no_item_text)
            case m.RequestDataStream(group, rate, start) if start in (0, 1):
                groups = self.profile.stream_groups
                names = groups.get(group, frozenset()) if group else frozenset[str]().union(*groups.values())  # 0: all
                self._schedule.set_rate(names, rate if start else 0, now)
            case m.Ping():
                send(message, source)
            case m.TimeSync(0, asked):
                send(m.TimeSync(round(now * 1e9) or 1, asked), source)
            case m.FileTransfer():
                send(self._files.answer(message, source), source)
            case m.ParamRequestList() | m.ParamRequestRead() | m.ParamSet():
                for value in self.table.answers(message):
                    send(value)

    def tick(self, now: float) -> None:
        vehicle = self.vehicle
        vehicle.now = max(vehicle.now, now)
        self.transfers.booted = vehicle.age >= self.profile.start_up.listens_s
        self.flight.advance(vehicle.now)
        vehicle.notice_disarming()
        self.transfers.tick(vehicle.now)
        vehicle.report_changes()
        for name in self._schedule.due(vehicle.now):
            message = vehicle.message(name)
            if message is not None:
                vehicle.send(message)

    def outgoing(self) -> list[tuple[m.Message, Target]]:
        messages = self.vehicle.outbox
        self.vehicle.outbox = []
        return messages

    @property
    def deadline(self) -> float:
        flying = self.vehicle.now + STEP_S if self.flight.armed else math.inf
        return min(flying, self._schedule.deadline, self.transfers.deadline)

    @property
    def awaits_somebody(self) -> bool:
        """Return whether it waits for a client: in a transfer, or armed before take-off."""
        return self.transfers.deadline < math.inf or self.vehicle.will_stop_motors

    def _command(self, number: int, params: tuple[float, ...], source: Target) -> None:
        vehicle = self.vehicle
        profile = self.profile
        before = len(vehicle.outbox)
        result = vehicle.execute(number, params)
        caused = vehicle.outbox[before:]
        del vehicle.outbox[before:]
        asked = as_integer(params[0])
        requested = message_name(asked) if number == VehicleCommand.REQUEST_MESSAGE else OLD_REQUESTS.get(number)
        answer = vehicle.message(requested) if result == m.CommandResult.ACCEPTED and requested else None
        answers: list[m.Message] = [] if answer is None else [answer]
        sets_interval = number == VehicleCommand.SET_MESSAGE_INTERVAL
        if sets_interval and not self._schedule.set_interval(asked, params[1], vehicle.now):
            result = profile.no_such_stream
        acks: list[m.Message] = [m.CommandAck(number, result)]
        if number == VehicleCommand.DO_SET_MODE and profile.mode_acks > 1:
            acks.insert(0, m.CommandAck(number, m.CommandResult.ACCEPTED))
        for message in (*acks, *answers) if profile.acks_first else (*answers, *acks):
            vehicle.send(message, source)
        vehicle.outbox += caused


class ParameterServer:
    def __init__(self, autopilot: Autopilot, overrides: Mapping[str, float], version: Version | None = None) -> None:
        self._autopilot = autopilot
        table = autopilot.parameter_table
        self._types = table.kinds
        own = {**table.moving, **autopilot.defaults_of(version)}
        self.values = {**defaults(table.set_up), **own, **table.others, **overrides}

    def answers(self, message: m.ParamRequestList | m.ParamRequestRead | m.ParamSet) -> list[m.ParamValue]:
        names = sorted(self.values)
        match message:
            case m.ParamRequestList():
                return [self._value(name, index) for index, name in enumerate(names)]
            case m.ParamRequestRead(_, index) if 0 <= index < len(names):
                return [self._value(names[index], index)]
            case m.ParamSet(name, value, kind):
                self._set(name, value, kind)
            case m.ParamRequestRead(name, index) if index != -1:
                return []
        if name not in self.values:
            return []
        by_name = self._autopilot.protocol_profile.parameters_by_name
        return [self._value(name, BY_NAME if by_name else names.index(name))]

    def _set(self, name: str, value: float, kind: int) -> None:
        declared = self._types.get(name, REAL32)
        if name not in self.values or (self._autopilot.protocol_profile.keeps_types and kind != declared):
            return
        number = parameter_value(m.ParamValue(name, value, declared, 0, 0), self._autopilot)
        if math.isfinite(number):
            self.values[name] = number if declared == REAL32 else float(round(number))

    def _value(self, name: str, index: int) -> m.ParamValue:
        kind = self._types.get(name, REAL32)
        spelled = spelled_parameter(self.values[name], kind, self._autopilot)
        return m.ParamValue(name, spelled, kind, len(self.values), index)


@dataclass
class FileSession:
    """A repeated request gets the last answer again."""

    reading: bytes | None = None
    writing: bytearray | None = None
    last: FileMessage | None = None


@dataclass
class FileService:
    """`replace` returns False if it refuses a mission."""

    is_offered: bool
    most_items: int
    listed: Callable[[int], tuple[Item, ...]]
    replace: Callable[[tuple[Item, ...]], bool]
    _sessions: dict[Target, FileSession] = field(default_factory=dict)

    def answer(self, message: m.FileTransfer, client: Target) -> m.FileTransfer:
        question = mavftp.unpack(message)
        session = self._sessions.setdefault(client, FileSession())
        last = session.last
        if last is None or last.sequence != (question.sequence + 1) & 0xFFFF or last.request != question.opcode:
            last = self._act(question, session)
            session.last = last
        return last.pack()

    def _act(self, question: FileMessage, session: FileSession) -> FileMessage:
        match question.opcode:
            case Opcode.RESET_SESSIONS:
                session.reading = session.writing = None
                return _ack(question)
            case Opcode.OPEN_FILE_RO | Opcode.CREATE_FILE:
                return self._open(question, session)
            case Opcode.CALC_FILE_CRC32:
                return self._sum_up(question)
            case Opcode.READ_FILE if session.reading is not None:
                size = min(question.size or LONGEST_DATA, LONGEST_DATA)
                piece = session.reading[question.offset : question.offset + size]
                return _ack(question, piece) if piece else nak(question, FileError.END_OF_FILE)
            case Opcode.WRITE_FILE if session.writing is not None:
                end = question.offset + len(question.data)
                longest = mavftp.LIST_HEADER.size + self.most_items * ITEM.layout.size
                if question.offset > len(session.writing) or end > longest:
                    return nak(question, FileError.FAIL)
                session.writing[question.offset : end] = question.data
                return _ack(question)
            case Opcode.TERMINATE_SESSION:
                return self._close(question, session)
            case Opcode.READ_FILE | Opcode.WRITE_FILE:
                return nak(question, FileError.INVALID_SESSION)
        return nak(question, FileError.UNKNOWN_COMMAND)

    def _open(self, question: FileMessage, session: FileSession) -> FileMessage:
        if not self.is_offered or question.data.rstrip(b"\0") != mavftp.MISSION_FILE.encode():
            return nak(question, FileError.FILE_NOT_FOUND)
        if question.opcode == Opcode.CREATE_FILE:
            session.reading = None
            session.writing = bytearray()
            return _ack(question)
        session.reading = mavftp.pack_mission(self.listed(m.MissionType.MISSION))
        session.writing = None
        return _ack(question, len(session.reading).to_bytes(4, "little"))

    def _sum_up(self, question: FileMessage) -> FileMessage:
        name = question.data.rstrip(b"\0")
        kind = next((kind for kind, path in mavftp.LIST_FILES.items() if path.encode() == name), None)
        if not self.is_offered or kind is None:
            return nak(question, FileError.FAIL)
        return _ack(question, mavftp.file_checksum(mavftp.pack_mission(self.listed(kind), kind)).to_bytes(4, "little"))

    def _close(self, question: FileMessage, session: FileSession) -> FileMessage:
        written = session.writing
        session.reading = session.writing = None
        if written is None:
            return _ack(question)
        try:
            taken = self.replace(mavftp.unpack_mission(bytes(written)))
        except MissionError:
            taken = False
        return _ack(question) if taken else nak(question, FileError.FAIL)


def _ack(question: FileMessage, data: bytes = b"") -> FileMessage:
    sequence = (question.sequence + 1) & 0xFFFF
    return FileMessage(sequence, Opcode.ACK, question.session, question.opcode, question.offset, data)
