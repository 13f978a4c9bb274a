"""Orders to a flying vehicle: pause, resume, return, and the reaction to a deviation."""

import logging
import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import partial
from typing import TYPE_CHECKING, Protocol

from ipoa_mission.autopilot.commands import Command, VehicleCommand
from ipoa_mission.errors import MissionError
from ipoa_mission.geodesy import Geodetic
from ipoa_mission.link import messages as m
from ipoa_mission.link import orders
from ipoa_mission.link.conversations import VehicleTexts, listen_for_words
from ipoa_mission.link.dialogue import Dialogue, Pause, SendOnce, until
from ipoa_mission.link.logbook import Logbook
from ipoa_mission.link.vehicle_state import NotFlown, NotReady, VehicleState
from ipoa_mission.mission.flight_record import Deviation, DeviationKind, OnDeviation

if TYPE_CHECKING:
    from ipoa_mission.geometry import Vector

log = logging.getLogger(__name__)
ORDER_REPEATS = 6  # one a second
SHOWN_S = 5.0
PENDING_RESULTS = frozenset({m.CommandResult.ACCEPTED, m.CommandResult.IN_PROGRESS})  # the mode may still change


def pause(state: VehicleState) -> Dialogue[None]:
    """Hold position; raise NotReady. ArduCopter pauses on its way to a waypoint, and brakes elsewhere; PX4 holds."""
    yield from _expect_flying(state)
    if state.autopilot.protocol_profile.pauses_in_mission:
        check = partial(state.expect_mode, "pause", state.custom_mode)
        result, _ = yield from orders.send(Command.DO_PAUSE_CONTINUE, 0.0, check=check)
        if result == m.CommandResult.ACCEPTED:
            yield from until(lambda: state.custom_mode is not None, SHOWN_S)
            return
    yield from _enter(state, state.autopilot.modes.hold)


def resume(state: VehicleState) -> Dialogue[None]:
    yield from _expect_flying(state)
    yield from _enter(state, state.autopilot.modes.mission)
    if state.autopilot.protocol_profile.pauses_in_mission:
        check = partial(state.expect_mode, "go on", state.autopilot.modes.mission)
        yield from orders.send(Command.DO_PAUSE_CONTINUE, 1.0, check=check)  # refused unless paused


def return_to_launch(state: VehicleState) -> Dialogue[None]:
    """Return and land, by the vehicle's parameters; raise NotReady."""
    yield from _expect_flying(state)
    yield from _enter(state, state.autopilot.modes.returning)


@dataclass
class _Step:
    """Repeat until the `mode` is shown, without one until accepted; `otherwise`: if refused."""

    name: str
    message: m.CommandLong
    mode: int | None = None
    pauses: bool = False
    otherwise: "_Step | None" = None
    times_sent: int = 0
    due_s: float = -math.inf


@dataclass
class FlightOrder:
    """Repeat an order until the vehicle obeys, refuses or changes to another mode; order nothing in a link loss."""

    state: VehicleState
    now: Callable[[], float]
    words: str = ""  # why it does not obey
    is_refused: bool = False  # in this mode, and nobody took over
    is_paused: bool = False
    _was_paused: bool = False  # as reported
    _is_cut: bool = False
    _mode: int | None = None  # before the order
    _steps: list[_Step] = field(default_factory=list)

    def give(self, mode: int) -> None:
        self._take(self._change(mode))

    def hold(self) -> None:
        if self.is_paused or any(step.pauses for step in self._steps):
            return  # a second pause would be refused
        autopilot = self.state.autopilot
        order = self._change(autopilot.modes.hold)
        if autopilot.protocol_profile.pauses_in_mission and self.state.custom_mode == autopilot.modes.mission:
            order = _Step("pause", orders.command_long(Command.DO_PAUSE_CONTINUE, 0.0), pauses=True, otherwise=order)
        self._take(order)

    def go_on(self) -> None:
        steps = [self._change(self.state.autopilot.modes.mission)]
        if self.is_paused:
            steps.append(_Step("go on", orders.command_long(Command.DO_PAUSE_CONTINUE, 1.0)))
        self._take(*steps)

    @property
    def is_held(self) -> bool:
        return self.is_paused or self.state.custom_mode == self.state.autopilot.modes.hold

    @property
    def is_under_way(self) -> bool:
        return bool(self._steps)

    def cut(self, is_cut: bool) -> None:
        self._is_cut = is_cut
        self.is_refused = False
        if self._steps:
            self.words = f"{self._steps[0].name} was ordered, and the link was lost before the vehicle showed it"
            self._steps.clear()

    def observe(self, heard: m.Message, now_s: float) -> Dialogue[None]:
        state = self.state
        if state.is_paused != self._was_paused:  # by any station
            self._was_paused = state.is_paused
            self.is_paused = state.is_paused
        self.is_paused = self.is_paused and state.custom_mode == state.autopilot.modes.mission
        if not state.armed:
            self._steps.clear()
        try:
            self._hear(heard)
            if not self._steps:
                return
            state.expect_flown()
            if self.now() >= self._steps[0].due_s:
                if self._steps[0].times_sent == ORDER_REPEATS:
                    words = f"{self._steps[0].name} was ordered {ORDER_REPEATS} times, and the vehicle does not show it"
                    self._refused(NotReady(words, code="mode-not-shown"))
                step = self._steps[0]
                step.times_sent += 1
                step.due_s = self.now() + 1.0
                yield SendOnce(step.message)
        except (NotFlown, NotReady, orders.CommandRefused) as reason:
            self.words = str(reason)
            self.is_refused = isinstance(reason, orders.CommandRefused) or reason.code == "mode-not-shown"
            self._steps.clear()
            log.warning("%s", reason)

    def _change(self, mode: int) -> _Step:
        autopilot = self.state.autopilot
        return _Step(autopilot.modes.name(mode), orders.mode_order(mode, autopilot), mode)

    def _take(self, *steps: _Step) -> None:
        self.words = f"{steps[0].name} was not ordered: the link is lost" if self._is_cut and steps else ""
        self.is_refused = False
        self._mode = self.state.custom_mode
        self._steps = [] if self._is_cut else [*steps]

    def _hear(self, heard: m.Message) -> None:
        while self._steps and self._steps[0].mode is not None and self._steps[0].mode == self.state.custom_mode:
            self._take(*self._steps[1:])
        if not self._steps:
            return
        step = self._steps[0]
        self.state.expect_mode(step.name, self._mode)
        if step.times_sent == 0 or not isinstance(heard, m.CommandAck) or heard.command != step.message.command:
            return  # before it is sent, only another's order is answered
        if step.mode is None and heard.result == m.CommandResult.ACCEPTED:
            self.is_paused = step.pauses
            self._take(*self._steps[1:])
        elif heard.result not in PENDING_RESULTS:
            action = step.name if step.mode is None else f"change to {step.name}"
            self._refused(orders.CommandRefused(action, heard.result))

    def _refused(self, why: MissionError) -> None:
        otherwise = self._steps[0].otherwise
        if otherwise is None:
            raise why
        self._take(otherwise)


def change_mode(state: VehicleState, mode: int) -> Dialogue[str]:
    """Return why not, or an empty string."""
    if state.custom_mode == mode:
        return ""
    name = state.autopilot.modes.name(mode)
    check = partial(state.expect_mode, name, state.custom_mode, mode)
    result, words = yield from orders.send_command(orders.mode_order(mode, state.autopilot), check)
    texts = VehicleTexts(words=[words] if words else [])
    if result == m.CommandResult.ACCEPTED:
        result = yield from _taken_back(state, mode, texts)
    if state.custom_mode == mode:
        return ""
    if result == m.CommandResult.ACCEPTED:
        return f"it accepted {name} but does not show it"
    return str(texts) or str(orders.CommandRefused(f"change to {name}", result))


def _taken_back(state: VehicleState, mode: int, texts: VehicleTexts) -> Dialogue[int]:
    """PX4 accepts first, and may refuse later."""
    heard: m.Message | None = None if state.custom_mode == mode else (yield Pause(SHOWN_S))
    while heard is not None and state.custom_mode != mode:
        texts.note(heard)
        match heard:
            case m.CommandAck(VehicleCommand.DO_SET_MODE, result) if result not in PENDING_RESULTS:
                yield from listen_for_words(texts)
                return result
        heard = yield None
    return m.CommandResult.ACCEPTED


def _enter(state: VehicleState, mode: int) -> Dialogue[None]:
    if reason := (yield from change_mode(state, mode)):
        raise NotReady(reason, hint=str(state))


def _expect_flying(state: VehicleState) -> Dialogue[None]:
    """Wait for heartbeats only: other streams may not come."""
    yield from until(lambda: state.armed is not None and state.custom_mode is not None, SHOWN_S)
    if not state.armed or state.in_air is False:
        raise NotReady(f"expected a vehicle in the air: {state}", hint="`fly` begins a flight", code="not-in-the-air")


class Monitor(Protocol):
    def local(self, at: Geodetic, height: float) -> "Vector": ...
    def interrupt(self) -> None: ...
    def see(self, time: float, place: "Vector", item: int | None) -> Deviation | None: ...


@dataclass
class PositionLoss:
    """Notice a lack of positions while other streams arrive."""

    least_s: float = 3.0  # as a link loss
    least_share: float = 10.0  # of `usual`; less may be chance
    usual: float = 30.0  # other messages between two positions
    ended_s: float = 0.0  # duration of the stretches that are over
    _others: int = 0  # since the last position
    _since_s: float = math.inf
    _age_s: float = 0.0
    _requested_s: float = -math.inf

    def note(self, heard: m.Message, now_s: float, is_compared: bool) -> bool:
        """Return whether the stream is to be requested again."""
        if isinstance(heard, m.Position) or not is_compared:
            if self.is_lost:
                log.warning("%s", self.words)
                self.ended_s += self._age_s
            elif is_compared:
                self.usual += (self._others - self.usual) / 32.0
            self._others = 0
            self._since_s = now_s
        self._others += isinstance(heard, m.Heartbeat | m.Current | m.SystemStatus | m.ExtendedState)
        self._since_s = min(self._since_s, now_s)
        self._age_s = now_s - self._since_s
        is_due = self.is_lost and now_s - self._requested_s >= self.least_s
        if is_due:
            self._requested_s = now_s
        return is_due

    @property
    def is_lost(self) -> bool:
        return self._age_s >= self.least_s and self._others >= self.least_share * self.usual

    @property
    def words(self) -> str:
        lost_s = self.ended_s + self._age_s * self.is_lost
        return f"the flight was not compared for {lost_s:.0f} s: no position was heard" if lost_s else ""


@dataclass
class Conformance:
    """React to deviations of one vehicle's flight; `report` gets each, with its time from the arming [s].

    A refused order is given again while the vehicle flies on in its mode. RTL does not replace a hold: PX4
    requires a position for both.
    """

    state: VehicleState
    order: FlightOrder
    on_deviation: OnDeviation = OnDeviation.HOLD
    report: Callable[[Deviation], None] = lambda deviation: None
    ends_held: bool = True  # a deviation's hold ends the watch
    repeat_s: float = 5.0  # after a refusal
    deviations: list[Deviation] = field(default_factory=list)
    positions: PositionLoss = field(default_factory=PositionLoss)
    logbook: Logbook | None = None  # of the flight
    home_moves: float = 4.0  # more than PX4 1.17 corrects its home in flight [m]
    _monitor: Monitor | None = None
    _home: float = math.nan  # its altitude [m]
    _seen_s: float = -math.inf
    _is_ordered: bool = False
    _disobeyed: str = ""
    _again_s: float = math.inf

    def begin(self, monitor: "Monitor | None") -> None:
        self._monitor = monitor
        self._home = math.nan
        self._seen_s = -math.inf
        self._is_ordered = False
        self._disobeyed = ""
        self._again_s = math.inf
        self.positions = PositionLoss()
        self.deviations.clear()

    @property
    def is_held(self) -> bool:
        return self._is_ordered and self.on_deviation is OnDeviation.HOLD and self.order.is_held

    @property
    def why_not(self) -> str:
        if not self.is_held and (self._disobeyed or not self._is_ordered):
            return self._disobeyed
        reaction = "it holds" if self.is_held else f"{self.on_deviation} was ordered"
        failed = f"; {self.order.words}" if self.order.words and not self.is_held else ""
        return f"{reaction}, because {self.deviations[-1]}{failed}"

    def observe(self, heard: m.Message, now_s: float) -> Dialogue[None]:
        if self._monitor is None:
            return
        in_mission = self.state.custom_mode == self.state.autopilot.modes.mission
        is_compared = not self.order.is_paused and (in_mission or self._returns_at_its_end)
        if self.positions.note(heard, self.order.now(), is_compared and bool(self.state.in_air)):
            log.warning("%s; its stream is requested again", self.positions.words)
            if self.state.other_kind is None:
                yield SendOnce(orders.stream_order("GLOBAL_POSITION_INT", orders.STREAMS_S["GLOBAL_POSITION_INT"]))
        if isinstance(heard, m.Position) and heard.time_s - self._seen_s >= 0.2:
            self._seen_s = heard.time_s
            if self.state.in_air and is_compared:
                self._compare(heard, in_mission)
            elif self.state.in_air:
                self._monitor.interrupt()
                self._again_s = math.inf  # it obeyed, or somebody took over
                if self._is_ordered and not self.order.words:
                    self._disobeyed = ""

    def _home_shift(self, heard: m.Position) -> Deviation | None:
        """A moved home shifts the heights that are left to fly."""
        home = heard.altitude - heard.height
        moved = 0.0 if math.isnan(self._home) else home - self._home
        if not math.isnan(self._home) and abs(moved) <= self.home_moves:
            return None
        self._home = home
        words = f"the vehicle's home moved by {moved:+.1f} m in height, and its heights count from there"
        item = (self._item or 0) + 1
        kind = DeviationKind.HOME
        return Deviation(kind, item, heard.time_s, abs(moved), self.home_moves, words) if moved else None

    def _compare(self, heard: m.Position, in_mission: bool) -> None:
        assert self._monitor is not None
        if self._is_ordered and self.order.is_under_way:
            return  # ignore deviations until the vehicle obeys
        if self._is_ordered and (in_mission or self.order.is_refused):
            if self.order.words and not self._disobeyed:
                self._disobeyed = self.why_not
            if self.order.is_refused:
                self._again_s = heard.time_s + self.repeat_s
                words = "nothing was done: the vehicle flies on; take it over; %s is ordered again in %g s"
                log.warning(words, self.on_deviation, self.repeat_s)
            self._is_ordered = False  # refused, or the mission was resumed
        elif self.order.is_refused and heard.time_s >= self._again_s:
            self._react_by_order()
        place = self._monitor.local(Geodetic(heard.latitude_deg, heard.longitude_deg, heard.altitude), heard.height)
        deviation = self._home_shift(heard) or self._monitor.see(heard.time_s, place, self._item)
        if deviation is not None:
            self._react(deviation)

    @property
    def _returns_at_its_end(self) -> bool:
        logbook = self.logbook
        if logbook is None or self.state.custom_mode not in logbook.modes & self.state.autopilot.modes.returns:
            return False
        return logbook.is_flown or logbook.done >= logbook.total - 1

    @property
    def _item(self) -> int | None:
        if self.logbook is not None and self._returns_at_its_end:
            return self.logbook.total - 1
        current = self.state.current
        return None if current is None else current.seq - self.state.autopilot.seq_offset

    def _react(self, deviation: Deviation) -> None:
        armed_s = 0.0 if self.logbook is None else self.logbook.armed_s
        deviation = replace(deviation, time_s=deviation.time_s - armed_s)
        self.deviations.append(deviation)
        is_ordered = self.on_deviation is not OnDeviation.REPORT and not self._is_ordered
        log.warning("%s%s", deviation, f"; {self.on_deviation} is ordered" if is_ordered else "")
        self.report(deviation)
        if is_ordered:
            self._react_by_order()

    def _react_by_order(self) -> None:
        self._is_ordered = True
        self._again_s = math.inf
        if self.on_deviation is OnDeviation.HOLD:
            self.order.hold()
        else:
            self.order.give(self.state.autopilot.modes.returning)
