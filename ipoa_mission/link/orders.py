"""What one tells a vehicle besides a mission: commands, the current item, arming, starting, parameters."""

import struct
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TypeVar

from ipoa_mission.errors import BadInput, MissionError
from ipoa_mission.link.conversations import VehicleTexts, listen_for_words
from ipoa_mission.link.definitions import message_number
from ipoa_mission.link.dialogue import Ask, Dialogue, NoAnswer, Pause, Remark, Step
from ipoa_mission.link.messages import (
    CUSTOM_MODE_FLAG,
    CommandAck,
    CommandLong,
    CommandResult,
    Current,
    Message,
    ParamRequestRead,
    ParamSet,
    ParamValue,
    SetCurrent,
)
from ipoa_mission.link.telemetry import AutopilotVersion, HomePosition, SystemTime
from ipoa_mission.mission.commands import VehicleCommand
from ipoa_mission.vehicles.autopilot import Autopilot
from ipoa_mission.world.frame import Geodetic

M = TypeVar("M", bound=Message)

#: MAV_PROTOCOL_CAPABILITY_FTP.
FILE_TRANSFER = 32
#: MAV_PARAM_TYPE of whole numbers, which PX4 sends bit by bit.
INT_TYPES = frozenset({1, 2, 3, 4, 5, 6})
#: A parameter that does not exist is met with silence: how often one asks, and how long one listens each time [s].
PARAMETER_ROUNDS, PARAMETER_ROUND_S = 6, 0.7
#: How often it has to answer to what it knows, until what it does not answer to is not there.
SURE = 4
#: The rounds that follow where nothing at all was heard: a slow link, or a vehicle that is busy.
SLOW_ROUNDS, SLOW_ROUND_S = 5, 2.0
#: How long one listens each time that a parameter is set, before another value is believed to be kept [s].
SETTING_S = (1.0, 2.0, 4.0)
#: A message that is asked for by REQUEST_MESSAGE: how often, and the pause after a refusal [s].
ASKINGS, REFUSED_S = 5, 0.3


class CommandRefused(MissionError):
    """The vehicle would not do what it was told; the message has its words."""

    def __init__(self, what: str, result: int, words: str = "") -> None:
        self.what, self.result = what, result
        name = CommandResult(result).name if result in set(CommandResult) else str(result)
        super().__init__(f"{what}: the vehicle answered {name}" + (f": {words}" if words else ""))


def order(number: int, *params: float) -> CommandLong:
    """A COMMAND_LONG; what is left out of its seven parameters is 0."""
    return CommandLong(number, (*params, *(0.0,) * (7 - len(params))))  # type: ignore[arg-type]


def mode_order(mode: int, autopilot: Autopilot) -> CommandLong:
    """The order to change to a mode, HEARTBEAT.custom_mode."""
    return order(VehicleCommand.DO_SET_MODE, CUSTOM_MODE_FLAG, *autopilot.modes.numbers(mode))


def command(number: int, *params: float) -> Dialogue[tuple[int, str]]:
    """Give a COMMAND_LONG; its result and the words that came with it."""
    return obeyed(order(number, *params))


def obeyed(one: CommandLong) -> Dialogue[tuple[int, str]]:
    """The same of one that is spelled already."""
    texts, number = VehicleTexts(), one.command
    step: Step = Ask(one)
    while True:
        heard = yield step
        step = None
        match heard:
            case CommandAck(n, CommandResult.IN_PROGRESS) if n == number:
                step = Pause(30.0)
            case CommandAck(n, result) if n == number:
                if result != CommandResult.ACCEPTED:
                    yield from listen_for_words(texts)
                return result, str(texts)
            case None:
                raise NoAnswer(f"command {number} was begun, but never ended", code="command-not-ended")
            case _:
                texts.note(heard)


def set_current(seq: int, restart: bool = False) -> Dialogue[None]:
    """Go on with the item at `seq`: by command 224, or by the older message where that is unknown (PX4).

    `restart`: jumps are counted anew, and a mission that was complete is no more.

    Raises:
        CommandRefused: there is no such item.
        NoAnswer: nothing shows that the vehicle took it.
    """
    result, words = yield from command(VehicleCommand.DO_SET_MISSION_CURRENT, float(seq), float(restart))
    if result == CommandResult.ACCEPTED:
        return
    if result != CommandResult.UNSUPPORTED:
        raise CommandRefused(f"go to item {seq}", result, words)
    step: Step = Ask(SetCurrent(seq))
    while True:
        try:
            heard = yield step
        except NoAnswer:
            raise NoAnswer(f"the vehicle did not go to item {seq}: is there one?", code="no-such-item") from None
        step = None
        if isinstance(heard, Current) and heard.seq == seq:
            return


def stream(name: str, interval_s: float) -> Dialogue[bool]:
    """Ask for a message every so often; whether the vehicle will do so."""
    result, _ = yield from command(VehicleCommand.SET_MESSAGE_INTERVAL, message_number(name), round(interval_s * 1e6))
    return result == CommandResult.ACCEPTED


def _requested(name: str, kind: type[M], pause_s: float, askings: int = ASKINGS) -> Dialogue[M | None]:
    """A message that the vehicle is asked for; None where it will not send it, or does not although it would.

    It is asked so often before that is believed: what is heard may be the answer to an earlier request.
    """
    request = CommandLong(VehicleCommand.REQUEST_MESSAGE, (float(message_number(name)), 0.0, 0.0, 0.0, 0.0, 0.0, 0.0))
    step: Step = Ask(request)
    has_answered = False
    while True:
        try:
            heard = yield step
        except NoAnswer:
            if has_answered:
                return None
            raise
        step = None
        match heard:
            case CommandAck(VehicleCommand.REQUEST_MESSAGE, result):
                has_answered = True
                step = Pause(pause_s if result == CommandResult.ACCEPTED else REFUSED_S)
            case None:
                askings -= 1
                if askings == 0:
                    return None
                step = Ask(request)
            case _ if isinstance(heard, kind):
                return heard


def home() -> Dialogue[Geodetic | None]:
    """Where the vehicle's home is; None while it does not know."""
    at = yield from _requested("HOME_POSITION", HomePosition, 2.0)
    return None if at is None else Geodetic(at.latitude_deg, at.longitude_deg, at.altitude)


def clock() -> Dialogue[SystemTime | None]:
    """What the autopilot's clocks say; None where it does not tell."""
    return (yield from _requested("SYSTEM_TIME", SystemTime, 1.0, askings=2))


def about() -> Dialogue[AutopilotVersion | None]:
    """What the autopilot says of itself: its version, and what it can do; None where it does not say."""
    try:
        return (yield from _requested("AUTOPILOT_VERSION", AutopilotVersion, 1.0, askings=2))
    except NoAnswer:
        return None


def parameters(wanted: Sequence[Sequence[str]], autopilot: Autopilot) -> Dialogue[Mapping[str, ParamValue]]:
    """The vehicle's values; each of `wanted` is one parameter by all its names, of which the first known will do.

    What the vehicle does not answer to is left out: a name that it does not have meets with silence. So each time one
    that it surely has is asked for behind the others; once these were answered often enough, the others are not there.

    Raises:
        NoAnswer: it answers to none.
    """
    values: dict[str, ParamValue] = {}
    told = 0

    def missing() -> list[Sequence[str]]:
        return [names for names in wanted if not any(name in values for name in names)]

    for n in range(PARAMETER_ROUNDS + SLOW_ROUNDS):
        if not missing() or told == SURE or (n >= PARAMETER_ROUNDS and (values or told)):
            break
        known = autopilot.book.surely_there[
            n % len(autopilot.book.surely_there)
        ]  # not the same twice running: that would be heard as an echo
        for name in (*(name for names in missing() for name in names), *known):
            yield Remark(ParamRequestRead(name))
        heard = yield Pause(PARAMETER_ROUND_S if n < PARAMETER_ROUNDS else SLOW_ROUND_S)
        while heard is not None:
            if isinstance(heard, ParamValue):
                values[heard.param_id] = replace(heard, param_value=parameter_value(heard, autopilot))
                told += (is_known := any(heard.param_id in names for names in autopilot.book.surely_there))
                if is_known or not missing():
                    break
            heard = yield None
    found = {name: values[name] for names in wanted for name in names if name in values}
    if wanted and not found and not told:
        raise NoAnswer(f"the vehicle does not answer when asked for {wanted[0][0]}")
    return found


def set_parameter(name: str, value: float, autopilot: Autopilot) -> Dialogue[None]:
    """Give a parameter another value, in the type that the vehicle has it in, and see that it took it.

    What is heard first may be the late answer to a question from before: only what it keeps to the end is told.

    Raises:
        NoAnswer: there is no such parameter, or nothing is heard of it any more.
        BadInput: its type has no such value.
        MissionError: it keeps another value.
    """
    found = yield from parameters([(name,)], autopilot)
    if name not in found:
        raise NoAnswer(f"the vehicle has no parameter {name}", code="unknown-parameter")
    kind = found[name].param_type
    try:
        order = ParamSet(name, spelled_parameter(value, kind, autopilot), kind)
    except BadInput as error:
        raise error.at(name) from None
    kept: float | None = None
    for seconds in SETTING_S:
        yield Remark(order)
        heard = yield Pause(seconds)
        while heard is not None:
            if isinstance(heard, ParamValue) and heard.param_id == name:
                kept = parameter_value(heard, autopilot)
                if abs(kept - value) <= 1e-6 * max(1.0, abs(value)):
                    return
            heard = yield None
    if kept is None:
        raise NoAnswer(f"the vehicle does not answer when {name} is to be {value:g}")
    raise MissionError(f"the vehicle was to have {value:g}, and keeps {kept:g}", code="parameter-kept", place=name)


def parameter_value(heard: ParamValue, autopilot: Autopilot) -> float:
    """The value that was told: some send the bits of a whole number in the place of a float's."""
    if heard.param_type not in INT_TYPES or not autopilot.book.packs_integers:
        return heard.param_value
    return float(struct.unpack("<i", struct.pack("<f", heard.param_value))[0])


def spelled_parameter(value: float, kind: int, autopilot: Autopilot) -> float:
    """The inverse of `parameter_value`, for a parameter of this type.

    Raises:
        BadInput: it is no whole number that the type has.
    """
    if kind not in INT_TYPES or not autopilot.book.packs_integers:
        return value
    if not abs(value) < 2**31:
        raise BadInput(f"expected a value of 32 bits, not {value:g}")
    return float(struct.unpack("<f", struct.pack("<i", round(value)))[0])
