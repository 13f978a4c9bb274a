import math
from collections.abc import Callable, Mapping, Sequence

from ipoa_mission.autopilot.autopilot import Autopilot
from ipoa_mission.autopilot.commands import Command, Frame, VehicleCommand
from ipoa_mission.autopilot.parameters import REAL32, Parameters
from ipoa_mission.autopilot.version import Version
from ipoa_mission.link import messages as m
from ipoa_mission.link import telemetry
from ipoa_mission.link.codec import EVERYONE, Target
from ipoa_mission.link.definitions import message_name
from ipoa_mission.link.events import mission_event
from ipoa_mission.link.messages import (
    CRITICAL,
    CommandResult,
    Message,
    MissionType,
    ParamRequestList,
    ParamRequestRead,
    ParamSet,
    ParamValue,
)
from ipoa_mission.link.orders import parameter_value, spelled_parameter
from ipoa_mission.link.wire import degrees
from ipoa_mission.simulator import streams
from ipoa_mission.simulator.commander import ACCEPTED, UNSUPPORTED, Commander, whole
from ipoa_mission.simulator.conditions import USUAL, Conditions
from ipoa_mission.simulator.file_service import FileService
from ipoa_mission.simulator.judgement import infeasibility
from ipoa_mission.simulator.mission_service import MissionService
from ipoa_mission.simulator.mock_profile import mock_profile
from ipoa_mission.simulator.simulated_flight import FlightMode, SimulatedFlight
from ipoa_mission.world.frame import Geodetic

ERROR_LEVELS = 0x63  # of an event
FLYING_STEP_S = 0.02
AUTOPILOT_VERSION, HOME_POSITION, PROTOCOL_VERSION = 148, 242, 300
#: For each command older than REQUEST_MESSAGE.
OLD_REQUESTS: Mapping[int, int] = {
    VehicleCommand.GET_HOME_POSITION: HOME_POSITION,
    VehicleCommand.REQUEST_PROTOCOL_VERSION: PROTOCOL_VERSION,
    VehicleCommand.REQUEST_AUTOPILOT_CAPABILITIES: AUTOPILOT_VERSION,
}


class BuiltInAutopilot(Commander):
    """Simulate one vehicle, without I/O; the time is an argument."""

    def __init__(
        self,
        family: Autopilot,
        home: Geodetic,
        parameters: Parameters | None = None,
        cold: bool = False,
        nak_at: int | None = None,
        seed: int = 0,
        conditions: Conditions = USUAL,
    ) -> None:
        """Create a vehicle on the ground at `home`.

        Args:
            family: the autopilot that it imitates.
            parameters: replace the autopilot's defaults.
            cold: powered up now, without a position at first.
            nak_at: number of an item that it refuses; it takes no mission as a file.
            seed: of the sensors' errors.
        """
        profile = mock_profile(family, conditions.version)
        self.table = ParameterServer(family, parameters or {}, conditions.version)
        flight = SimulatedFlight(family, home, self.table.values, conditions, seed=seed)
        transfers = MissionService(profile, lambda: flight.home, self._say, self._listed, nak_at)
        super().__init__(profile, flight, transfers, self.table.values, 0.0 if cold else -math.inf)
        takes_file = profile.autopilot.protocol_profile.takes_mission_file and nak_at is None
        limit = profile.limits[MissionType.MISSION]
        self._files = FileService(takes_file, limit, transfers.listed, transfers.replace)
        self._schedule = streams.Schedule(profile.streams, profile.fixed_streams)
        self._commands = _commands(self)

    def receive(self, message: Message, source: Target, now: float) -> None:
        self.tick(now)
        self._schedule.hear(source)
        if self.transfers.receive(message, source, now):
            self._report_changes()
            return
        values = self.table.answers(message)
        if values is not None:
            for value in values:
                self._say(value, EVERYONE)
            return
        match message:
            case m.CommandLong(number, params):
                self._command(number, params, source)
            case m.CommandInt(number, _, params, x, y, z):
                self._command(number, (*params, degrees(x, Frame.GLOBAL), degrees(y, Frame.GLOBAL), z), source)
            case m.SetMode(_, custom_mode):
                self._set_mode(custom_mode)
            case m.SetCurrent(seq):
                if not self._go_to(seq) and self.profile.no_item_text:
                    self._text(CRITICAL, self.profile.no_item_text)
            case m.RequestDataStream(group, rate, start) if start in (0, 1):
                self._schedule.set_rate(self._group(group), rate if start else 0, now, source)
            case m.Ping():
                self._say(message, source)
            case m.TimeSync(0, asked):
                self._say(m.TimeSync(round(now * 1e9) or 1, asked), source)
            case m.FileTransfer():
                for answer in self._files.answers(message, source):
                    self._say(answer, source)
        self._report_changes()

    def transfers_with(self, client: Target) -> bool:
        return self.transfers.is_under_way(client) or self._files.is_open(client)

    def tick(self, now: float) -> None:
        self._now = max(self._now, now)
        self.transfers.booted = self._age >= self.profile.start_up.listens_s
        self.flight.advance(self._now)
        self._notice_disarming()
        self._notice_height()
        self.transfers.tick(self._now)
        self._report_changes()
        for name in self._schedule.due(self._now):
            if (message := self._stream(name)) is not None:
                self._say(message, EVERYONE)

    def outgoing(self) -> list[tuple[Message, Target]]:
        """Return and forget the messages to send."""
        messages, self._outbox = self._outbox, []
        return messages

    @property
    def deadline(self) -> float:
        flying = self._now + FLYING_STEP_S if self.flight.armed else math.inf
        return min(flying, self._schedule.deadline, self.transfers.deadline)

    @property
    def awaits_somebody(self) -> bool:
        """Return whether it waits for a client: in a transfer, or armed before take-off."""
        return self.transfers.deadline < math.inf or self._will_stop_motors

    def _listed(self, kind: int) -> None:
        if kind == MissionType.RALLY:
            self.flight.know_rally(tuple(self.transfers.listed(MissionType.RALLY)))
        if kind != MissionType.MISSION:
            return
        items = self.transfers.listed(MissionType.MISSION)[self._first :]
        self._unflyable = None
        if self.profile.autopilot.protocol_profile.judges_later and items:
            self._unflyable = infeasibility(self.profile.firmware, items, self.flight.home, self.table.values)
        if self._unflyable:
            self._text(CRITICAL, f"{self._unflyable.words}\t")  # an event says the same
            number, arguments = mission_event(self._unflyable.event, *self._unflyable.values)
            self._say(m.Event(number, ERROR_LEVELS, arguments), EVERYONE)
        self._flown = () if self._unflyable else tuple(items)
        self.flight.load(self._flown)
        if not items:
            self._has_begun = self._runs = False

    def _command(self, number: int, params: tuple[float, ...], source: Target) -> None:
        held, self._outbox = self._outbox, []
        act = self._commands.get(number)
        result = act(params) if act else UNSUPPORTED
        words, self._outbox = self._outbox, held
        number_asked = whole(params[0]) if number == VehicleCommand.REQUEST_MESSAGE else OLD_REQUESTS.get(number)
        answers: list[Message] = []
        if result == ACCEPTED and number_asked is not None and (answer := self._asked_for(number_asked)) is not None:
            answers = [answer]
        acks: list[Message] = [m.CommandAck(number, result)]
        if number == VehicleCommand.SET_MESSAGE_INTERVAL:
            accepted = self._schedule.set_interval(whole(params[0]), params[1], self._now, source)
            acks = [m.CommandAck(number, ACCEPTED if accepted else self.profile.no_such_stream)]
        elif number == VehicleCommand.GET_MESSAGE_INTERVAL:
            interval = self._schedule.interval_us(whole(params[0]), source)
            reported_us, heard = self.profile.no_such_interval if interval is None else (interval, int(ACCEPTED))
            self._say(m.MessageInterval(whole(params[0]) & 0xFFFF, reported_us), source)
            acks = [m.CommandAck(number, heard)]
        elif number == VehicleCommand.DO_SET_MODE and self.profile.mode_acks > 1:
            acks = [m.CommandAck(number, ACCEPTED), *acks]
        for message in (*acks, *answers) if self.profile.acks_first else (*answers, *acks):
            self._say(message, source)
        self._outbox += words

    def _group(self, number: int) -> frozenset[str]:
        """0 is all."""
        groups = self.profile.stream_groups
        return frozenset[str]().union(*groups.values()) if number == 0 else groups.get(number, frozenset())

    def _asked_for(self, number: int) -> Message | None:
        if number == PROTOCOL_VERSION and self.profile.protocol is not None:
            return telemetry.ProtocolVersion(*self.profile.protocol)
        if number == AUTOPILOT_VERSION:
            return telemetry.AutopilotVersion(self.profile.capabilities, self.profile.version.number, uid=1)
        return self._stream(message_name(number) or "")

    def request_message(self, number: float) -> CommandResult:
        name = message_name(whole(number))
        is_known = name == "AUTOPILOT_VERSION" or name in streams.KNOWN_MESSAGES
        is_known = is_known or (name == "PROTOCOL_VERSION" and self.profile.protocol is not None)
        return ACCEPTED if is_known else CommandResult(self.profile.no_such_message)


def _commands(autopilot: BuiltInAutopilot) -> Mapping[int, Callable[[Sequence[float]], CommandResult]]:
    return {
        Command.NAV_RETURN_TO_LAUNCH: lambda p: autopilot.obey(FlightMode.RETURN),
        Command.NAV_LAND: lambda p: autopilot.obey(FlightMode.LAND),
        Command.NAV_TAKEOFF: lambda p: autopilot.climb(p[6]),
        VehicleCommand.DO_SET_MODE: autopilot.set_mode,
        Command.DO_PAUSE_CONTINUE: lambda p: autopilot.pause(p[0]),
        VehicleCommand.DO_REPOSITION: autopilot.reposition,
        Command.DO_FENCE_ENABLE: lambda p: ACCEPTED if autopilot.profile.switches_fence else UNSUPPORTED,
        VehicleCommand.DO_SET_MISSION_CURRENT: autopilot.jump_to,
        VehicleCommand.PREFLIGHT_REBOOT_SHUTDOWN: lambda p: autopilot.reboot(p[0]),
        VehicleCommand.MISSION_START: autopilot.start_mission,
        Command.COMPONENT_ARM_DISARM: lambda p: autopilot.arm(p[0]),
        VehicleCommand.RUN_PREARM_CHECKS: lambda p: autopilot.check(),
        VehicleCommand.GET_HOME_POSITION: lambda p: ACCEPTED,
        VehicleCommand.GET_MESSAGE_INTERVAL: lambda p: ACCEPTED,
        VehicleCommand.SET_MESSAGE_INTERVAL: lambda p: ACCEPTED,
        VehicleCommand.REQUEST_MESSAGE: lambda p: autopilot.request_message(p[0]),
        VehicleCommand.REQUEST_PROTOCOL_VERSION: lambda p: (
            UNSUPPORTED if autopilot.profile.protocol is None else ACCEPTED
        ),
        VehicleCommand.REQUEST_AUTOPILOT_CAPABILITIES: lambda p: ACCEPTED,
    }


#: ArduPilot's PARAM_VALUE.param_index of a named request.
BY_NAME = 65535


class ParameterServer:
    def __init__(self, autopilot: Autopilot, given: Mapping[str, float], version: Version | None = None) -> None:
        self._autopilot = autopilot
        set_up = autopilot.parameter_table.set_up
        self._types = {**autopilot.parameter_table.types, **{name: kind for name, (_, kind) in set_up.items()}}
        declared = {name: value for name, (value, _) in set_up.items()}
        own = {**autopilot.parameter_table.moving, **autopilot.defaults_of(version)}
        self.values = {**declared, **own, **autopilot.parameter_table.others, **given}

    def answers(self, message: Message) -> list[ParamValue] | None:
        names = sorted(self.values)
        match message:
            case ParamRequestList():
                return [self._value(name, index, len(names)) for index, name in enumerate(names)]
            case ParamRequestRead(_, index) if 0 <= index < len(names):
                return [self._value(names[index], index, len(names))]
            case ParamRequestRead(name, -1):
                return self._named(name, names)
            case ParamSet(name, value, kind):
                self._set(name, value, kind)
                return self._named(name, names)
            case ParamRequestRead():
                return []
        return None

    def _set(self, name: str, value: float, kind: int) -> None:
        """Convert or ignore another type."""
        own = self._types.get(name, REAL32)
        if name not in self.values or (self._autopilot.protocol_profile.keeps_types and kind != own):
            return
        number = parameter_value(ParamValue(name, value, own, 0, 0), self._autopilot)
        if math.isfinite(number):
            self.values[name] = number if own == REAL32 else float(round(number))

    def _named(self, name: str, names: list[str]) -> list[ParamValue]:
        if name not in self.values:
            return []
        index = BY_NAME if self._autopilot.protocol_profile.parameters_by_name else names.index(name)
        return [self._value(name, index, len(names))]

    def _value(self, name: str, index: int, count: int) -> ParamValue:
        kind = self._types.get(name, REAL32)
        return ParamValue(name, spelled_parameter(self.values[name], kind, self._autopilot), kind, count, index)
