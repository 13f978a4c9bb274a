"""The built-in autopilot: messages in, messages out, the time an argument; it answers and flies as PX4 or ArduPilot."""

import math
from collections.abc import Callable, Mapping, Sequence

from ipoa_mission.autopilots.modes import knows_mode, mode_name
from ipoa_mission.autopilots.vehicle import Autopilot as Family
from ipoa_mission.autopilots.vehicle import Parameters
from ipoa_mission.commands import Command, Frame
from ipoa_mission.items import Item
from ipoa_mission.link import messages as m
from ipoa_mission.link.codec import EVERYONE, Target, message_name
from ipoa_mission.link.events import mission_event
from ipoa_mission.link.logbook import LAST_NAV
from ipoa_mission.link.messages import CommandResult, Message, MissionType
from ipoa_mission.simulator import streams
from ipoa_mission.simulator.file_service import FileService
from ipoa_mission.simulator.flight import Flight, FlightMode, MissionState
from ipoa_mission.simulator.judgement import Infeasible, infeasibility
from ipoa_mission.simulator.parameters import ParameterTable
from ipoa_mission.simulator.personality import PERSONALITIES, Personality
from ipoa_mission.simulator.transfers import Transfers
from ipoa_mission.simulator.words import SAID_WHEN_REACHED, begun
from ipoa_mission.wind import CALM, Wind
from ipoa_mission.world.frame import Geodetic

QUADROTOR = 2  # MAV_TYPE
CRITICAL, WARNING, INFO = 2, 4, 6
ERROR_LEVELS = 0x63  # an event's: INFO for the log, ERROR for ground stations
STATE_UNINIT, STATE_BOOT, STATE_STANDBY, STATE_ACTIVE = 0, 1, 3, 4
MISSION_ACTIVE, MISSION_SUSPENDED = 1, 2  # MISSION_CURRENT.mission_mode
FLYING_STEP_S = 0.02
GUIDED = 4  # ArduCopter's mode in which it climbs by command
SET_MODE, PAUSE_CONTINUE, FENCE_ENABLE = 176, 193, 207
SET_MISSION_CURRENT, REBOOT, MISSION_START, ARM_DISARM, PREARM_CHECKS = 224, 246, 300, 400, 401
GET_HOME_POSITION, GET_MESSAGE_INTERVAL, SET_MESSAGE_INTERVAL = 410, 510, 511
REQUEST_MESSAGE, REQUEST_CAPABILITIES = 512, 520
AUTOPILOT_VERSION, HOME_POSITION = 148, 242
ACCEPTED, DENIED, UNSUPPORTED = CommandResult.ACCEPTED, CommandResult.DENIED, CommandResult.UNSUPPORTED
FAILED = CommandResult.FAILED


class Autopilot:
    """One simulated vehicle, without I/O."""

    def __init__(
        self,
        family: Family,
        home: Geodetic,
        parameters: Parameters | None = None,
        cold: bool = False,
        nak_at: int | None = None,
        seed: int = 0,
        wind: Wind = CALM,
    ) -> None:
        """`cold`: it is powered up now, and has no position for a while; else it has stood there for long.

        `seed` picks the errors of the sensors it flies by. The item of number `nak_at` is refused; such a vehicle takes
        no mission as a file, in which no item can be refused.
        """
        self.habits: Personality = PERSONALITIES[family]
        self.table = ParameterTable(family, parameters or {})
        self.flight = Flight(family, home, self.table.values, wind, seed=seed)
        self.transfers = Transfers(self.habits, lambda: self.flight.home, self._say, self._listed, nak_at)
        limit = self.habits.limits[MissionType.MISSION]
        takes_file = self.habits.has_mission_file and nak_at is None
        self._files = FileService(takes_file, limit, self.transfers.listed, self.transfers.replace)
        self._schedule = streams.Schedule(self.habits.streams, self.habits.fixed_streams)
        self._outbox: list[tuple[Message, Target]] = []
        self._now = 0.0
        self._powered_s = 0.0 if cold else -math.inf
        self._told_reached = 0
        self._last_reached = m.Reached(0), 0  # and how often it is still to be said
        self._told_mode = self.habits.first_mode
        self._told_current = -1
        self._unflyable: Infeasible | None = None
        self._flown: tuple[Item, ...] = ()  # what the flight was given: without home, and only when it is complete
        self._idle_mode = self.habits.first_mode  # what it shows while it does nothing by itself
        self._mode_before = self.habits.first_mode  # PX4's, before it was sent home or to the ground
        self._armed_s: float | None = None
        self._has_begun = self._runs = False  # ArduPilot: whether it has a current item at all, and goes on with it
        self._commands = _commands(self)

    # --- the outside ------------------------------------------------------------------------------------------------

    def receive(self, message: Message, source: Target, now: float) -> None:
        """Somebody has said something to this vehicle."""
        self.tick(now)
        self._schedule.hear(source)
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
                if not self._go_to(seq) and not self.habits.home_is_item_0:
                    self._text(CRITICAL, "WPM: WP CURR CMD: Not in list\t")
            case m.Ping():
                self._say(message, source)
            case m.TimeSync(0, asked):
                self._say(m.TimeSync(round(now * 1e9) or 1, asked), source)
            case m.FileTransfer():
                for answer in self._files.answers(message, source):
                    self._say(answer, source)
        self._tell_changes()

    def tick(self, now: float) -> None:
        """Time has passed: fly on, ask again, stream."""
        self._now = max(self._now, now)
        self.transfers.booted = self._age >= self.habits.start_up.listens_s
        self.flight.advance(self._now)
        self._notice_disarming()
        self.transfers.tick(self._now)
        self._tell_changes()
        for name in self._schedule.due(self._now):
            if (message := self._stream(name)) is not None:
                self._say(message, EVERYONE)

    def outgoing(self) -> list[tuple[Message, Target]]:
        """What is to be said, and to whom."""
        said, self._outbox = self._outbox, []
        return said

    @property
    def deadline(self) -> float:
        """When `tick` is next needed."""
        flying = self._now + FLYING_STEP_S if self.flight.armed else math.inf
        return min(flying, self._schedule.deadline, self.transfers.deadline)

    # --- its state --------------------------------------------------------------------------------------------------

    @property
    def _age(self) -> float:
        return self._now - self._powered_s

    @property
    def mode(self) -> int:
        """HEARTBEAT.custom_mode."""
        return self._idle_mode if self.flight.mode is FlightMode.HOLD else self.habits.modes[self.flight.mode]

    @property
    def _mission_mode(self) -> int:
        return self.habits.modes[FlightMode.MISSION]

    @property
    def _first(self) -> int:
        return 1 if self.habits.home_is_item_0 else 0

    def _hinders(self) -> str:
        """Why it cannot be armed in its present mode; nothing where it can."""
        start_up = self.habits.start_up
        if self._age < start_up.steady_s:
            return start_up.unsteady
        if self._age < start_up.position_s and self.mode in self.habits.placed_modes:
            return start_up.unplaced
        if self.mode == self._mission_mode and not self._flown:
            return start_up.no_mission
        if not self.habits.tells_prearm and self.mode not in self.habits.armable_modes:
            return start_up.unsteady
        return ""

    def _is_standing(self) -> bool:
        return self.flight.armed and self.flight.landed and self.flight.mode is FlightMode.HOLD

    # --- what is said unasked ---------------------------------------------------------------------------------------

    def _say(self, message: Message, to: Target) -> None:
        self._outbox.append((message, to))

    def _text(self, severity: int, text: str) -> None:
        """Words; what does not fit 50 bytes goes on in a second message."""
        for chunk, start in enumerate(range(0, len(text), 50)):
            self._say(m.Text(severity, text[start : start + 50], int(len(text) > 50), chunk), EVERYONE)

    def _stream(self, name: str) -> Message | None:
        match name:
            case "HEARTBEAT":
                return self._heartbeat()
            case "SYS_STATUS":
                return streams.status(not self._hinders(), self.habits.tells_prearm)
            case "MISSION_CURRENT":
                self._repeat_reached()
                return self._current()
            case "TIMESYNC":
                return m.TimeSync(0, round(self._now * 1e9))
            case "GLOBAL_POSITION_INT" if self._age < self.habits.start_up.origin_s:
                return m.Position(self._now, 0.0, 0.0, 0.0, 0.0) if self.habits.tells_prearm else None
            case "HOME_POSITION" | "GPS_GLOBAL_ORIGIN" if self._age < self.habits.start_up.origin_s:
                return None
            case _:
                return streams.FROM_FLIGHT[name](self.flight, self._now)

    def _repeat_reached(self) -> None:
        reached, times = self._last_reached
        if times > 0:
            self._last_reached = reached, times - 1
            self._say(reached, EVERYONE)

    def _heartbeat(self) -> m.Heartbeat:
        armed = m.ARMED_FLAG if self.flight.armed else 0
        state = STATE_STANDBY
        if not self.transfers.booted:
            state = STATE_BOOT if self.habits.tells_prearm else STATE_UNINIT
        elif self.flight.armed and not (self.habits.tells_prearm and self.flight.landed):
            state = STATE_ACTIVE
        elif not self.habits.tells_prearm and not self.flight.armed and self._hinders():
            state = STATE_UNINIT
        return m.Heartbeat(QUADROTOR, self.habits.mav_autopilot, self.habits.base_mode | armed, self.mode, state)

    def _current(self) -> m.Current:
        total = len(self.transfers.stores[MissionType.MISSION].items) - self._first
        if total <= 0:
            mode = MISSION_SUSPENDED if self._first == 0 else 0
            return m.Current(0, self.habits.no_total, int(MissionState.NO_MISSION), mode)
        number = self.transfers.list_id(MissionType.MISSION)
        if self.habits.home_is_item_0:
            seq, state = (self.flight.current + 1 if self._has_begun else 0), MissionState.NOT_STARTED
            if self._runs or self.flight.mode is FlightMode.MISSION:
                state = MissionState.ACTIVE
            if self.flight.armed and self.flight.mission_state is MissionState.COMPLETE:
                state = MissionState.COMPLETE
            return m.Current(seq, total, int(state), int(self.mode == self._mission_mode), number)
        active = self.mode in self.habits.placed_modes - {self.habits.modes[FlightMode.HOLD]}
        state = MissionState.ACTIVE if active else MissionState.NOT_STARTED
        if self._unflyable:
            state = MissionState.NO_MISSION
        elif self.flight.mission_state is MissionState.COMPLETE:
            state = MissionState.COMPLETE
        elif not active and self.flight.reached:
            state = MissionState.PAUSED
        mode = MISSION_ACTIVE if active else MISSION_SUSPENDED
        return m.Current(self.flight.current, total, int(state), mode, number)

    def _tell_changes(self) -> None:
        """Say at once what this firmware does not leave to its streams: an item reached, another current or mode."""
        reached = self.flight.reached
        if len(reached) < self._told_reached:
            self._told_reached = 0
        fresh = reached[self._told_reached :]
        if fresh and self._now < fresh[-1].time_s + self.habits.reached_slot_s:
            return  # another may come and hide it
        self._told_reached += len(fresh)
        for n, one in enumerate(fresh):
            soon = one.time_s + self.habits.reached_slot_s
            if one.announced and not any(later.time_s < soon for later in fresh[n + 1 :]):
                self._last_reached = m.Reached(one.index + self._first), self.habits.reached_repeats
                self._say(self._last_reached[0], EVERYONE)
            if self.habits.home_is_item_0:
                self._say_item(one.index)
        if fresh and self.flight.mode is FlightMode.MISSION and self.habits.home_is_item_0:
            self._say_begun()
        elif not self.habits.home_is_item_0 and self.flight.current != self._told_current and self._flown:
            self._say(self._current(), EVERYONE)
        self._told_current = self.flight.current
        if self.mode != self._told_mode:
            self._told_mode = self.mode
            if self.habits.heartbeat_on_change:
                self._say(self._heartbeat(), EVERYONE)

    def _say_item(self, index: int) -> None:
        """ArduPilot's words for an item that is done."""
        command = self._flown[index].command
        if command in SAID_WHEN_REACHED:
            self._text(INFO, f"Reached command #{index + 1}")
        elif command > LAST_NAV:
            self._text(INFO, begun(index + 1, command))

    def _say_begun(self) -> None:
        if self.flight.current < len(self._flown):
            self._text(INFO, begun(self.flight.current + 1, self._flown[self.flight.current].command))

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
        if not items:
            self._has_begun = self._runs = False

    # --- orders -----------------------------------------------------------------------------------------------------

    def _command(self, number: int, params: tuple[float, ...], source: Target) -> None:
        held, self._outbox = self._outbox, []
        act = self._commands.get(number)
        result = act(params) if act else UNSUPPORTED
        words, self._outbox = self._outbox, held
        number_asked = {REQUEST_MESSAGE: _whole(params[0]), GET_HOME_POSITION: HOME_POSITION}.get(number)
        if number == REQUEST_CAPABILITIES:
            number_asked = AUTOPILOT_VERSION
        answers: list[Message] = []
        if result == ACCEPTED and number_asked is not None and (told := self._asked_for(number_asked)) is not None:
            answers = [told]
        acks: list[Message] = [m.CommandAck(number, result)]
        if number == SET_MESSAGE_INTERVAL:
            known = self._schedule.set_interval(_whole(params[0]), params[1], self._now, source)
            acks = [m.CommandAck(number, ACCEPTED if known else self.habits.no_such_stream)]
        elif number == GET_MESSAGE_INTERVAL:
            interval = self._schedule.interval_us(_whole(params[0]), source)
            told_us, heard = self.habits.no_such_interval if interval is None else (interval, int(ACCEPTED))
            self._say(m.MessageInterval(_whole(params[0]) & 0xFFFF, told_us), source)
            acks = [m.CommandAck(number, heard)]
        elif number == SET_MODE and self.habits.mode_acks > 1:
            acks = [m.CommandAck(number, ACCEPTED), *acks]
        for message in (*acks, *answers) if self.habits.acks_first else (*answers, *acks):
            self._say(message, source)
        self._outbox += words

    def _asked_for(self, number: int) -> Message | None:
        if number == AUTOPILOT_VERSION:
            return m.AutopilotVersion(self.habits.capabilities, self.habits.version, uid=1)
        return self._stream(message_name(number) or "")

    def can_tell(self, number: float) -> CommandResult:
        """Command 512: whether there is such a message."""
        name = message_name(_whole(number))
        known = name == "AUTOPILOT_VERSION" or name in streams.KNOWN
        return ACCEPTED if known else CommandResult(self.habits.no_such_message)

    def arm(self, wish: float) -> CommandResult:
        """Command 400: let the motors run, or stop them."""
        if wish not in (0.0, 1.0):
            return UNSUPPORTED
        if wish == 0.0:
            return self._disarm()
        if self.flight.armed:
            return ACCEPTED
        refused = CommandResult(self.habits.refused_arming)
        if hinders := self._hinders():
            self._text(CRITICAL, f"Arm: {hinders}" if self.habits.tells_prearm else f"Arming denied: {hinders}\t")
            return refused
        if self.mode not in self.habits.armable_modes and not self._arms_in_auto():
            self._text(CRITICAL, f"Arm: {mode_name(self.habits.autopilot, self.mode)} mode not armable")
            return refused
        self._arm(self.habits.arm_words[0])
        return ACCEPTED

    def _arms_in_auto(self) -> bool:
        return self.mode == self._mission_mode and bool(int(self.table.values.get("AUTO_OPTIONS", 0.0)) & 1)

    def _arm(self, words: str) -> None:
        self.flight.arm()
        self._armed_s = self._now
        self._text(INFO, words)
        if not self.habits.home_is_item_0 and self.mode == self._mission_mode:
            self._start()

    def _disarm(self) -> CommandResult:
        if not self.flight.landed:
            if not self.habits.tells_prearm:
                self._text(CRITICAL, "Disarming denied: not landed\t")
            return CommandResult(self.habits.refused_arming)
        if self.flight.armed:
            self._stop_motors(self.habits.arm_words[1])
        return ACCEPTED

    def _notice_disarming(self) -> None:
        """The pilot has landed and stopped the motors; or they have run for nothing for too long."""
        if self._armed_s is None:
            return
        if not self.flight.armed:
            if not self.habits.home_is_item_0 and self.flight.mission_state is MissionState.COMPLETE:
                self._text(INFO, "Mission finished, landed\t")
            self._stop_motors(self.habits.arm_words[2])
        elif self._is_standing():
            delay = self.table.values[self.habits.disarm_delay]
            if 0.0 < delay <= self._now - self._armed_s:
                self._stop_motors(self.habits.arm_words[3])

    def _stop_motors(self, words: str) -> None:
        mode = self._told_mode
        self.flight.disarm()
        self._armed_s = None
        self._text(INFO, words)
        returned = mode in (self.habits.modes[FlightMode.RETURN], self.habits.modes[FlightMode.LAND])
        self._idle_mode = self._mode_before if returned and not self.habits.home_is_item_0 else mode
        self.flight.hold()
        if self.habits.home_is_item_0:
            self._tell_changes()
            self.flight.rewind()
            self._has_begun = self._runs = False
            if self.mode == self._mission_mode:
                self._run()

    def _run(self) -> None:
        """ArduPilot's mission goes on with its current item, whether it flies or not."""
        if self._flown:
            self._has_begun = self._runs = True
            self._say_begun()

    def _start(self) -> None:
        """The mission is flown from where it stands."""
        takes_off = self.flight.landed
        self.flight.start()
        if self.habits.home_is_item_0:
            self._run()
            return
        self._text(INFO, "Executing Mission\t")
        ahead = (item.altitude for item in self._flown[self.flight.current :] if item.has_position)
        if takes_off and (height := next(ahead, None)) is not None:
            item = self._flown[self.flight.current]
            above = height - self.flight.home.altitude if item.frame in (Frame.GLOBAL, Frame.GLOBAL_INT) else height
            self._text(INFO, f"Climb to {above:.1f} meters above home\t")

    def start_mission(self, params: Sequence[float]) -> CommandResult:
        """Command 300: fly the mission; PX4 from the item that is named, arming by itself."""
        if self.habits.mission_arms:
            if not self._flown:
                self._text(CRITICAL, "Mission start denied! No valid mission\t")
                return DENIED
            if not self.flight.armed:
                self._idle_mode = self._mission_mode
                if self._hinders():
                    return DENIED
            self._go_to(_whole(params[0]))
            self._idle_mode = self._mission_mode
            if self.flight.armed:
                self._start()
            else:
                self._arm("Armed by mission start\t")
            return ACCEPTED
        if params[0] or params[1]:
            return DENIED
        if self.flight.armed and (refused := self._refuses_mode(self._mission_mode)) is not None:
            return refused
        result = self._set_mode(self._mission_mode)
        if result == ACCEPTED and self.flight.armed and self.flight.mode is not FlightMode.MISSION:
            self._start()
        return result

    def _has_takeoff_first(self) -> bool:
        """Whether the first command to come that moves the vehicle is a take-off; DO items may stand before it."""
        first = 0 if self.flight.mission_state is MissionState.COMPLETE else self.flight.current
        flown = (item.command for item in self._flown[first:] if item.command < LAST_NAV)
        return next(flown, None) == Command.NAV_TAKEOFF

    def set_mode(self, params: Sequence[float]) -> CommandResult:
        """Command 176: main and sub mode for PX4, ArduPilot's one number."""
        main, sub = _whole(params[1]), _whole(params[2])
        return self._set_mode(main if self.habits.home_is_item_0 else (main & 0xFF) << 16 | (sub & 0xFF) << 24)

    def _set_mode(self, custom_mode: int) -> CommandResult:
        if not knows_mode(self.habits.autopilot, custom_mode):
            if self.habits.home_is_item_0:
                self._text(WARNING, f"No such mode {custom_mode}")
            return FAILED
        if custom_mode == self.mode:
            return ACCEPTED
        if self.flight.armed and (refused := self._refuses_mode(custom_mode)) is not None:
            return refused
        modes = {number: mode for mode, number in self.habits.modes.items()}
        mode = modes.get(custom_mode, FlightMode.HOLD)
        if mode is FlightMode.RETURN or mode is FlightMode.LAND:
            self._mode_before = self.mode
        self._runs = False
        if not self.flight.armed or self.flight.landed or mode is FlightMode.HOLD:
            self._idle_mode = custom_mode
            self.flight.hold()
            if mode is FlightMode.MISSION and self.habits.home_is_item_0:
                self._run()  # on the ground it takes MISSION_START to leave it
            elif mode is FlightMode.MISSION and self.flight.armed:
                self._start()
        elif mode is FlightMode.MISSION:
            self._start()
        elif mode is FlightMode.RETURN:
            self.flight.return_home()
        else:
            self.flight.land()
        return ACCEPTED

    def _refuses_mode(self, custom_mode: int) -> CommandResult | None:
        """What an armed vehicle says to a mode that it cannot fly; None where it can."""
        name = mode_name(self.habits.autopilot, custom_mode)
        is_mission = custom_mode == self._mission_mode
        if not self.habits.home_is_item_0:
            if not is_mission or self._flown:
                return None
            self._text(CRITICAL, "Switching to Mission is currently not available\t")
            return CommandResult.TEMPORARILY_REJECTED
        if custom_mode in self.habits.placed_modes and self._age < self.habits.start_up.position_s:
            self._text(WARNING, f"Mode change to {name} failed: requires position")
            return FAILED
        if not is_mission:
            return None
        lacks = self.habits.missing_takeoff_text
        if not self._flown or (lacks and self.flight.landed and not self._has_takeoff_first()):
            if self._flown:
                self._text(CRITICAL, lacks or "")
            self._text(WARNING, f"Mode change to {name} failed: init failed")
            return FAILED
        return None

    def _go_to(self, seq: int, restart: bool = False) -> bool:
        index = max(seq - self._first, 0)
        if not (0 <= seq < len(self._flown) + self._first and self._flown):
            return False
        if restart:
            self.flight.rewind()
        self.flight.set_current(index)
        if self.habits.home_is_item_0:
            self._has_begun = True
            self._runs = self._runs or restart
        self._say(self._current(), EVERYONE)
        self._told_current = index
        if self.habits.home_is_item_0 and self._runs:
            self._say_begun()
        return True

    def jump_to(self, params: Sequence[float]) -> CommandResult:
        """Command 224."""
        if not self.habits.knows_command_224:
            return UNSUPPORTED
        return ACCEPTED if self._go_to(_whole(params[0]), params[1] == 1.0) else DENIED

    def obey(self, mode: FlightMode) -> CommandResult:
        """Return, land or hold, as a command of its own."""
        return self._set_mode(self.habits.modes[mode])

    def pause(self, goes_on: float) -> CommandResult:
        """Command 193: ArduPilot's alone."""
        if not self.habits.home_is_item_0:
            return UNSUPPORTED
        return self._set_mode(self._mission_mode) if goes_on >= 0.5 else self.obey(FlightMode.HOLD)

    def climb(self, height: float) -> CommandResult:
        """Command 22: ArduPilot takes off in GUIDED; PX4's take-off mode is not simulated."""
        if not self.habits.home_is_item_0:
            return UNSUPPORTED
        if self.mode != GUIDED or not self._is_standing() or not 0.0 < height < math.inf:
            return FAILED
        self.flight.climb(height)
        return ACCEPTED

    def check(self) -> CommandResult:
        """Command 401: say what hinders arming; PX4 says it by events."""
        if self.habits.tells_prearm and (hinders := self._hinders()):
            self._text(CRITICAL, f"PreArm: {hinders}")
        return ACCEPTED

    def reboot(self, how: float) -> CommandResult:
        """Command 246: ArduPilot starts up anew, unless it is armed; PX4 in simulation does not."""
        if not self.habits.home_is_item_0:
            return DENIED if how else ACCEPTED
        if how != 1.0:
            return UNSUPPORTED
        if self.flight.armed:
            return FAILED
        self._powered_s = self._now
        self._idle_mode = self.habits.first_mode
        self._has_begun = self._runs = False
        self.flight.rewind()
        return ACCEPTED


def _commands(autopilot: Autopilot) -> Mapping[int, Callable[[Sequence[float]], CommandResult]]:
    """What each MAV_CMD does; any other gets UNSUPPORTED."""
    return {
        Command.NAV_RETURN_TO_LAUNCH: lambda p: autopilot.obey(FlightMode.RETURN),
        Command.NAV_LAND: lambda p: autopilot.obey(FlightMode.LAND),
        Command.NAV_TAKEOFF: lambda p: autopilot.climb(p[6]),
        SET_MODE: autopilot.set_mode,
        PAUSE_CONTINUE: lambda p: autopilot.pause(p[0]),
        FENCE_ENABLE: lambda p: ACCEPTED if autopilot.habits.home_is_item_0 else UNSUPPORTED,
        SET_MISSION_CURRENT: autopilot.jump_to,
        REBOOT: lambda p: autopilot.reboot(p[0]),
        MISSION_START: autopilot.start_mission,
        ARM_DISARM: lambda p: autopilot.arm(p[0]),
        PREARM_CHECKS: lambda p: autopilot.check(),
        GET_HOME_POSITION: lambda p: ACCEPTED,
        GET_MESSAGE_INTERVAL: lambda p: ACCEPTED,
        SET_MESSAGE_INTERVAL: lambda p: ACCEPTED,
        REQUEST_MESSAGE: lambda p: autopilot.can_tell(p[0]),
        REQUEST_CAPABILITIES: lambda p: ACCEPTED,
    }


def _whole(value: float) -> int:
    return int(value) if math.isfinite(value) and abs(value) < 2**31 else -1
