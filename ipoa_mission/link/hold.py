"""What a flying vehicle is told besides its mission: pause, resume, return to launch; and any change of mode."""

from ipoa_mission.link.conversations import VehicleTexts, listen_for_words
from ipoa_mission.link.dialogue import Dialogue, Pause, until
from ipoa_mission.link.messages import CUSTOM_MODE_FLAG, CommandAck, CommandResult, Message
from ipoa_mission.link.orders import CommandRefused, command
from ipoa_mission.link.state import NotReady, VehicleState
from ipoa_mission.mission.commands import Command, VehicleCommand

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
    if state.autopilot.manners.pauses_in_mission:
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
    if state.autopilot.manners.pauses_in_mission:
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


def change_mode(state: VehicleState, mode: int) -> Dialogue[str]:
    """Ask for a mode and see it in the heartbeat; what hinders, or nothing."""
    if state.custom_mode == mode:
        return ""
    result, words = yield from command(
        VehicleCommand.DO_SET_MODE, CUSTOM_MODE_FLAG, *state.autopilot.modes.numbers(mode)
    )
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
        raise NotReady(f"expected a vehicle in the air: {state}", hint="`fly` begins a flight")
