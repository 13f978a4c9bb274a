"""What one tells a vehicle besides a mission: commands, the current item, arming, starting, parameters."""

import struct
from collections.abc import Iterable, Mapping

from ipoa_mission.errors import MissionError
from ipoa_mission.link.codec import message_number
from ipoa_mission.link.conversations import Overheard
from ipoa_mission.link.dialogue import Ask, Dialogue, NoAnswer, Pause, Step, Tell
from ipoa_mission.link.messages import (
    CUSTOM_MODE_FLAG,
    AutopilotVersion,
    CommandAck,
    CommandLong,
    CommandResult,
    Current,
    HomePosition,
    ParamRequestRead,
    ParamValue,
    SetCurrent,
)
from ipoa_mission.vehicle import Autopilot
from ipoa_mission.world.frame import Geodetic

DO_SET_MODE = 176
DO_SET_MISSION_CURRENT = 224
MISSION_START = 300
COMPONENT_ARM_DISARM = 400
SET_MESSAGE_INTERVAL = 511
REQUEST_MESSAGE = 512

#: What custom_mode is while a mission is flown: ArduCopter's AUTO; PX4's main mode AUTO (4) with sub mode MISSION (4).
ARDUCOPTER_AUTO = 3
PX4_AUTO_MISSION = (4, 4)
#: MAV_PROTOCOL_CAPABILITY_FTP.
FILE_TRANSFER = 32
#: MAV_PARAM_TYPE of whole numbers, which PX4 sends bit by bit.
INT_TYPES = frozenset({1, 2, 3, 4, 5, 6})
#: An autopilot may need this long after its start before it lets itself be armed (ArduPilot: about 45 s).
ARMING_S = 60


class CommandRefused(MissionError):
    """The vehicle would not do what it was told; the message has its words."""

    def __init__(self, what: str, result: int, words: str = "") -> None:
        self.result = result
        name = CommandResult(result).name if result in set(CommandResult) else str(result)
        super().__init__(f"{what}: the vehicle answered {name}" + (f": {words}" if words else ""))


def mission_custom_mode(autopilot: Autopilot) -> int:
    """HEARTBEAT.custom_mode of a vehicle that flies its mission."""
    main, sub = PX4_AUTO_MISSION
    return ARDUCOPTER_AUTO if autopilot is Autopilot.ARDUPILOT else main << 16 | sub << 24


def command(number: int, *params: float) -> Dialogue[tuple[int, str]]:
    """Give a COMMAND_LONG; its result and the words that came with it."""
    seven = (*params, *(0.0,) * (7 - len(params)))
    overheard = Overheard()
    step: Step = Ask(CommandLong(number, seven))  # type: ignore[arg-type]
    while True:
        heard = yield step
        step = None
        match heard:
            case CommandAck(n, CommandResult.IN_PROGRESS) if n == number:
                step = Pause(30.0)
            case CommandAck(n, result) if n == number:
                if result != CommandResult.ACCEPTED:
                    heard = yield Pause(0.3)
                    while heard is not None:
                        overheard.note(heard)
                        heard = yield None
                return result, str(overheard)
            case None:
                raise NoAnswer(f"command {number} was begun, but never ended")
            case _:
                overheard.note(heard)


def arm(attempts: int = ARMING_S) -> Dialogue[None]:
    """Let the motors run; a vehicle that is still starting up is asked once a second.

    Raises:
        CommandRefused: it will not, and says why.
    """
    while True:
        attempts -= 1
        result, words = yield from command(COMPONENT_ARM_DISARM, 1.0)
        if result == CommandResult.ACCEPTED:
            return
        if attempts <= 0:
            raise CommandRefused("arm", result, words)
        heard = yield Pause(1.0)
        while heard is not None:
            heard = yield None


def start(autopilot: Autopilot) -> Dialogue[None]:
    """Fly the mission: the mission mode, and for ArduPilot MISSION_START.

    Raises:
        CommandRefused: it will not, and says why.
    """
    if autopilot is Autopilot.ARDUPILOT:
        result, words = yield from command(DO_SET_MODE, CUSTOM_MODE_FLAG, ARDUCOPTER_AUTO)
        if result == CommandResult.ACCEPTED:
            result, words = yield from command(MISSION_START)
    else:
        result, words = yield from command(DO_SET_MODE, CUSTOM_MODE_FLAG, *PX4_AUTO_MISSION)
    if result != CommandResult.ACCEPTED:
        raise CommandRefused("start the mission", result, words)


def set_current(seq: int) -> Dialogue[None]:
    """Go on with the item at `seq`: by command 224, or by the older message where that is unknown (PX4).

    Raises:
        CommandRefused: there is no such item.
        NoAnswer: nothing shows that the vehicle took it.
    """
    result, words = yield from command(DO_SET_MISSION_CURRENT, float(seq))
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
    result, _ = yield from command(SET_MESSAGE_INTERVAL, message_number(name), round(interval_s * 1e6))
    return result == CommandResult.ACCEPTED


def home() -> Dialogue[Geodetic | None]:
    """Where the vehicle's home is; None while it does not know."""
    request = CommandLong(REQUEST_MESSAGE, (float(message_number("HOME_POSITION")), 0.0, 0.0, 0.0, 0.0, 0.0, 0.0))
    step: Step = Ask(request)
    while True:
        heard = yield step
        step = None
        match heard:
            case HomePosition(latitude, longitude, altitude):
                return Geodetic(latitude, longitude, altitude)
            case CommandAck(n, result) if n == REQUEST_MESSAGE and result == CommandResult.ACCEPTED:
                step = Pause(2.0)
            case CommandAck(n) if n == REQUEST_MESSAGE:
                return None
            case None:
                step = Tell(request)


def capabilities() -> Dialogue[int]:
    """What the autopilot says that it can do: MAV_PROTOCOL_CAPABILITY; 0 where it does not say."""
    number = float(message_number("AUTOPILOT_VERSION"))
    step: Step = Ask(CommandLong(REQUEST_MESSAGE, (number, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)))
    while True:
        try:
            heard = yield step
        except NoAnswer:
            return 0
        step = None
        match heard:
            case AutopilotVersion(told):
                return told
            case CommandAck(n, CommandResult.ACCEPTED) if n == REQUEST_MESSAGE:
                step = Pause(1.0)
            case CommandAck(n) if n == REQUEST_MESSAGE:
                return 0
            case None:
                return 0


def parameters(names: Iterable[str], autopilot: Autopilot) -> Dialogue[Mapping[str, float]]:
    """The vehicle's values of these parameters; those that it does not have are left out."""
    found: dict[str, float] = {}
    for name in names:
        step: Step = Ask(ParamRequestRead(name))
        while name not in found:
            try:
                heard = yield step
            except NoAnswer:
                if not found:
                    raise
                break
            step = None
            match heard:
                case ParamValue(told, value, kind):
                    found[told] = _number(value, kind, autopilot)
    return {name: found[name] for name in names if name in found}


def _number(value: float, kind: int, autopilot: Autopilot) -> float:
    if kind not in INT_TYPES or autopilot is not Autopilot.PX4:
        return value
    return float(struct.unpack("<i", struct.pack("<f", value))[0])
