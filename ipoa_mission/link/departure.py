"""From standing on the ground to flying a mission from a known item: the order that each firmware wants.

Nothing turns before the vehicle tells that it stands disarmed, will begin at the right item, and could be armed in the
mode in which it is armed; and what is refused after that disarms it again.
"""

from dataclasses import dataclass

from ipoa_mission.autopilots.modes import ARMING_MODE, MISSION_MODE
from ipoa_mission.autopilots.vehicle import Autopilot
from ipoa_mission.commands import Command, Order
from ipoa_mission.errors import MissionError
from ipoa_mission.link.dialogue import Cancelled, Dialogue, NoAnswer, TimeUp, until, wait
from ipoa_mission.link.hold import SHOWN_S, change_mode
from ipoa_mission.link.messages import CommandResult, Current
from ipoa_mission.link.orders import CommandRefused, command, set_current, stream
from ipoa_mission.link.state import NotReady, VehicleState
from ipoa_mission.link.telemetry import Position, SystemStatus
from ipoa_mission.progress import Progress, silent

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


@dataclass(frozen=True)
class DepartureLimits:
    """How long a vehicle is given for each step of its departure."""

    stream_s: float = 8.0  # until a stream that was asked for is heard
    ready_s: float = 180.0  # until it could be armed,
    look_s: float = 3.0  # with so long between two looks at what hinders
    again_s: float = 1.0  # before the next look, and between two attempts to arm
    arming_attempts: int = 5  # one that says it could be armed may still need a moment
    climb_s: float = 120.0  # until it has climbed
    climbed_below: float = 0.5  # to so far below the height that was asked for [m]


LIMITS = DepartureLimits()


@dataclass(frozen=True)
class Departure:
    """A flight about to begin at item `first` (as numbered on the wire); `progress` is told what is waited for.

    `moving`: the first item from there on that moves the vehicle, which ArduPilot calls current where others, done at
    once, stand before it. `climb`: how high an ArduPilot climbs before an item that is no take-off [m]; PX4 does that
    by itself.
    """

    state: VehicleState
    first: int
    moving: int
    climb: float = 0.0
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
    refused = []
    for name, interval_s in STREAMS_S.items():
        if not (yield from stream(name, interval_s)):
            refused.append(name)
    state.heard -= set(NEEDED.values())
    if not (yield from until(lambda: state.heard >= set(NEEDED.values()), LIMITS.stream_s)):
        unheard = [name for name, kind in NEEDED.items() if kind not in state.heard]
        refusal = f"; it refused to send {', '.join(refused)}" if refused else ""
        raise NotReady(
            f"the vehicle does not send {', '.join(unheard)}{refusal}", hint="without it no flight is watched"
        )


def unsubscribe() -> Dialogue[None]:
    """Give every stream its usual rate again."""
    for name in STREAMS_S:
        yield from stream(name, 0.0)


def expect_on_ground(state: VehicleState) -> None:
    """Raise NotReady for a vehicle that is armed already."""
    if state.armed:
        raise NotReady(f"a flight begins disarmed and on the ground, but {state}", hint="land and disarm it first")


def prepare(departure: Departure, ready_s: float = LIMITS.ready_s) -> Dialogue[None]:
    """Bring a vehicle that stands on the ground to where it can be armed for its mission.

    Its current item is set and seen; then it is put into the mode in which it is armed, and waited for until it has a
    position and says that it could be armed.

    Raises:
        NotReady: armed already, or not ready in time; with the vehicle's own reasons.
        NoAnswer, CommandRefused: it does not take the order for its current item.
    """
    state = departure.state
    yield from until(lambda: state.armed is not None, SHOWN_S)
    expect_on_ground(state)
    yield from subscribe(state)
    yield from _set_first(departure)
    mode = ARMING_MODE[departure.autopilot]
    waited_s = 0.0
    while True:
        state.warnings.clear()
        hinders = yield from change_mode(state, mode)
        if not hinders:
            if (yield from until(lambda: state.may_arm is not False and _has_position(state), LIMITS.look_s)):
                break
            yield from command(Order.RUN_PREARM_CHECKS)
            yield from until(lambda: bool(state.warnings), 0.5)
            hinders = "; ".join(dict.fromkeys(state.warnings)) or "its pre-arm checks do not pass, without a reason"
        waited_s += LIMITS.look_s
        departure.progress(0.0, hinders)
        if waited_s > ready_s:
            raise NotReady(f"the vehicle is not ready after {waited_s:.0f} s: {hinders}", hint=str(state))
        yield from wait(LIMITS.again_s)
    expect_on_ground(state)
    yield from _set_first(departure)


def depart(departure: Departure) -> Dialogue[None]:
    """Arm a prepared vehicle and let it fly its mission.

    Raises:
        CommandRefused, NoAnswer, Cancelled, TimeUp: with the vehicle's state as the hint; it was disarmed again if it
            was still on the ground.
    """
    try:
        yield from _arm()
        yield from _begin(departure)
    except MissionError as broken_off:
        if not (isinstance(broken_off, CommandRefused) and broken_off.what == ARMING):
            yield from _disarm_on_ground(departure.state)
        broken_off.hint = str(departure.state)
        raise


def _begin(departure: Departure) -> Dialogue[None]:
    state = departure.state
    if departure.autopilot is Autopilot.ARDUPILOT:
        if departure.climb > 0.0:
            yield from _order("take off", Command.NAV_TAKEOFF, *(0.0,) * 6, departure.climb)
            yield from until(lambda: _height(state) > departure.climb - LIMITS.climbed_below, LIMITS.climb_s)
        yield from _order("start the mission", Order.MISSION_START)
    mode = MISSION_MODE[departure.autopilot]
    if not (yield from until(lambda: state.armed is True and state.custom_mode == mode, SHOWN_S)):
        raise NotReady(f"the vehicle did not begin its mission: {state}")


def _set_first(departure: Departure) -> Dialogue[None]:
    """The flight begins at its first item: said, and seen in MISSION_CURRENT."""
    state, first = departure.state, departure.first
    begins = range(first, departure.moving + 1)
    state.current = None
    yield from set_current(first, restart=True)
    if not (yield from until(lambda: state.current is not None and state.current.seq in begins, SHOWN_S)):
        stands = "it does not tell where" if state.current is None else f"at item {state.current.seq}"
        raise NotReady(f"the mission was set to begin at item {first}, but it stands {stands}")


def _has_position(state: VehicleState) -> bool:
    at = state.position
    return at is not None and (at.latitude_deg, at.longitude_deg) != (0.0, 0.0)


def _height(state: VehicleState) -> float:
    return -1.0 if state.position is None else state.position.height


def _order(what: str, number: int, *params: float) -> Dialogue[None]:
    result, words = yield from command(number, *params)
    if result != CommandResult.ACCEPTED:
        raise CommandRefused(what, result, words)


def _arm() -> Dialogue[None]:
    for _ in range(LIMITS.arming_attempts - 1):
        try:
            return (yield from _order(ARMING, Command.COMPONENT_ARM_DISARM, 1.0))
        except CommandRefused:
            yield from wait(LIMITS.again_s)
    yield from _order(ARMING, Command.COMPONENT_ARM_DISARM, 1.0)


def _disarm_on_ground(state: VehicleState) -> Dialogue[None]:
    """A vehicle in the air refuses this by itself; its state is heard once more either way."""
    try:
        yield from command(Command.COMPONENT_ARM_DISARM, 0.0)
        state.armed = None
        yield from until(lambda: state.armed is not None, SHOWN_S)
    except (NoAnswer, Cancelled, TimeUp):
        return
