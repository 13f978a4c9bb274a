"""From standing on the ground to flying a mission from a known item: the order that each firmware wants.

Nothing turns before the vehicle tells that it stands disarmed, will begin at the right item, could be armed in the mode
in which it is armed, and holds the very lists that it was given; and what is refused after that disarms it again,
unless it may be in the air.
"""

from collections.abc import Callable
from dataclasses import dataclass

from ipoa_mission.errors import MissionError
from ipoa_mission.link.dialogue import Cancelled, Dialogue, NoAnswer, Remark, TimeUp, until, wait
from ipoa_mission.link.flight_order import SHOWN_S, change_mode
from ipoa_mission.link.messages import CommandLong, CommandResult, Current
from ipoa_mission.link.onboard_list import OnboardList, expect_unchanged, prove
from ipoa_mission.link.orders import CommandRefused, command, set_current, stream
from ipoa_mission.link.telemetry import Position, SystemStatus
from ipoa_mission.link.vehicle_state import ON_GROUND, NotReady, VehicleState
from ipoa_mission.mission.commands import Command, VehicleCommand
from ipoa_mission.progress import Progress, silent
from ipoa_mission.vehicles.autopilot import Autopilot

#: What a flight is watched by, and how often it is wanted [s]; ArduPilot sends none of it unasked.
STREAMS_S = {
    "HEARTBEAT": 0.1,
    "GLOBAL_POSITION_INT": 0.05,
    "MISSION_CURRENT": 0.1,
    "SYS_STATUS": 0.5,
    "EXTENDED_SYS_STATE": 0.2,
}
NEEDED = {"GLOBAL_POSITION_INT": Position, "MISSION_CURRENT": Current, "SYS_STATUS": SystemStatus}
ARMING = "arm"
DISARMINGS = 3
ASKINGS = 3  # for a stream that does not come: the answer heard may have been to an earlier request


@dataclass(frozen=True)
class DepartureLimits:
    """How long a vehicle is given for each step of its departure."""

    stream_s: float = 4.0  # until a stream that was asked for is heard
    ready_s: float = 180.0  # until it could be armed,
    look_s: float = 3.0  # with so long between two looks at what hinders
    again_s: float = 1.0  # before the next look, and between two attempts to arm
    arming_attempts: int = 5  # one that says it could be armed may still need a moment
    climb_s: float = 120.0  # until it has climbed
    climbed_below: float = 0.5  # to so far below the height that was asked for [m]


LIMITS = DepartureLimits()


class NotYet(CommandRefused):
    """It is not armed, and by its own words time will mend that; `words` are these."""

    def __init__(self, result: int, words: str) -> None:
        super().__init__(ARMING, result, words)
        self.words = words


@dataclass(frozen=True)
class Departure:
    """A flight about to begin at item `first` (as numbered on the wire); `progress` is told what is waited for.

    `moving`: the first item from there on that moves the vehicle, which ArduPilot calls current where others, done at
    once, stand before it. `climb`: how high an ArduPilot climbs before an item that is no take-off [m]; PX4 does that
    by itself. `holdings`: the lists that it was seen to hold.
    """

    state: VehicleState
    first: int
    moving: int
    climb: float = 0.0
    holdings: tuple[OnboardList, ...] = ()
    progress: Progress = silent

    @property
    def autopilot(self) -> Autopilot:
        """Which firmware it is."""
        return self.state.autopilot


def subscribe(state: VehicleState) -> Dialogue[None]:
    """Ask for every stream that a flight is watched by, and see that what is needed comes.

    Raises:
        NotReady: something needed does not come.
    """
    unheard, refused = list(STREAMS_S), set[str]()
    state.heard -= set(NEEDED.values())
    for _ in range(ASKINGS):
        for name in unheard:
            is_refused = not (yield from stream(name, STREAMS_S[name]))
            refused = refused | {name} if is_refused else refused - {name}
        if (yield from until(lambda: state.heard >= set(NEEDED.values()), LIMITS.stream_s)):
            return
        unheard = [name for name, kind in NEEDED.items() if kind not in state.heard]
    refusal = f"; it refused to send {', '.join(name for name in unheard if name in refused)}" if refused else ""
    words = f"the vehicle does not send {', '.join(unheard)}{refusal}"
    raise NotReady(words, hint="without it no flight is watched", code="streams-missing")


def unsubscribe() -> Dialogue[None]:
    """Give every stream its usual rate again."""
    for name in STREAMS_S:
        yield from stream(name, 0.0)


def expect_on_ground(state: VehicleState) -> None:
    """Raise NotReady for a vehicle that is armed already."""
    if state.armed:
        words = f"a flight begins disarmed and on the ground, but {state}"
        raise NotReady(words, hint="land and disarm it first", code="not-on-ground")


def prepare(departure: Departure, ready_s: float = LIMITS.ready_s) -> Dialogue[None]:
    """Bring a vehicle that stands on the ground to where it can be armed for its mission.

    Its current item is set and seen; then it is put into the mode in which it is armed, and waited for until it has a
    position and says that it could be armed.

    Raises:
        NotReady, TimeUp: armed already, not ready in time, or hindered by what waiting does not mend; with the
            vehicle's own reasons.
        NotFlown: it is no multicopter.
        NoAnswer, CommandRefused: it does not take the order for its current item.
    """
    state = departure.state
    yield from until(lambda: state.armed is not None and state.custom_mode is not None, SHOWN_S)
    state.expect_flown()
    expect_on_ground(state)
    yield from subscribe(state)
    yield from _set_first(departure)
    yield from _await_ready(departure, ready_s)
    expect_on_ground(state)
    yield from _set_first(departure)


def _await_ready(departure: Departure, ready_s: float) -> Dialogue[None]:
    state, mode = departure.state, departure.autopilot.modes.arming
    waited_s, hinders = 0.0, ""
    try:
        while True:
            state.warnings.clear()
            hinders = (yield from change_mode(state, mode)) or hinders
            if state.custom_mode == mode:
                if (yield from until(lambda: state.may_arm is not False and _has_position(state), LIMITS.look_s)):
                    return
                yield from command(VehicleCommand.RUN_PREARM_CHECKS)
                yield from wait(LIMITS.again_s)
                hinders = _hindrance(state)
                if lasting := departure.autopilot.protocol_profile.arming_words.lasting(hinders):
                    words = f"the vehicle cannot be armed: {'; '.join(lasting)}"
                    raise NotReady(words, hint=str(state), code="arming-refused")
            else:
                yield from wait(LIMITS.again_s)
            waited_s += LIMITS.look_s + LIMITS.again_s
            departure.progress(0.0, hinders)
            if waited_s > ready_s:
                raise NotReady(f"the vehicle is not ready after {waited_s:.0f} s: {hinders}", hint=str(state))
    except TimeUp as late:
        why = hinders or _hindrance(state)
        raise TimeUp(f"{late}: the vehicle is not ready: {why}", hint=str(state)) from None


def _hindrance(state: VehicleState) -> str:
    """Why it could not be armed, in its own words if it has any."""
    if state.warnings:
        return "; ".join(dict.fromkeys(state.warnings))
    return "its pre-arm checks do not pass, without a reason" if _has_position(state) else "it has no position"


def depart_when_ready(departure: Departure, left_s: Callable[[], float]) -> Dialogue[None]:
    """`depart`; one that is refused for a reason that passes is prepared again while there is time left [s]."""
    while True:
        try:
            return (yield from depart(departure))
        except NotYet as refused:
            departure.progress(0.0, f"not armed yet: {refused.words}")
            if left_s() <= 0.0:
                raise NotReady(f"the vehicle is not ready in time: {refused.words}", hint=refused.hint) from None
        yield from prepare(departure, left_s())


def depart(departure: Departure) -> Dialogue[None]:
    """Arm a prepared vehicle that is proved to hold our lists, and let it fly its mission.

    Raises:
        NotYet: it was not armed, for reasons that pass with time; `prepare` and `depart` may be tried again.
        Replaced, NotReady: it holds something else, or does not tell; it was not armed, or not started.
        CommandRefused, NoAnswer, Cancelled, TimeUp: with the vehicle's state as the hint; it was disarmed again if it
            said that it was still on the ground.
    """
    state, reasons = departure.state, departure.autopilot.protocol_profile.arming_words
    may_be_armed, attempt = False, 0
    try:
        while True:
            attempt += 1
            state.expect_flown()
            yield from prove(departure.holdings, state)
            may_be_armed = True
            result, words = yield from command(Command.COMPONENT_ARM_DISARM, 1.0)
            if result == CommandResult.ACCEPTED:
                break
            is_told = bool(reasons.reasons(words))
            is_last = is_told or attempt == LIMITS.arming_attempts
            if (yield from until(lambda: state.armed is True, SHOWN_S if is_last else LIMITS.again_s)):
                break  # what was refused was an order given before
            may_be_armed = False
            if is_last:
                if is_told and not reasons.lasting(words):
                    raise NotYet(result, words)
                raise CommandRefused(ARMING, result, words)
        yield from _begin(departure)
    except MissionError as broken_off:
        if may_be_armed:
            yield from _disarm_on_ground(state)
        broken_off.hint = str(state)
        raise


def _begin(departure: Departure) -> Dialogue[None]:
    state = departure.state
    if departure.autopilot.protocol_profile.starts_by_command:
        if departure.climb > 0.0:
            yield from _order("take off", Command.NAV_TAKEOFF, *(0.0,) * 6, departure.climb)
            yield from until(lambda: _height(state) > departure.climb - LIMITS.climbed_below, LIMITS.climb_s)
        state.current = None  # what it says of its mission now that it is armed counts
        yield from until(lambda: state.current is not None, LIMITS.again_s)
        expect_unchanged(departure.holdings)
        yield from _order("start the mission", VehicleCommand.MISSION_START)
    mode = departure.autopilot.modes.mission
    if not (yield from until(lambda: state.armed is True and state.custom_mode == mode, SHOWN_S)):
        raise NotReady(f"the vehicle did not begin its mission: {state}", code="mission-not-begun")


def _set_first(departure: Departure) -> Dialogue[None]:
    """The flight begins at its first item: said, and seen in MISSION_CURRENT."""
    state, first = departure.state, departure.first
    begins = range(first, departure.moving + 1)
    state.current = None
    yield from set_current(first, restart=True)
    if not (yield from until(lambda: state.current is not None and state.current.seq in begins, SHOWN_S)):
        stands = "it does not tell where" if state.current is None else f"at item {state.current.seq}"
        words = f"the mission was set to begin at item {first}, but it stands {stands}"
        raise NotReady(words, code="other-item-current")


def _has_position(state: VehicleState) -> bool:
    at = state.position
    return at is not None and (at.latitude_deg, at.longitude_deg) != (0.0, 0.0)


def _height(state: VehicleState) -> float:
    return -1.0 if state.position is None else state.position.height


def _order(what: str, number: int, *params: float) -> Dialogue[None]:
    result, words = yield from command(number, *params)
    if result != CommandResult.ACCEPTED:
        raise CommandRefused(what, result, words)


def _disarm_on_ground(state: VehicleState) -> Dialogue[None]:
    """Disarm a vehicle that stands: each order follows its own word, heard since, that it is on the ground.

    One that flies, takes off, or does not tell, is left alone.
    """
    try:
        for attempt in range(DISARMINGS):
            if attempt > 0 and (yield from until(lambda: state.armed is False, SHOWN_S)):
                return
            state.landed_state = None
            yield from until(lambda: state.landed_state is not None, SHOWN_S)
            if state.landed_state != ON_GROUND:
                return
            yield Remark(CommandLong(Command.COMPONENT_ARM_DISARM))
            state.armed = None
        yield from until(lambda: state.armed is not None, SHOWN_S)
    except (NoAnswer, Cancelled, TimeUp):
        return
