"""A vehicle on a virtual clock that may refuse or be silent."""

from collections.abc import Callable

from ipoa_mission.autopilot.autopilot import Autopilot
from ipoa_mission.errors import MissionError
from ipoa_mission.link.departure import Departure
from ipoa_mission.link.dialogue import SPECIFIED, Cancelled, Dialogue, Exchange
from ipoa_mission.link.messages import (
    ARMED_FLAG,
    CommandAck,
    CommandLong,
    Current,
    ExtendedState,
    Heartbeat,
    Message,
    Position,
    SetCurrent,
    SystemStatus,
    Text,
)
from ipoa_mission.link.vehicle_state import ON_GROUND, PREARM_CHECK, VehicleState

PX4, ARDUPILOT = Autopilot.PX4, Autopilot.ARDUPILOT
TAKEOFF, SET_MODE, SET_CURRENT, START, ARM, RUN_PREARM_CHECKS, STREAM = 22, 176, 224, 300, 400, 401, 511


class Scripted:
    """Obeys, except for a test's changes; `commands` has its orders."""

    def __init__(self, autopilot: Autopilot, first: int = 1) -> None:
        self.autopilot = autopilot
        self.first = first
        self.mode, self.armed, self.height, self.current = 0, False, 0.0, 5
        self.ready_s, self.streams = 0.0, True
        self.landed: int | None = ON_GROUND  # None: it does not tell
        self.refuses: dict[int, tuple[int, str]] = {}
        self.commands: list[tuple[int, ...]] = []
        self.state = VehicleState(autopilot)
        self.now = 0.0

    def hold(
        self,
        make: Callable[[Departure], Dialogue[None]],
        climb: float = 0.0,
        cancel_s: float = 1e9,
        cancel: MissionError | None = None,
    ) -> None:
        """Hold a dialogue on a virtual clock, with streams four times a second."""
        exchange = Exchange(make(Departure(self.state, self.first, self.first + 1, climb)), self.now, SPECIFIED)
        while not exchange.finished:
            heard = [answer for message in exchange.outgoing() for answer in self.answer(message)]
            self.now += 0.25
            for message in [*heard, *self.stream()]:
                self.state.note(message)
                exchange.receive(message, self.now)
            exchange.tick(self.now)
            if self.now >= cancel_s:
                cancel_s = 1e9
                exchange.interrupt(cancel or Cancelled("cancelled"), self.now)

    def stream(self) -> list[Message]:
        beat = Heartbeat(2, 3, ARMED_FLAG if self.armed else 0, self.mode)
        if not self.streams:
            return [beat]
        placed = self.now >= self.ready_s
        position = Position(self.now, 47.4 * placed, 8.5 * placed, 400.0, self.height)
        ready = PREARM_CHECK * placed
        messages: list[Message] = [beat, position, Current(self.current)]
        if self.landed is not None:
            messages.append(ExtendedState(self.landed))
        return [*messages, SystemStatus(PREARM_CHECK, PREARM_CHECK, ready)]

    def answer(self, message: Message) -> list[Message]:
        if isinstance(message, SetCurrent):
            self.current = message.seq
        if not isinstance(message, CommandLong):
            return []
        number, params = message.command, message.params
        if number != STREAM:
            self.commands.append((number, *(int(p) for p in params[:3])))
        if number == ARM and params[0] == 0.0:
            self.armed = False
            return [CommandAck(ARM, 0)]
        if number in self.refuses:
            result, words = self.refuses[number]
            return [CommandAck(number, result), Text(2, words)]
        self.obey(number, params)
        return [CommandAck(number, 0)]

    def obey(self, number: int, params: tuple[float, ...]) -> None:
        match number:
            case 176:
                sub = int(params[2])
                self.mode = int(params[1]) if self.autopilot is ARDUPILOT else int(params[1]) << 16 | sub << 24
            case 224:
                self.current = int(params[0])
            case 400:
                self.armed = True
            case 300:
                self.mode = self.autopilot.modes.mission
            case 22:
                self.height = params[6]
