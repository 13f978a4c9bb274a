"""Start a mission from the ground at a known item; a refusal after arming disarms it, unless it may be in the air."""

import math
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass

from ipoa_mission.autopilot.commands import Command, VehicleCommand
from ipoa_mission.errors import MissionError
from ipoa_mission.geodesy import Geodetic
from ipoa_mission.link.dialogue import Cancelled, Dialogue, NoAnswer, SendOnce, TimeUp, until, wait
from ipoa_mission.link.flight_order import SHOWN_S, change_mode
from ipoa_mission.link.messages import CommandLong, CommandResult, Current, Position, SystemStatus
from ipoa_mission.link.onboard_list import OnboardList, expect_unchanged, prove
from ipoa_mission.link.orders import STREAMS_S, CommandRefused, request_stream, send, set_current
from ipoa_mission.link.vehicle_state import ON_GROUND, NotFlown, NotReady, VehicleState
from ipoa_mission.progress import Progress, silent

NEEDED_STREAMS = {"GLOBAL_POSITION_INT": Position, "MISSION_CURRENT": Current, "SYS_STATUS": SystemStatus}


class NotYet(CommandRefused, code="not-yet"):
    """Not armed, for reasons that pass with time."""


@dataclass(frozen=True)
class Departure:
    STREAM_S = 4.0
    STREAM_REQUESTS = 3  # an answer may belong to an earlier request
    READY_S = 180.0
    CHECK_S = 3.0  # per readiness check
    RETRY_S = 1.0
    ARMING_ATTEMPTS = 5
    DISARM_ATTEMPTS = 3
    CLIMB_S = 120.0
    CLIMBED_BELOW = 0.5  # the requested height [m]
    PREPARED_S = 60.0  # before a set time
    LATE_S = 3.0  # three deviations of a departure in `deconflict`

    state: VehicleState
    first: int
    moving: int  # the first moving item: ArduPilot soon reports it
    climb: float = 0.0  # height of an ArduPilot before a first item that is no take-off [m]
    onboard_lists: tuple[OnboardList, ...] = ()
    progress: Progress = silent
    permit: Callable[[Geodetic], object] | None = None
    left_s: Callable[[], float] = lambda: math.inf  # in which it may be armed

    def expect_in_time(self) -> None:
        if self.left_s() < 0.0:
            words = f"the vehicle is not armed within {self.LATE_S:g} s of its departure time"
            raise NotReady(words, hint="set a later time", code="departure-missed")

    def expect_permitted(self) -> None:
        at = self.state.position
        if self.permit is not None and at is not None:
            self.permit(Geodetic(at.latitude_deg, at.longitude_deg, at.altitude))


def subscribe(state: VehicleState) -> Dialogue[None]:
    unheard = list(STREAMS_S)
    refused = set[str]()
    state.heard -= set(NEEDED_STREAMS.values())
    for _ in range(Departure.STREAM_REQUESTS):
        for name in unheard:
            is_refused = not (yield from request_stream(name, STREAMS_S[name]))
            refused = refused | {name} if is_refused else refused - {name}
        if (yield from until(lambda: state.heard >= set(NEEDED_STREAMS.values()), Departure.STREAM_S)):
            return
        unheard = [name for name, kind in NEEDED_STREAMS.items() if kind not in state.heard]
    refusal = f"; it refused to send {', '.join(name for name in unheard if name in refused)}" if refused else ""
    words = f"the vehicle does not send {', '.join(unheard)}{refusal}"
    raise NotReady(words, hint="a flight is not watched without it", code="streams-missing")


def unsubscribe() -> Dialogue[None]:
    for name in STREAMS_S:
        yield from request_stream(name, 0.0)


def prepare(departure: Departure, ready_s: float = Departure.READY_S) -> Dialogue[None]:
    """Raise as `Vehicle.prepare`."""
    state = departure.state
    yield from until(lambda: state.armed is not None and state.custom_mode is not None, SHOWN_S)
    state.expect_flown()
    state.expect_on_ground()
    yield from subscribe(state)
    yield from _set_first(departure)
    yield from _await_ready(departure, ready_s)
    state.expect_on_ground()
    yield from _set_first(departure)


def _await_ready(departure: Departure, ready_s: float) -> Dialogue[None]:
    state = departure.state
    mode = state.autopilot.modes.arming
    waited_s = 0.0
    reason = ""
    try:
        while True:
            state.warnings.words.clear()
            if state.custom_mode != mode or state.replaced_mode is None:
                runs = state.custom_mode in (None, state.autopilot.modes.mission)
                state.replaced_mode = state.autopilot.modes.hold if runs else state.custom_mode
            reason = (yield from change_mode(state, mode)) or reason
            if state.custom_mode == mode:
                if (yield from until(lambda: state.may_arm is not False and _has_position(state), Departure.CHECK_S)):
                    return
                yield from send(VehicleCommand.RUN_PREARM_CHECKS)
                yield from wait(Departure.RETRY_S)
                reason = _not_ready_reason(state)
                lasting = state.autopilot.protocol_profile.arming_words.lasting(reason)
                if lasting:
                    words = f"the vehicle cannot be armed: {'; '.join(lasting)}"
                    raise NotReady(words, hint=str(state), code="arming-refused")
            else:
                yield from wait(Departure.RETRY_S)
            waited_s += Departure.CHECK_S + Departure.RETRY_S
            departure.progress(0.0, reason)
            if waited_s > ready_s:
                raise NotReady(f"the vehicle is not ready after {waited_s:.0f} s: {reason}", hint=str(state))
    except TimeUp as late:
        why = reason or _not_ready_reason(state)
        raise TimeUp(f"{late}: the vehicle is not ready: {why}", hint=str(state)) from None


@contextmanager
def restored_mode(state: VehicleState, tell: Callable[[Dialogue[None]], None]) -> Iterator[None]:
    try:
        yield
    except (MissionError, KeyboardInterrupt) as error:
        before = str(state)
        left = "" if isinstance(error, NotFlown) else _mode_left(state, tell)
        failed = error if isinstance(error, MissionError) else Cancelled("cancelled")
        if failed.hint == before:
            failed.hint = str(state)
        if not left:
            raise
        failed.args = (f"{failed.args[0]}; {left}",)
        failed.known["mode_left"] = left
        raise failed from None


def _mode_left(state: VehicleState, tell: Callable[[Dialogue[None]], None]) -> str:
    modes = state.autopilot.modes
    if state.replaced_mode is None or state.armed is not False:
        return ""
    with suppress(MissionError):
        tell(restore_mode(state, state.replaced_mode))
    mode = modes.arming if state.custom_mode is None else state.custom_mode
    if mode not in {modes.arming, modes.mission} - {state.replaced_mode}:
        state.replaced_mode = None
        return ""
    return f"it is in {modes.name(mode)}" + (": it takes off when armed" if mode == modes.mission else "")


def restore_mode(state: VehicleState, mode: int) -> Dialogue[None]:
    for wanted in (mode, state.autopilot.modes.hold):
        if state.armed is False:
            state.custom_mode = None  # may be older than our order
            if not (yield from change_mode(state, wanted)):
                return


def _not_ready_reason(state: VehicleState) -> str:
    if state.warnings.words:
        return str(state.warnings)
    return "its pre-arm checks do not pass, without a reason" if _has_position(state) else "it has no position"


def count_down(progress: Progress, left_s: Callable[[], float], until_s: float) -> Dialogue[None]:
    """Wait until `left_s` before the departure falls to `until_s` [s]."""
    while left_s() > until_s:
        progress(0.0, f"departure in {left_s():.0f} s")
        yield from wait(min(1.0, left_s() - until_s))


def depart_when_ready(departure: Departure, left_s: Callable[[], float]) -> Dialogue[None]:
    """Run `depart`; after a temporary refusal begin again while `left_s` is positive [s]."""
    while True:
        try:
            return (yield from depart(departure))
        except NotYet as refused:
            departure.progress(0.0, f"not armed yet: {refused.words}")
            if left_s() <= 0.0:
                raise NotReady(f"the vehicle is not ready in time: {refused.words}", hint=refused.hint) from None
        yield from prepare(departure, left_s())
        departure.expect_permitted()


def depart(departure: Departure) -> Dialogue[None]:
    """Arm a prepared vehicle that provably holds our lists; start its mission. Raise as `Vehicle.start`, or NotYet."""
    state = departure.state
    reasons = state.autopilot.protocol_profile.arming_words
    may_be_armed = False
    attempt = 0
    try:
        while True:
            attempt += 1
            state.expect_flown()
            yield from prove(departure.onboard_lists, state)
            departure.expect_in_time()
            may_be_armed = True
            state.warnings.words.clear()
            result, words = yield from send(Command.COMPONENT_ARM_DISARM, 1.0)
            if result == CommandResult.ACCEPTED:
                break
            has_reason = bool(reasons.reasons(words))
            is_last = has_reason or attempt == Departure.ARMING_ATTEMPTS
            if (yield from until(lambda: state.armed is True, SHOWN_S if is_last else Departure.RETRY_S)):
                break  # the refusal was of an earlier order
            may_be_armed = False
            if is_last:
                raise (NotYet if has_reason and not reasons.lasting(words) else CommandRefused)("arm", result, words)
        yield from _begin(departure)
    except MissionError as aborted:
        if may_be_armed:
            yield from _disarm_on_ground(state)
        aborted.hint = str(state)
        raise


def _begin(departure: Departure) -> Dialogue[None]:
    state = departure.state
    if state.autopilot.protocol_profile.starts_by_command:
        departure.expect_in_time()  # an armed PX4 takes off, and is watched
        if departure.climb > 0.0:
            yield from _order("take off", Command.NAV_TAKEOFF, *(0.0,) * 6, departure.climb)
            least = departure.climb - Departure.CLIMBED_BELOW
            yield from until(lambda: state.position is not None and state.position.height > least, Departure.CLIMB_S)
        state.current = None  # count only reports after the arming
        yield from until(lambda: state.current is not None, Departure.RETRY_S)
        expect_unchanged(departure.onboard_lists)
        yield from _order("start the mission", VehicleCommand.MISSION_START)
    mode = state.autopilot.modes.mission
    if not (yield from until(lambda: state.armed is True and state.custom_mode == mode, SHOWN_S)):
        says = f"; it says: {state.warnings}" if state.warnings.words else ""
        raise NotReady(f"the vehicle did not begin its mission: {state}{says}", code="mission-not-begun")


def _set_first(departure: Departure) -> Dialogue[None]:
    state = departure.state
    first = departure.first
    seq_offset = state.autopilot.seq_offset
    state.current = None
    yield from set_current(first, seq_offset, restart=True)
    begins = range(first, departure.moving + 1)
    if not (yield from until(lambda: state.current is not None and state.current.seq in begins, SHOWN_S)):
        reported = "no item" if state.current is None else f"item {state.current.seq + 1 - seq_offset}"
        words = f"the mission was set to begin at item {first + 1 - seq_offset}, but the vehicle reports {reported}"
        raise NotReady(words, code="other-item-current")


def _has_position(state: VehicleState) -> bool:
    position = state.position
    return position is not None and (position.latitude_deg, position.longitude_deg) != (0.0, 0.0)


def _order(action: str, number: int, *params: float) -> Dialogue[None]:
    result, words = yield from send(number, *params)
    if result != CommandResult.ACCEPTED:
        raise CommandRefused(action, result, words)


def _disarm_on_ground(state: VehicleState) -> Dialogue[None]:
    """Disarm a vehicle only if it newly reports to be on the ground."""
    try:
        for attempt in range(Departure.DISARM_ATTEMPTS):
            if attempt > 0 and (yield from until(lambda: state.armed is False, SHOWN_S)):
                return
            state.landed_state = None
            yield from until(lambda: state.landed_state is not None, SHOWN_S)
            if state.landed_state != ON_GROUND:
                return
            yield SendOnce(CommandLong(Command.COMPONENT_ARM_DISARM))
            state.armed = None
        yield from until(lambda: state.armed is not None, SHOWN_S)
    except (NoAnswer, Cancelled, TimeUp):
        return
