"""Upload and fly; arms only after the page has named the same vehicle, mission and proof."""

import math
import queue
import time
from collections import deque
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np

from ipoa_mission import FlightRecord, Forecast, Geodetic, MissionError, Vehicle, Wind
from ipoa_mission.autopilot.failsafe import Contingency
from ipoa_mission.flight.procedure import ProcedureOptions, Stage, Stages, begin_mission, load_mission
from ipoa_mission.forecast.contingency.contingencies import ContingencyRow
from ipoa_mission.forecast.contingency.contingencies_now import ContingenciesNow
from ipoa_mission.forecast.contingency.energy_budget import Budget, ReserveNow, budget_of
from ipoa_mission.geometry import Vector, bearing
from ipoa_mission.link.channel import serial_ports
from ipoa_mission.link.connect import connect, open_connection
from ipoa_mission.link.discovery import scan
from ipoa_mission.link.messages import Gps, Message, Position, Text, WindEstimate, WindVelocity
from ipoa_mission.mission.item_words import count_words
from ipoa_mission.progress import Progress
from ipoa_mission.simulator.fly import board, conditions_for
from ipoa_mission.studio.flight_answers import Heard, HeardLink, Landed, Loaded, OrderThen, Seen, State
from ipoa_mission.studio.handed import HandedOver
from ipoa_mission.studio.processes import Answer, JobOrder, Worker
from ipoa_mission.studio.vocabulary import InFlight

LISTEN_S = 1.5  # per link; heartbeats come once a second
USUAL = ("udpin:127.0.0.1:14550", "udpin:127.0.0.1:14540", "tcp:127.0.0.1:5760")
POSITION_INTERVAL_S = 0.2  # by the vehicle's clock
FORECAST_INTERVAL_S = 1.0
ORDERED: dict[InFlight, Contingency] = {"hold": Contingency.HOLD, "rtl": Contingency.RTL, "land": Contingency.LAND}


@dataclass(eq=False)
class FlightWorker:
    """Fly one mission at a time; `inbox` holds the page's messages."""

    inbox: "queue.SimpleQueue[JobOrder]"

    def fly(self, order: JobOrder, answer: Answer) -> None:
        while not self.inbox.empty():
            self.inbox.get()  # left over
        try:
            self._fly(HandedOver.take(Path(order["file"])), order, answer)
        except MissionError as error:
            if error.hint and "--" in error.hint:
                error.hint = f"from the command line: {error.hint}"
            raise

    def _fly(self, handed: HandedOver, order: JobOrder, answer: Answer) -> None:
        link = order["link"]
        log = Path(order["log"])
        mission = handed.forecast.mission
        remarks = [*handed.remarks]
        if link is None:
            conditions = conditions_for(mission, handed.forecast.wind, handed.forecast.ground)
            opened = board(mission, conditions, log=log)
        else:
            opened = connect(link, system=order["system"], log=log)
        with opened as vehicle:
            items = len(handed.forecast.mission_as_read.items)
            name = f"{'built-in ' if link is None else ''}{vehicle.autopilot}, system {vehicle.system}"
            options = ProcedureOptions(
                set_params=order["set_params"], stages=_stages("uploading", answer), remark=remarks.append, checked=True
            )
            forecast = load_mission(vehicle, handed.forecast, options)
            loaded = Loaded(
                vehicle=name,
                system=vehicle.system,
                mission=handed.name,
                proof=handed.proof,
                items=items,
                built_in=link is None,
                remarks=tuple(dict.fromkeys(remarks)),
            )
            answer(loaded)
            answer(State(phase="loaded", words=f"{count_words(items)} on {name}, read back and equal"))
            self._await_start(loaded)
            watch = Watch(forecast, vehicle, answer, order["speedup"] if link is None else None, self.inbox)
            vehicle.conformance.ends_held = False
            record = begin_mission(vehicle, forecast, ProcedureOptions(stages=watch.stages, remark=watch.remark))
        ordered = None if record.completed or record.armed or record.deviations else watch.obeyed
        answer(
            Landed(
                completed=record.completed,
                why_not=record.why_not,
                ordered=ordered,
                flown_s=round(record.total_s, 2),
                estimated_s=round(forecast.estimate.total_s, 2),
                log=log.name,
            )
        )
        landed = "landed" if ordered is None else "landed, as ordered"
        words = landed if record.completed or ordered else f"not complete: {record.why_not}"
        answer(State(phase="over", words=words))

    def _await_start(self, loaded: Loaded) -> None:
        """Poll for the start: a blocking wait cannot be cancelled."""
        start: JobOrder | None = None
        while start is None:
            with suppress(queue.Empty):
                start = self.inbox.get(timeout=0.1)
        for key in ("vehicle", "mission", "proof"):
            if start.get(key) != getattr(loaded, key):
                words = f"not started: {key}: expected {getattr(loaded, key)!r}, not {start.get(key)!r}"
                raise MissionError(words, hint="upload again", code="upload-again")


def _stages(phase: Literal["uploading", "preparing"], answer: Answer) -> Stages:
    @contextmanager
    def stages(stage: Stage) -> Iterator[Progress]:
        answer(State(phase=phase, words=stage))
        yield lambda _, words: answer(State(phase=phase, words=words))

    return stages


def listen(order: JobOrder, answer: Answer) -> None:
    links = dict.fromkeys([order["link"], *USUAL, *(f"serial:{port}:57600" for port in serial_ports())])
    answer(Heard(links=tuple(row for link in links if link for row in _heard_on(link))))


def _heard_on(link: str) -> Iterator[HeardLink]:
    try:
        with open_connection(link) as connection:
            vehicles = scan(connection, LISTEN_S)
    except MissionError as error:
        yield HeardLink(link=link, system=None, words=str(error).removeprefix(f"{link}: "))
        return
    for vehicle in vehicles:
        limit = "" if vehicle.kind.is_flown else ": it is not flown from here"
        words = f"{vehicle.kind}, system {vehicle.system}{', armed' if vehicle.armed else ''}{limit}"
        yield HeardLink(link=link, system=vehicle.system, words=words)
    if not vehicles:
        yield HeardLink(link=link, system=None, words="no vehicle heard")


@dataclass(eq=False)
class Watch:
    """`speedup`: of the built-in autopilot, which has no clock."""

    forecast: Forecast
    vehicle: Vehicle
    answer: Answer
    speedup: float | None
    inbox: "queue.SimpleQueue[JobOrder]"

    def __post_init__(self) -> None:
        self._contingencies: ContingenciesNow | None = None
        self._budget: Budget | None = None
        self._unknown = "no scenario gives the obstacles here"
        if self.forecast.scenario is not None:
            self._unknown = "the flight has no forecast"
            self._budget = budget_of(self.forecast)
            with suppress(MissionError):
                self._contingencies = ContingenciesNow(self.forecast, tuple(ORDERED.values()))
        self._expected = {item.seq - 1: item.done_s for item in self.forecast.estimate.items}
        self._orders: tuple[OrderThen, ...] = ()
        self._reserve: ReserveNow | None = None
        self._orders_s = -FORECAST_INTERVAL_S
        self._position_s = -POSITION_INTERVAL_S
        self._state = State(phase="flying", words=Stage.START)
        self._texts: deque[str] = deque(maxlen=6)
        self._satellites: int | None = None
        self._wind: tuple[float, float] | None = None
        self._begun: tuple[float, float] | None = None
        self._ordered: Literal["rtl", "land"] | None = None
        self.obeyed: Literal["rtl", "land"] | None = None
        """The page's order by which the vehicle ends its flight, if there is one."""

    @contextmanager
    def stages(self, stage: Stage) -> Iterator[Progress]:
        if stage is Stage.START:
            self.vehicle.overhearing = self.hear
        if stage is Stage.FLIGHT:
            self.answer(State(phase="flying", words=Stage.START))
            yield self.look
        else:
            with _stages("preparing", self.answer)(stage) as progress:
                yield progress

    def remark(self, words: str) -> None:
        self.answer(State(phase="preparing", words=words))

    def hear(self, message: Message) -> None:
        """Handle a message; one without a position may still require landing earlier."""
        self.look()
        match message:
            case Text(_, text):
                self._texts.appendleft(text.strip())
            case Gps():
                self._satellites = message.satellites_visible
            case WindEstimate():
                self._wind = round(message.speed, 1), bearing(message.direction_deg)
            case WindVelocity((north, east, _)) if math.isfinite(north) and math.isfinite(east):
                wind = Wind.of_velocity(east, north)
                self._wind = round(wind.speed, 1), bearing(wind.from_deg)
            case Position() if self.vehicle.state.armed and message.time_s - self._position_s >= POSITION_INTERVAL_S:
                self._position_s = message.time_s
                if self.speedup is not None:
                    self._keep_pace(message.time_s, self.speedup)
                record = self.vehicle.record()
                if record.path:
                    self.answer(self._seen(message, record))

    def _keep_pace(self, time_s: float, speedup: float) -> None:
        if self._begun is None:
            self._begun = time_s, time.monotonic()
        first_s, begun_s = self._begun
        ahead_s = (time_s - first_s) / speedup - (time.monotonic() - begun_s)
        time.sleep(max(ahead_s, 0.0))

    def look(self, *_: object) -> None:
        with suppress(queue.Empty):
            self._order(self.inbox.get_nowait()["what"])
        vehicle = self.vehicle
        link_loss = vehicle.link_loss
        words = vehicle.changed or vehicle.order.words
        lost_s = None
        if link_loss.seconds is not None:
            words = "; ".join(filter(None, (link_loss.words, words)))
            lost_s = round(link_loss.seconds)
        if self._ordered is None or self.obeyed != self._ordered:
            is_obeyed = self._ordered is not None and self._is_under_way(self._ordered)
            self.obeyed = self._ordered if is_obeyed else None
        obeyed = {"rtl": "it returns, as ordered", "land": "it lands, as ordered", None: ""}[self.obeyed]
        words = words or vehicle.conformance.why_not or obeyed
        words = words or ("it holds its position" if vehicle.order.is_held else vehicle.mode_change)
        words = words or vehicle.conformance.positions.words
        state = State(phase="flying", words=words or Stage.START, lost_s=lost_s)
        if state != self._state:
            self._state = state
            self.answer(state)

    def _is_under_way(self, order: InFlight) -> bool:
        modes = self.vehicle.autopilot.modes
        if order in ("rtl", "land"):
            return self.vehicle.state.custom_mode in (modes.returns if order == "rtl" else {modes.landing})
        return self.vehicle.order.is_held == (order == "hold")

    def _seen(self, position: Position, record: FlightRecord) -> Seen:
        reached = record.item_reached_s
        latest = record.path[-1]
        last = max(reached, default=None)
        self._forecast_orders(position, latest.time_s)
        return Seen(
            time_s=round(latest.time_s, 2),
            place=(position.longitude_deg, position.latitude_deg),
            up=round(position.height, 2),
            speed=round(latest.speed, 2),
            done=0 if last is None else last + 1,
            flown_s=None if last is None else round(reached[last], 2),
            expected_s=None if last is None else round(self._expected.get(last, reached[last]), 2),
            held=self.vehicle.order.is_held,
            orders=self._orders,
            battery_left=self.vehicle.state.battery_left,
            reserve=self._reserve,
            satellites=self._satellites,
            wind=self._wind,
            said=tuple(self._texts),
            deviations=tuple(map(str, self.vehicle.conformance.deviations)),
        )

    def _forecast_orders(self, position: Position, time_s: float) -> None:
        left = self.vehicle.state.battery_left
        if not self.vehicle.state.in_air:
            self._orders = ()
            self._reserve = None
        elif time_s - self._orders_s >= FORECAST_INTERVAL_S:
            self._orders_s = time_s
            forecast_s = time_s
            unknown = self._unknown
            if self._contingencies is not None:
                forecast_s, distance = self._contingencies.time_at(self._local(position), time_s)
                leaves = self.vehicle.mode_change and not self.vehicle.order.is_held
                is_off_path = distance > ContingenciesNow.off_path or leaves
                unknown = "it is off its planned path: orders from here are not forecast" if is_off_path else ""
            self._orders = tuple(self._each_order(forecast_s, unknown, position))
            self._reserve = None
            if self._budget is not None and left is not None and not unknown:
                self._reserve = self._budget.against_plan(left, forecast_s)

    def _each_order(self, forecast_s: float, unknown: str, position: Position) -> Iterator[OrderThen]:
        """Yield each order's effect from the actual position, or why it is `unknown`."""
        current = self.vehicle.state.current
        if self.vehicle.order.is_held:
            item = "" if current is None else f" with item {current.seq + 1 - self.vehicle.autopilot.seq_offset}"
            left_s = None if unknown else round(max(self.forecast.estimate.total_s - forecast_s, 0.0), 1)
            yield OrderThen(what="go_on", clear=None, words=unknown or f"as planned{item}", seconds=left_s)
        rows: dict[Contingency, tuple[ContingencyRow, float | None]] = {}
        if self._contingencies is not None and unknown:
            place = self._local(position)
            velocity = np.array([position.velocity[1], position.velocity[0], -position.velocity[2]])
            for contingency in (Contingency.HOLD, Contingency.LAND):
                rows[contingency] = self._contingencies.from_here(contingency, place, velocity), None
        elif self._contingencies is not None:
            rows = {row.contingency: (row, seconds) for row, seconds in self._contingencies.at(forecast_s)}
        for order, contingency in ORDERED.items():
            if self._is_under_way(order):
                continue
            if contingency in rows:
                row, seconds = rows[contingency]
                seconds = None if seconds is None else round(seconds, 1)
                yield OrderThen(what=order, clear=row.clear, words=f"{row.leads}: {row.keeps}", seconds=seconds)
            else:
                yield OrderThen(what=order, clear=None, words=unknown, seconds=None)

    def _local(self, position: Position) -> Vector:
        return self.forecast.frame.local(Geodetic(position.latitude_deg, position.longitude_deg, position.altitude))

    def _order(self, name: InFlight) -> None:
        order = self.vehicle.order
        modes = self.vehicle.autopilot.modes
        self._ordered = name if name == "rtl" or name == "land" else None
        match name:
            case "hold":
                order.hold()
            case "go_on":
                order.go_on()
            case "rtl":
                order.give(modes.returning)
            case "land":
                order.give(modes.landing)


if __name__ == "__main__":
    Worker(lambda inbox: {"fly": (FlightWorker(inbox).fly, "flight"), "listen": (listen, "flight")}).run()
