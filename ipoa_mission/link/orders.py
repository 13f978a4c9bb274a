"""What one tells a vehicle besides a mission: commands, the current item, arming, starting, parameters."""

import struct
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TypeVar

from ipoa_mission.autopilots.vehicle import Autopilot
from ipoa_mission.commands import Order
from ipoa_mission.errors import MissionError
from ipoa_mission.link.conversations import VehicleTexts, listen_for_words
from ipoa_mission.link.definitions import message_number
from ipoa_mission.link.dialogue import Ask, Dialogue, NoAnswer, Pause, Remark, Step, Tell
from ipoa_mission.link.messages import (
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
from ipoa_mission.link.telemetry import AutopilotVersion, HomePosition
from ipoa_mission.world.frame import Geodetic

M = TypeVar("M", bound=Message)

#: MAV_PROTOCOL_CAPABILITY_FTP.
FILE_TRANSFER = 32
#: MAV_PARAM_TYPE of whole numbers, which PX4 sends bit by bit.
INT_TYPES = frozenset({1, 2, 3, 4, 5, 6})
#: A parameter that does not exist is met with silence: how often one asks, and how long one listens each time [s].
PARAMETER_ROUNDS, PARAMETER_ROUND_S = 6, 0.7


class CommandRefused(MissionError):
    """The vehicle would not do what it was told; the message has its words."""

    def __init__(self, what: str, result: int, words: str = "") -> None:
        self.what, self.result = what, result
        name = CommandResult(result).name if result in set(CommandResult) else str(result)
        super().__init__(f"{what}: the vehicle answered {name}" + (f": {words}" if words else ""))


def command(number: int, *params: float) -> Dialogue[tuple[int, str]]:
    """Give a COMMAND_LONG; its result and the words that came with it."""
    seven = (*params, *(0.0,) * (7 - len(params)))
    texts = VehicleTexts()
    step: Step = Ask(CommandLong(number, seven))  # type: ignore[arg-type]
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
                raise NoAnswer(f"command {number} was begun, but never ended")
            case _:
                texts.note(heard)


def set_current(seq: int, restart: bool = False) -> Dialogue[None]:
    """Go on with the item at `seq`: by command 224, or by the older message where that is unknown (PX4).

    `restart`: jumps are counted anew, and a mission that was complete is no more.

    Raises:
        CommandRefused: there is no such item.
        NoAnswer: nothing shows that the vehicle took it.
    """
    result, words = yield from command(Order.DO_SET_MISSION_CURRENT, float(seq), float(restart))
    if result == CommandResult.ACCEPTED:
        return
    if result != CommandResult.UNSUPPORTED:
        raise CommandRefused(f"go to item {seq}", result, words)
    step: Step = Ask(SetCurrent(seq))
    while True:
        try:
            heard = yield step
        except NoAnswer:
            raise NoAnswer(f"the vehicle did not go to item {seq}: is there one?") from None
        step = None
        if isinstance(heard, Current) and heard.seq == seq:
            return


def stream(name: str, interval_s: float) -> Dialogue[bool]:
    """Ask for a message every so often; whether the vehicle will do so."""
    result, _ = yield from command(Order.SET_MESSAGE_INTERVAL, message_number(name), round(interval_s * 1e6))
    return result == CommandResult.ACCEPTED


def _requested(name: str, kind: type[M], pause_s: float, again: bool) -> Dialogue[M | None]:
    """A message that the vehicle is asked for; None where it will not send it, or does not although it would.

    `again`: where it accepts to send it, and in `pause_s` does not, it is asked once more.
    """
    request = CommandLong(Order.REQUEST_MESSAGE, (float(message_number(name)), 0.0, 0.0, 0.0, 0.0, 0.0, 0.0))
    step: Step = Ask(request)
    while True:
        heard = yield step
        step = None
        match heard:
            case CommandAck(Order.REQUEST_MESSAGE, CommandResult.ACCEPTED):
                step = Pause(pause_s)
            case CommandAck(Order.REQUEST_MESSAGE):
                return None
            case None if again:
                step = Tell(request)
            case None:
                return None
            case _ if isinstance(heard, kind):
                return heard


def home() -> Dialogue[Geodetic | None]:
    """Where the vehicle's home is; None while it does not know."""
    at = yield from _requested("HOME_POSITION", HomePosition, 2.0, again=True)
    return None if at is None else Geodetic(at.latitude_deg, at.longitude_deg, at.altitude)


def about() -> Dialogue[AutopilotVersion]:
    """What the autopilot says that it is and can do; zeros where it does not say."""
    try:
        version = yield from _requested("AUTOPILOT_VERSION", AutopilotVersion, 1.0, again=False)
    except NoAnswer:
        version = None
    return AutopilotVersion(0) if version is None else version


def parameters(wanted: Sequence[Sequence[str]], autopilot: Autopilot) -> Dialogue[Mapping[str, ParamValue]]:
    """The vehicle's values; each of `wanted` is one parameter by all its names, of which the first known will do.

    What the vehicle does not answer to is left out: a name that it does not have meets with silence.

    Raises:
        NoAnswer: it answers to none.
    """
    values: dict[str, ParamValue] = {}
    for _ in range(PARAMETER_ROUNDS):
        missing = [names for names in wanted if not any(name in values for name in names)]
        if not missing:
            break
        for names in missing:
            for name in names:
                yield Remark(ParamRequestRead(name))
        heard = yield Pause(PARAMETER_ROUND_S)
        while heard is not None:
            if isinstance(heard, ParamValue):
                values[heard.param_id] = replace(heard, param_value=parameter_value(heard, autopilot))
                if all(any(name in values for name in names) for names in missing):
                    break
            heard = yield None
    if wanted and not values:
        raise NoAnswer(f"the vehicle does not answer when asked for {wanted[0][0]}")
    return {name: values[name] for names in wanted for name in names if name in values}


def set_parameter(name: str, value: float, autopilot: Autopilot) -> Dialogue[None]:
    """Give a parameter another value, in the type that the vehicle has it in, and see that it took it.

    Raises:
        NoAnswer: there is no such parameter.
        MissionError: it keeps another value.
    """
    kind = (yield from parameters([(name,)], autopilot))[name].param_type
    step: Step = Ask(ParamSet(name, spelled_parameter(value, kind, autopilot), kind))
    while True:
        heard = yield step
        step = None
        match heard:
            case ParamValue(told) if told == name:
                if abs((now := parameter_value(heard, autopilot)) - value) > 1e-6 * max(1.0, abs(value)):
                    raise MissionError(f"{name}: the vehicle was to have {value:g}, and keeps {now:g}")
                return


def parameter_value(heard: ParamValue, autopilot: Autopilot) -> float:
    """The value that was told: PX4 sends the bits of a whole number in the place of a float's."""
    if heard.param_type not in INT_TYPES or autopilot is not Autopilot.PX4:
        return heard.param_value
    return float(struct.unpack("<i", struct.pack("<f", heard.param_value))[0])


def spelled_parameter(value: float, kind: int, autopilot: Autopilot) -> float:
    """The inverse of `parameter_value`, for a parameter of this type."""
    if kind not in INT_TYPES or autopilot is not Autopilot.PX4:
        return value
    return float(struct.unpack("<f", struct.pack("<i", round(value)))[0])
