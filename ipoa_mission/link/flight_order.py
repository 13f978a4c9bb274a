"""What a flying vehicle is told besides its mission: pause, resume, return to launch; and any change of mode."""

import logging
import math
from collections.abc import Callable
from dataclasses import dataclass

from ipoa_mission.errors import MissionError
from ipoa_mission.link.conversations import VehicleTexts, listen_for_words
from ipoa_mission.link.dialogue import Dialogue, Pause, Remark, until
from ipoa_mission.link.messages import CommandAck, CommandLong, CommandResult, Message
from ipoa_mission.link.orders import CommandRefused, command, mode_order, obeyed, order
from ipoa_mission.link.vehicle_state import NotFlown, NotReady, VehicleState
from ipoa_mission.mission.commands import Command, VehicleCommand

log = logging.getLogger(__name__)
#: How often a vehicle that is watched is told to do something else, and how long it may take each time [s].
SAYINGS, SAID_AGAIN_S = 6, 1.0
#: How long a vehicle may take to show its mode [s].
SHOWN_S = 5.0
#: Answers after which the mode may still come.
HOPEFUL = frozenset({CommandResult.ACCEPTED, CommandResult.IN_PROGRESS})


def pause(state: VehicleState) -> Dialogue[None]:
    """Have a flying vehicle stop and hold its place until it is told otherwise.

    ArduCopter pauses within AUTO on its way to a waypoint, and brakes where it can't; PX4 changes to hold.

    Raises:
        NotReady: it does not fly, or will not stop.
    """
    yield from _expect_flying(state)
    if state.autopilot.protocol_profile.pauses_in_mission:
        result, _ = yield from command(Command.DO_PAUSE_CONTINUE, 0.0)
        if result == CommandResult.ACCEPTED:
            yield from until(lambda: state.custom_mode is not None, SHOWN_S)
            return
    yield from _enter(state, state.autopilot.modes.hold)


def resume(state: VehicleState) -> Dialogue[None]:
    """Have a flying vehicle go on with its mission, at the item at which it is.

    Raises:
        NotReady: it does not fly, or has no mission to fly.
    """
    yield from _expect_flying(state)
    yield from _enter(state, state.autopilot.modes.mission)
    if state.autopilot.protocol_profile.pauses_in_mission:
        yield from command(
            Command.DO_PAUSE_CONTINUE, 1.0
        )  # one that is not paused has nothing to go on with, and says so


def return_to_launch(state: VehicleState) -> Dialogue[None]:
    """Have a flying vehicle come home and land, as its own parameters say.

    Raises:
        NotReady: it does not fly, or will not come.
    """
    yield from _expect_flying(state)
    yield from _enter(state, state.autopilot.modes.returning)


@dataclass(frozen=True)
class _Step:
    """What is said until a heartbeat shows the `mode`, or where there is none the command is accepted.

    `pauses`: whether the vehicle is held within its mission then; `otherwise` is said in its place where it is refused.
    """

    name: str
    message: CommandLong
    mode: int | None = None
    pauses: bool = False
    otherwise: "_Step | None" = None


class FlightOrder:
    """The order to a vehicle that is watched to do something else: said until it shows that it does, or refuses.

    `words`: why it does not do so; nothing while that is not known. `is_paused`: it is held within its mission.
    While the link is lost nothing is ordered: nobody knows what the vehicle is at when it is heard again.
    """

    def __init__(self, state: VehicleState, now: Callable[[], float]) -> None:
        self.words, self.is_paused, self._is_cut = "", False, False
        self._state, self._now = state, now
        self._steps: list[_Step] = []
        self._said, self._due_s = 0, -math.inf

    def give(self, mode: int) -> None:
        """Order this mode, from the next message that is heard on; it takes the place of an order that was given."""
        self._take(self._change(mode))

    def hold(self) -> None:
        """Order it to stop and to hold its place, as `pause` does."""
        state, brake = self._state, self._change(self._state.autopilot.modes.hold)
        if self.is_paused or any(step.pauses for step in self._steps):
            return  # it is told so already, and would refuse to be so twice
        if state.autopilot.protocol_profile.pauses_in_mission and state.custom_mode == state.autopilot.modes.mission:
            self._take(_Step("pause", order(Command.DO_PAUSE_CONTINUE, 0.0), pauses=True, otherwise=brake))
        else:
            self._take(brake)

    def go_on(self) -> None:
        """Order it to go on with its mission, at the item at which it is."""
        mission = self._change(self._state.autopilot.modes.mission)
        self._take(mission, *([_Step("go on", order(Command.DO_PAUSE_CONTINUE, 1.0))] if self.is_paused else []))

    @property
    def is_under_way(self) -> bool:
        """Tell whether something was ordered that the vehicle has neither shown nor refused."""
        return bool(self._steps)

    def cut(self, is_cut: bool) -> None:
        """The link is lost, or is there again; what was ordered and has not been seen is not said any more."""
        self._is_cut = is_cut
        if self._steps:
            self.words = f"{self._steps[0].name} was ordered, and the link was lost before the vehicle showed it"
            self._steps.clear()

    def look(self, heard: Message, now_s: float) -> Dialogue[None]:
        """Make of one message what it tells of the order, and say it when it is time."""
        state = self._state
        self.is_paused = self.is_paused and state.custom_mode == state.autopilot.modes.mission
        if not state.armed:
            self._steps.clear()
        try:
            self._hear(heard)
            if not self._steps:
                return
            state.expect_flown()
            if self._now() >= self._due_s:
                if self._said == SAYINGS:
                    name = self._steps[0].name
                    self._refused(
                        NotReady(
                            f"{name} was ordered {SAYINGS} times, and the vehicle does not show it",
                            code="mode-not-shown",
                        )
                    )
                self._said, self._due_s = self._said + 1, self._now() + SAID_AGAIN_S
                yield Remark(self._steps[0].message)
        except (NotFlown, NotReady, CommandRefused) as hinders:
            self.words = str(hinders)
            self._steps.clear()
            log.warning("%s", hinders)

    def _change(self, mode: int) -> _Step:
        autopilot = self._state.autopilot
        return _Step(autopilot.modes.name(mode), mode_order(mode, autopilot), mode)

    def _take(self, *steps: _Step) -> None:
        self.words, self._steps = "", [*steps]
        if self._is_cut and steps:
            self.words = f"{self._steps[0].name} was not ordered: the link is lost"
            self._steps.clear()
        self._said, self._due_s = 0, -math.inf

    def _hear(self, heard: Message) -> None:
        """What is done is not said any more."""
        while self._steps and (step := self._steps[0]).mode is not None and self._state.custom_mode == step.mode:
            self._take(*self._steps[1:])
        if not self._steps or not self._said:
            return
        step = self._steps[0]
        match heard:
            case CommandAck(step.message.command, CommandResult.ACCEPTED) if step.mode is None:
                self.is_paused = step.pauses
                self._take(*self._steps[1:])
            case CommandAck(step.message.command, result) if result not in HOPEFUL:
                self._refused(CommandRefused(f"change to {step.name}" if step.mode is not None else step.name, result))

    def _refused(self, why: MissionError) -> None:
        """Raise it, unless something else can be ordered instead."""
        if (otherwise := self._steps[0].otherwise) is None:
            raise why
        self._take(otherwise)


def change_mode(state: VehicleState, mode: int) -> Dialogue[str]:
    """Ask for a mode and see it in the heartbeat; what hinders, or nothing."""
    if state.custom_mode == mode:
        return ""
    result, words = yield from obeyed(mode_order(mode, state.autopilot))
    texts = VehicleTexts(words=[words] if words else [])
    if result == CommandResult.ACCEPTED:
        result = yield from _taken_back(state, mode, texts)
    if state.custom_mode == mode:
        return ""
    name = state.autopilot.modes.name(mode)
    if result == CommandResult.ACCEPTED:
        return f"it accepted {name} but does not show it"
    return str(texts) or str(CommandRefused(f"change to {name}", result))


def _taken_back(state: VehicleState, mode: int, texts: VehicleTexts) -> Dialogue[int]:
    """Wait for a mode that was accepted; PX4 says so first, and refuses in a second answer what it cannot fly."""
    heard: Message | None = None if state.custom_mode == mode else (yield Pause(SHOWN_S))
    while heard is not None and state.custom_mode != mode:
        texts.note(heard)
        match heard:
            case CommandAck(VehicleCommand.DO_SET_MODE, result) if result not in HOPEFUL:
                yield from listen_for_words(texts)
                return result
        heard = yield None
    return CommandResult.ACCEPTED


def _enter(state: VehicleState, mode: int) -> Dialogue[None]:
    if hinders := (yield from change_mode(state, mode)):
        raise NotReady(hinders, hint=str(state))


def _expect_flying(state: VehicleState) -> Dialogue[None]:
    """Only what its heartbeats tell is waited for: an order to stop must not wait for a stream that may not come."""
    yield from until(lambda: state.armed is not None and state.custom_mode is not None, SHOWN_S)
    if not state.armed or state.in_air is False:
        raise NotReady(f"expected a vehicle in the air: {state}", hint="`fly` begins a flight", code="not-in-the-air")
