"""The built-in autopilot: messages in, messages out, the time an argument; it answers and flies as PX4 or ArduPilot."""

import math
from collections.abc import Callable, Mapping, Sequence

from ipoa_mission.link import messages as m
from ipoa_mission.link.codec import EVERYONE, Target, message_name
from ipoa_mission.link.events import mission_event
from ipoa_mission.link.messages import CommandResult, Message, MissionType
from ipoa_mission.mission.items import Command, Item
from ipoa_mission.simulator import streams
from ipoa_mission.simulator.file_service import FileService
from ipoa_mission.simulator.flight import Flight, FlightMode, MissionState
from ipoa_mission.simulator.judgement import Infeasible, infeasibility
from ipoa_mission.simulator.parameters import ParameterTable
from ipoa_mission.simulator.personality import PERSONALITIES, Personality
from ipoa_mission.simulator.transfers import Transfers
from ipoa_mission.vehicle import Autopilot as Family
from ipoa_mission.vehicle import Parameters
from ipoa_mission.world.frame import Geodetic

QUADROTOR = 2  # MAV_TYPE
CRITICAL, INFO = 2, 6
ERROR_LEVELS = 0x63  # an event's: INFO for the log, ERROR for ground stations
STATE_BOOT, STATE_STANDBY, STATE_ACTIVE = 1, 3, 4
BASE_MODE = 1 | 8 | 16  # custom mode, guided, stabilised
FLYING_STEP_S = 0.02
SET_MODE, PAUSE_CONTINUE, SET_MISSION_CURRENT, MISSION_START, ARM_DISARM = 176, 193, 224, 300, 400
GET_HOME_POSITION, GET_MESSAGE_INTERVAL, SET_MESSAGE_INTERVAL = 410, 510, 511
REQUEST_MESSAGE, REQUEST_CAPABILITIES = 512, 520
#: MAV_PROTOCOL_CAPABILITY: mission and parameters as floats, MISSION_INT, COMMAND_INT, FTP, MAVLink 2, fence, rally.
CAPABILITIES = 1 | 2 | 4 | 8 | 32 | 8192 | 16384 | 32768


class Autopilot:
    """One simulated vehicle, without I/O."""

    def __init__(
        self,
        family: Family,
        home: Geodetic,
        parameters: Parameters | None = None,
        boot_s: float = 0.0,
        nak_at: int | None = None,
        seed: int = 0,
        wind: tuple[float, float] = (0.0, 0.0),
    ) -> None:
        """`seed` picks the errors of the sensors it flies by. The item of number `nak_at` is refused.

        Such a vehicle takes no mission as a file, in which no item can be refused.
        """
        self.habits: Personality = PERSONALITIES[family]
        self.table = ParameterTable(family, parameters or {})
        self.flight = Flight(family, home, self.table.values, wind, seed=seed)
        self.transfers = Transfers(self.habits, lambda: self.flight.home, self._say, self._listed, nak_at)
        limit = self.habits.limits[MissionType.MISSION]
        takes_file = self.habits.has_mission_file and nak_at is None
        self._files = FileService(takes_file, limit, self.transfers.listed, self.transfers.replace)
        self._boot_s = boot_s
        self._schedule = streams.Schedule()
        self._outbox: list[tuple[Message, Target]] = []
        self._now = 0.0
        self._told_reached = 0
        self._last_reached = m.Reached(0), 0  # and how often it is still to be said
        self._told_state: tuple[object, ...] = ()
        self._unflyable: Infeasible | None = None
        self._flown: tuple[Item, ...] = ()  # what the flight was given: without home, and only when it is complete
        self._idle_mode: int | None = None
        self._commands = _commands(self)

    # --- the outside ------------------------------------------------------------------------------------------------

    def receive(self, message: Message, source: Target, now: float) -> None:
        """Somebody has said something to this vehicle."""
        self.tick(now)
        if self.transfers.receive(message, source, now):
            self._tell_changes()
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
                self._command(number, (*params, x / 1e7, y / 1e7, z), source)
            case m.SetMode(_, custom_mode):
                self._set_mode(custom_mode)
            case m.SetCurrent(seq):
                self._go_to(seq)
            case m.Ping():
                self._say(message, source)
            case m.TimeSync(0, asked):
                self._say(m.TimeSync(round(now * 1e9) or 1, asked), source)
            case m.FileTransfer():
                self._say(self._files.answer(message, source), source)
        self._tell_changes()

    def tick(self, now: float) -> None:
        """Time has passed: fly on, ask again, stream."""
        self._now = max(self._now, now)
        self.transfers.booted = self._now >= self._boot_s
        self.flight.advance(self._now)
        self.transfers.tick(self._now)
        self._tell_changes()
        for name in self._schedule.due(self._now):
            self._say(self._stream(name), EVERYONE)

    def outgoing(self) -> list[tuple[Message, Target]]:
        """What is to be said, and to whom."""
        said, self._outbox = self._outbox, []
        return said

    @property
    def deadline(self) -> float:
        """When `tick` is next needed."""
        flying = self._now + FLYING_STEP_S if self.flight.armed else math.inf
        return min(flying, self._schedule.deadline, self.transfers.deadline)

    # --- what is said unasked ---------------------------------------------------------------------------------------

    def _say(self, message: Message, to: Target) -> None:
        self._outbox.append((message, to))

    def _text(self, severity: int, text: str) -> None:
        self._say(m.Text(severity, text), EVERYONE)

    def _stream(self, name: str) -> Message:
        match name:
            case "HEARTBEAT":
                return self._heartbeat()
            case "SYS_STATUS":
                return streams.status(self.transfers.booted and self._unflyable is None)
            case "MISSION_CURRENT":
                self._repeat_reached()
                return self._current()
            case _:
                return streams.FROM_FLIGHT[name](self.flight, self._now)

    def _repeat_reached(self) -> None:
        reached, times = self._last_reached
        if times > 0:
            self._last_reached = reached, times - 1
            self._say(reached, EVERYONE)

    def _heartbeat(self) -> m.Heartbeat:
        armed = m.ARMED_FLAG if self.flight.armed else 0
        state = STATE_BOOT if not self.transfers.booted else STATE_ACTIVE if self.flight.armed else STATE_STANDBY
        return m.Heartbeat(QUADROTOR, self.habits.mav_autopilot, BASE_MODE | armed, self._custom_mode(), state)

    def _custom_mode(self) -> int:
        if self.flight.mode is FlightMode.HOLD and self._idle_mode is not None:
            return self._idle_mode
        return self.habits.modes[self.flight.mode]

    def _current(self) -> m.Current:
        first = self._first
        total = max(len(self.transfers.stores[MissionType.MISSION].items) - first, 0)
        state = MissionState.NO_MISSION if self._unflyable else self.flight.mission_state
        index = 0 if self._has_rewound else self.flight.current
        return m.Current(index + first if total else 0, total, int(state))

    @property
    def _has_rewound(self) -> bool:
        return (
            self.habits.rewinds_after_landing
            and self.flight.mission_state is MissionState.COMPLETE
            and not self.flight.armed
            and self._flown[-1].command == Command.NAV_LAND
        )

    @property
    def _first(self) -> int:
        return 1 if self.habits.home_is_item_0 else 0

    def _tell_changes(self) -> None:
        """Say at once what ground stations wait for: an item reached, another current, another mode."""
        reached = self.flight.reached
        if len(reached) < self._told_reached:
            self._told_reached = 0
        fresh = reached[self._told_reached :]
        if fresh and self._now < fresh[-1].time_s + self.habits.reached_slot_s:
            fresh = fresh[:0]  # another may come and hide it
        self._told_reached += len(fresh)
        state = (self._custom_mode(), self.flight.armed)
        current = self._current()
        if not fresh and (state, current) == self._told_state:
            return
        self._say(streams.position(self.flight, self._now), EVERYONE)
        for n, one in enumerate(fresh):
            soon = one.time_s + self.habits.reached_slot_s
            if one.announced and not any(later.time_s < soon for later in fresh[n + 1 :]):
                self._last_reached = m.Reached(one.index + self._first), self.habits.reached_repeats
                self._say(self._last_reached[0], EVERYONE)
                if self.habits.home_is_item_0:
                    self._text(INFO, f"Reached command #{one.index + self._first}")
        was = self._told_state
        self._told_state = (state, current)
        if not was or was[1] != current:
            self._say(current, EVERYONE)
        if not was or was[0] != state:
            self._say(self._heartbeat(), EVERYONE)

    def _listed(self, kind: int) -> None:
        """A list has been replaced or cleared."""
        if kind != MissionType.MISSION:
            return
        items = self.transfers.listed(MissionType.MISSION)[self._first :]
        self._unflyable = None
        if self.habits.judges_after_ack and items:
            self._unflyable = infeasibility(items, self.flight.home, self.table.values)
        if self._unflyable:
            self._text(CRITICAL, f"{self._unflyable.words}\t")  # the tab: an event says the same
            number, arguments = mission_event(self._unflyable.event, *self._unflyable.values)
            self._say(m.Event(number, ERROR_LEVELS, arguments), EVERYONE)
        self._flown = () if self._unflyable else tuple(items)
        self.flight.load(self._flown)

    # --- orders -----------------------------------------------------------------------------------------------------

    def _command(self, number: int, params: tuple[float, ...], source: Target) -> None:
        act = self._commands.get(number)
        result = act(params) if act else CommandResult.UNSUPPORTED
        self._say(m.CommandAck(number, result), source)
        if number == REQUEST_MESSAGE and result == CommandResult.ACCEPTED:
            self._say(self._asked_for(int(params[0])), source)
        elif number == GET_HOME_POSITION and result == CommandResult.ACCEPTED:
            self._say(self._stream("HOME_POSITION"), EVERYONE)
        elif number == REQUEST_CAPABILITIES and result == CommandResult.ACCEPTED:
            self._say(self._asked_for(148), source)
        elif number == GET_MESSAGE_INTERVAL:
            interval = self._schedule.interval_us(_whole(params[0]))
            self._say(m.MessageInterval(_whole(params[0]) & 0xFFFF, interval), source)

    def _asked_for(self, number: int) -> Message:
        match message_name(number):
            case "AUTOPILOT_VERSION":
                bits = CAPABILITIES | (0x20000 if self.habits.home_is_item_0 else 16)
                return m.AutopilotVersion(bits, self.habits.version, uid=1)
            case str() as name:
                return self._stream(name)
        raise KeyError(number)

    def can_tell(self, number: float) -> bool:
        """Whether command 512 can have this message."""
        name = message_name(_whole(number))
        return name in {"AUTOPILOT_VERSION", *streams.INTERVALS_S, *streams.FROM_FLIGHT}

    def set_interval(self, number: float, interval_us: float) -> CommandResult:
        """Command 511."""
        known = self._schedule.set_interval(_whole(number), interval_us, self._now)
        return CommandResult.ACCEPTED if known else CommandResult.DENIED

    def arm(self, wish: float) -> CommandResult:
        """Command 400: let the motors run, or stop them."""
        if wish < 0.5:
            if not self.flight.landed:
                return CommandResult.DENIED
            self.flight.disarm()
            return CommandResult.ACCEPTED
        if not self.transfers.booted:
            self._text(CRITICAL, "Arm: Need Position Estimate")
            return CommandResult.FAILED
        if self._unflyable:
            self._text(CRITICAL, f"Arming denied: {self._unflyable.words}"[:50])
            return CommandResult.DENIED
        self.flight.arm()
        return CommandResult.ACCEPTED

    def begin_mission(self) -> CommandResult:
        """Command 300, or PX4's mission mode: fly the mission from where it stands."""
        if not self._flown:
            return CommandResult.DENIED
        if self.habits.missing_takeoff_text and self.flight.landed and not self._has_takeoff_first():
            self._text(CRITICAL, self.habits.missing_takeoff_text)
            return CommandResult.FAILED
        if self.flight.mode is not FlightMode.MISSION or self.flight.mission_state is not MissionState.ACTIVE:
            self.flight.start()
        return CommandResult.ACCEPTED

    def _has_takeoff_first(self) -> bool:
        """Whether the first command to come that moves the vehicle is a take-off; DO items may stand before it."""
        first = 0 if self.flight.mission_state is MissionState.COMPLETE else self.flight.current
        flown = (item.command for item in self._flown[first:] if item.command < 95)
        return next(flown, None) == Command.NAV_TAKEOFF

    def set_mode(self, params: Sequence[float]) -> CommandResult:
        """Command 176: main and sub mode for PX4, ArduPilot's one number."""
        main, sub = _whole(params[1]), _whole(params[2])
        return self._set_mode(main if self.habits.home_is_item_0 else (main & 0xFF) << 16 | (sub & 0xFF) << 24)

    def _set_mode(self, custom_mode: int) -> CommandResult:
        if not 0 <= custom_mode < 2**32:
            return CommandResult.DENIED
        modes = {number: mode for mode, number in self.habits.modes.items()}
        mode = modes.get(custom_mode)
        if mode is FlightMode.MISSION:
            return self.begin_mission()
        if mode is FlightMode.RETURN:
            self.flight.return_home()
        elif mode is FlightMode.LAND:
            self.flight.land()
        else:
            self._idle_mode = None if mode is FlightMode.HOLD else custom_mode
            self.flight.hold()
        return CommandResult.ACCEPTED

    def _go_to(self, seq: int) -> bool:
        index = seq - self._first
        if not 0 <= index < len(self._flown):
            return False
        self.flight.set_current(index)
        self._say(self._current(), EVERYONE)
        return True

    def jump_to(self, seq: float) -> CommandResult:
        """Command 224."""
        if not self.habits.knows_command_224:
            return CommandResult.UNSUPPORTED
        return CommandResult.ACCEPTED if self._go_to(_whole(seq)) else CommandResult.DENIED

    def obey(self, mode: FlightMode) -> CommandResult:
        """Return, land or hold, as a command of its own."""
        return self._set_mode(self.habits.modes[mode])


def _commands(autopilot: Autopilot) -> Mapping[int, Callable[[Sequence[float]], CommandResult]]:
    """What each MAV_CMD does; any other gets UNSUPPORTED."""
    accepted, denied = CommandResult.ACCEPTED, CommandResult.DENIED
    return {
        Command.NAV_RETURN_TO_LAUNCH: lambda p: autopilot.obey(FlightMode.RETURN),
        Command.NAV_LAND: lambda p: autopilot.obey(FlightMode.LAND),
        SET_MODE: autopilot.set_mode,
        PAUSE_CONTINUE: lambda p: autopilot.begin_mission() if p[0] >= 0.5 else autopilot.obey(FlightMode.HOLD),
        SET_MISSION_CURRENT: lambda p: autopilot.jump_to(p[0]),
        MISSION_START: lambda p: autopilot.begin_mission(),
        ARM_DISARM: lambda p: autopilot.arm(p[0]),
        GET_HOME_POSITION: lambda p: accepted,
        GET_MESSAGE_INTERVAL: lambda p: accepted,
        SET_MESSAGE_INTERVAL: lambda p: autopilot.set_interval(p[0], p[1]),
        REQUEST_MESSAGE: lambda p: accepted if autopilot.can_tell(p[0]) else denied,
        REQUEST_CAPABILITIES: lambda p: accepted,
    }


def _whole(value: float) -> int:
    return int(value) if math.isfinite(value) and abs(value) < 2**31 else -1
