"""Dialogues for commands, messages on request, and parameters."""

import struct
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import TypeVar

from ipoa_mission.autopilot.autopilot import Autopilot
from ipoa_mission.autopilot.commands import VehicleCommand
from ipoa_mission.errors import BadInput, MissionError
from ipoa_mission.geodesy import Geodetic
from ipoa_mission.link import messages as m
from ipoa_mission.link.conversations import listen_for_words
from ipoa_mission.link.definitions import definition_of
from ipoa_mission.link.dialogue import Ask, Dialogue, NoAnswer, Pause, SendOnce, hear
from ipoa_mission.link.vehicle_words import VehicleTexts

M = TypeVar("M", bound=m.Message)

FILE_TRANSFER = 32  # MAV_PROTOCOL_CAPABILITY_FTP
STREAMS_S = {  # [s]; ArduPilot sends none unasked
    "HEARTBEAT": 0.1,
    "GLOBAL_POSITION_INT": 0.05,
    "MISSION_CURRENT": 0.1,
    "SYS_STATUS": 0.5,
    "EXTENDED_SYS_STATE": 0.2,
}
PARAMETER_ROUND_S = 0.7
PARAMETER_BATCH = 8  # of two names at most
ABSENCE_CHANCE = 2e-4  # of an existing parameter, by an estimated loss


class CommandRefused(MissionError, code="command-refused"):
    def __init__(self, action: str, result: int, words: str = "") -> None:
        self.result = result
        self.words = words
        name = m.CommandResult(result).name if result in set(m.CommandResult) else str(result)
        super().__init__(f"{action}: the vehicle answered {name}" + (f": {words}" if words else ""))


def command_long(number: int, *params: float) -> m.CommandLong:
    return m.CommandLong(number, (*params, *(0.0,) * (7 - len(params))))  # type: ignore[arg-type]


def message_request(name: str) -> m.CommandLong:
    return command_long(VehicleCommand.REQUEST_MESSAGE, float(definition_of(name).number))


def mode_order(mode: int, autopilot: Autopilot) -> m.CommandLong:
    return command_long(VehicleCommand.DO_SET_MODE, m.CUSTOM_MODE_FLAG, *autopilot.modes.numbers(mode))


def send(number: int, *params: float, check: Callable[[], None] = lambda: None) -> Dialogue[tuple[int, str]]:
    return send_command(command_long(number, *params), check)


def send_command(message: m.CommandLong, check: Callable[[], None] = lambda: None) -> Dialogue[tuple[int, str]]:
    """Return the CommandResult, and the vehicle's words about a refusal; an error of `check` ends it."""
    texts = VehicleTexts()

    def answer_in(heard: m.Message) -> m.CommandAck | None:
        check()
        texts.note(heard)
        return heard if isinstance(heard, m.CommandAck) and heard.command == message.command else None

    answer = yield from hear(Ask(message), answer_in)
    while answer is not None and answer.result == m.CommandResult.IN_PROGRESS:
        answer = yield from hear(Pause(30.0), answer_in)
    if answer is None:
        raise NoAnswer(f"command {message.command} was begun, but never ended", code="command-not-ended")
    if answer.result != m.CommandResult.ACCEPTED:
        yield from listen_for_words(texts)
    return answer.result, str(texts)


def set_current(seq: int, seq_offset: int, restart: bool = False) -> Dialogue[None]:
    """By command 224, or the older message (PX4); `seq_offset`: 1 if home is item 0; `restart` resets jump counters."""
    result, words = yield from send(VehicleCommand.DO_SET_MISSION_CURRENT, float(seq), float(restart))
    if result == m.CommandResult.ACCEPTED:
        return
    if result != m.CommandResult.UNSUPPORTED:
        raise CommandRefused(f"go to item {seq + 1 - seq_offset}", result, words)
    try:
        yield from hear(Ask(m.SetCurrent(seq)), lambda heard: isinstance(heard, m.Current) and heard.seq == seq)
    except NoAnswer:
        raise NoAnswer(f"the vehicle did not go to item {seq + 1 - seq_offset}", code="no-such-item") from None


def stream_order(name: str, interval_s: float) -> m.CommandLong:
    return command_long(VehicleCommand.SET_MESSAGE_INTERVAL, definition_of(name).number, round(interval_s * 1e6))


def request_stream(name: str, interval_s: float) -> Dialogue[bool]:
    result, _ = yield from send_command(stream_order(name, interval_s))
    return result == m.CommandResult.ACCEPTED


def _request(name: str, kind: type[M], pause_s: float, requests: int = 5) -> Dialogue[M | None]:
    """Return None if it is refused; repeat, because an answer may belong to an earlier request."""

    def answer_in(heard: m.Message) -> m.Message | None:
        if isinstance(heard, m.CommandAck):
            return heard if heard.command == VehicleCommand.REQUEST_MESSAGE else None
        return heard if isinstance(heard, kind) else None

    has_answered = False
    for _ in range(requests):
        try:
            heard = yield from hear(Ask(message_request(name)), answer_in)
        except NoAnswer:
            if has_answered:
                return None
            raise
        while isinstance(heard, m.CommandAck):
            has_answered = True
            heard = yield from hear(Pause(pause_s if heard.result == m.CommandResult.ACCEPTED else 0.3), answer_in)
        if isinstance(heard, kind):
            return heard
    return None


def request_home() -> Dialogue[Geodetic | None]:
    home = yield from _request("HOME_POSITION", m.HomePosition, 2.0)
    return None if home is None else Geodetic(home.latitude_deg, home.longitude_deg, home.altitude)


def request_clock() -> Dialogue[m.SystemTime | None]:
    return (yield from _request("SYSTEM_TIME", m.SystemTime, 1.0, requests=2))


def request_version() -> Dialogue[m.AutopilotVersion | None]:
    try:
        return (yield from _request("AUTOPILOT_VERSION", m.AutopilotVersion, 1.0, requests=2))
    except NoAnswer:
        return None


def request_parameters(wanted: Sequence[Sequence[str]], autopilot: Autopilot) -> Dialogue[Mapping[str, m.ParamValue]]:
    """Return values by any name of each entry; raise NoAnswer.

    An unknown parameter is met with silence: an existing one ends each batch and estimates the link's loss. ArduPilot
    drops requests beyond 20.
    """
    values: dict[str, m.ParamValue] = {}
    requests = proofs = 0

    def missing() -> list[Sequence[str]]:
        return [names for names in wanted if not any(name in values for name in names)]

    for n, seconds in enumerate([PARAMETER_ROUND_S] * 6 + [2.0] * 14):
        lost = 1.0 - (proofs + 1) / (requests + 2)
        if not missing() or lost**n < ABSENCE_CHANCE or (n == 11 and not (values or proofs)):
            break
        unanswered = missing()
        for batch in (unanswered[at : at + PARAMETER_BATCH] for at in range(0, len(unanswered), PARAMETER_BATCH)):
            existing = autopilot.parameter_table.surely_there
            known = existing[requests % len(existing)]  # twice in a row would count as an echo
            requests += 1
            for name in (*(name for names in batch for name in names), *known):
                yield SendOnce(m.ParamRequestRead(name))
            heard = yield Pause(seconds)
            while heard is not None:
                if isinstance(heard, m.ParamValue):
                    values[heard.param_id] = replace(heard, param_value=parameter_value(heard, autopilot))
                    if heard.param_id in known:
                        proofs += 1
                        break
                heard = yield None
    reported = {name: values[name] for names in wanted for name in names if name in values}
    if wanted and not reported and not proofs:
        raise NoAnswer(f"the vehicle does not answer when asked for {wanted[0][0]}")
    return reported


def set_parameter(name: str, value: float, autopilot: Autopilot) -> Dialogue[None]:
    """Verify by the last value heard; raise NoAnswer (unknown), BadInput (type) or MissionError (not kept)."""
    reported = yield from request_parameters([(name,)], autopilot)
    if name not in reported:
        raise NoAnswer(f"the vehicle has no parameter {name}", code="unknown-parameter")
    kind = reported[name].param_type
    try:
        order = m.ParamSet(name, spelled_parameter(value, kind, autopilot), kind)
    except BadInput as error:
        raise error.at(name) from None
    stored: float | None = None

    def is_stored(heard: m.Message) -> bool:
        nonlocal stored
        if not isinstance(heard, m.ParamValue) or heard.param_id != name:
            return False
        stored = parameter_value(heard, autopilot)
        return abs(stored - value) <= 1e-6 * max(1.0, abs(value))

    for seconds in (1.0, 2.0, 4.0):
        yield SendOnce(order)
        if (yield from hear(Pause(seconds), is_stored)):
            return
    if stored is None:
        raise NoAnswer(f"the vehicle does not answer when {name} is set to {value:g}")
    raise MissionError(f"expected {value:g}, but the vehicle keeps {stored:g}", code="parameter-kept", place=name)


def parameter_value(heard: m.ParamValue, autopilot: Autopilot) -> float:
    """Decode a value: some autopilots send an integer's bits as a float."""
    if not _is_packed(heard.param_type, autopilot):
        return heard.param_value
    return float(struct.unpack("<i", struct.pack("<f", heard.param_value))[0])


def spelled_parameter(value: float, kind: int, autopilot: Autopilot) -> float:
    """Raise BadInput if the type has no such value."""
    if not _is_packed(kind, autopilot):
        return value
    if not abs(value) < 2**31:
        raise BadInput(f"expected a value of 32 bits, not {value:g}")
    return float(struct.unpack("<f", struct.pack("<i", round(value)))[0])


def _is_packed(kind: int, autopilot: Autopilot) -> bool:
    """Return whether integers of this MAV_PARAM_TYPE, of up to 32 bits, are sent bit by bit."""
    return 1 <= kind <= 6 and autopilot.parameter_table.packs_integers
