"""Orders to a flying vehicle: pause, resume, return, and the reaction to a deviation."""

import logging
import math
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Protocol

from ipoa_mission.autopilot.commands import Command, VehicleCommand
from ipoa_mission.geodesy import Geodetic
from ipoa_mission.geometry import Vector
from ipoa_mission.link import messages as m
from ipoa_mission.link import orders
from ipoa_mission.link.conversations import listen_for_words
from ipoa_mission.link.dialogue import Dialogue, Exchange, NoAnswer, Pause, RetryPolicy, SendOnce, until
from ipoa_mission.link.logbook import Logbook
from ipoa_mission.link.vehicle_state import NotFlown, NotReady, VehicleState
from ipoa_mission.link.vehicle_words import VehicleTexts
from ipoa_mission.mission.flight_record import Deviation, DeviationKind, OnDeviation

log = logging.getLogger(__name__)
ORDER_REPEATS = 6  # one a second
ORDER_POLICY = RetryPolicy(1.0, retries=ORDER_REPEATS - 1, alive_retries=ORDER_REPEATS - 1, adapt=False)
SHOWN_S = 5.0
PENDING_RESULTS = frozenset({m.CommandResult.ACCEPTED, m.CommandResult.IN_PROGRESS})  # the mode may still change


@dataclass
class FlightOrder:
    """Give a watched vehicle one order at a time; none in a link loss."""

    state: VehicleState
    now: Callable[[], float]
    words: str = ""  # why it does not obey
    is_refused: bool = False  # in this mode, and nobody took over
    is_paused: bool = False
    _was_paused: bool = False  # as reported
    _is_cut: bool = False
    _mode: int | None = None  # before the order
    _name: str = ""
    _exchange: Exchange[bool] | None = None

    def give(self, mode: int) -> None:
        self._take(self.state.autopilot.modes.name(mode), enter(self.state, mode))

    def hold(self) -> None:
        if not self.is_paused and not (self.is_under_way and self._name == "hold"):  # a second pause would be refused
            self._take("hold", hold(self.state))

    def go_on(self) -> None:
        self._take("go on", go_on(self.state, self.is_paused))

    @property
    def is_held(self) -> bool:
        return self.is_paused or self.state.custom_mode == self.state.autopilot.modes.hold

    @property
    def is_under_way(self) -> bool:
        return self._exchange is not None

    def cut(self, is_cut: bool) -> None:
        self._is_cut = is_cut
        self.is_refused = False
        if self.is_under_way:
            self.words = f"{self._name} was ordered, and the link was lost before the vehicle showed it"
            self._exchange = None

    def observe(self, heard: m.Message, now_s: float) -> Dialogue[None]:
        state = self.state
        if state.is_paused != self._was_paused:  # by any station
            self._was_paused = state.is_paused
            self.is_paused = state.is_paused
        self.is_paused = self.is_paused and state.custom_mode == state.autopilot.modes.mission
        if not state.armed:
            self._exchange = None
        exchange = self._exchange
        if exchange is None:
            return
        try:
            state.expect_flown()
            due = exchange.outgoing()
            if not due:  # before it is sent, only another's order is answered
                exchange.receive(heard, self.now())
                exchange.tick(self.now())
                due = exchange.outgoing()
            for message in due:
                yield SendOnce(message)
            if exchange.finished:
                self.is_paused = exchange.result
                self._exchange = None
        except NoAnswer:
            self._fail(f"{self._name} was ordered {ORDER_REPEATS} times, and the vehicle does not show it")
        except (NotFlown, NotReady, orders.CommandRefused) as reason:
            self._fail(str(reason))
            self.is_refused = self.is_refused and not isinstance(reason, NotFlown)

    def _take(self, name: str, order: Dialogue[bool]) -> None:
        self.words = f"{name} was not ordered: the link is lost" if self._is_cut else ""
        self.is_refused = False
        self._mode = self.state.custom_mode
        self._name = name
        self._exchange = None if self._is_cut else Exchange(order, self.now(), ORDER_POLICY)

    def _fail(self, words: str) -> None:
        self.words = words
        self.is_refused = self.state.custom_mode == self._mode
        self._exchange = None
        log.warning("%s", words)


def in_flight(state: VehicleState, order: Dialogue[bool]) -> Dialogue[None]:
    """Give an order to a flying vehicle; raise NotReady."""
    yield from until(lambda: state.armed is not None and state.custom_mode is not None, SHOWN_S)  # by heartbeats
    if not state.armed or state.in_air is False:
        raise NotReady(f"expected a vehicle in the air: {state}", hint="`fly` begins a flight", code="not-in-the-air")
    yield from order


def hold(state: VehicleState) -> Dialogue[bool]:
    """Return whether it pauses within its mission, as ArduCopter on its way to a waypoint; else it changes its mode."""
    modes = state.autopilot.modes
    if state.autopilot.protocol_profile.pauses_in_mission and state.custom_mode == modes.mission:
        with suppress(NoAnswer):
            check = partial(state.expect_mode, "pause", modes.mission)
            result, _ = yield from orders.send(Command.DO_PAUSE_CONTINUE, 0.0, check=check)
            if result == m.CommandResult.ACCEPTED:
                return True
    return (yield from enter(state, modes.hold))


def go_on(state: VehicleState, is_paused: bool) -> Dialogue[bool]:
    yield from enter(state, state.autopilot.modes.mission)
    if state.autopilot.protocol_profile.pauses_in_mission:
        check = partial(state.expect_mode, "go on", state.autopilot.modes.mission)
        result, words = yield from orders.send(Command.DO_PAUSE_CONTINUE, 1.0, check=check)
        if is_paused and result != m.CommandResult.ACCEPTED:
            raise orders.CommandRefused("go on", result, words)
    return False


def enter(state: VehicleState, mode: int) -> Dialogue[bool]:
    """Raise NotReady unless the vehicle shows the mode; return False: it does not pause."""
    if reason := (yield from change_mode(state, mode)):
        raise NotReady(reason, hint=str(state))
    return False


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


class Monitor(Protocol):
    def local(self, at: Geodetic, height: float) -> Vector: ...
    def interrupt(self) -> None: ...
    def see(self, time: float, place: Vector, item: int | None) -> Deviation | None: ...


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
        lost_s = self.ended_s + (self._age_s if self.is_lost else 0.0)
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
        return Deviation(DeviationKind.HOME, item, heard.time_s, abs(moved), self.home_moves, words) if moved else None

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
