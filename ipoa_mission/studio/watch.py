import math
import queue
import time
from collections import deque
from collections.abc import Iterator
from contextlib import suppress
from typing import Literal

import numpy as np

from ipoa_mission.autopilot.returning import Contingency
from ipoa_mission.errors import MissionError
from ipoa_mission.flight.procedure import Stage
from ipoa_mission.forecast.contingency.contingencies_now import ContingenciesNow
from ipoa_mission.forecast.contingency.energy_budget import budget_of
from ipoa_mission.forecast.forecast import Forecast
from ipoa_mission.link.logbook import FlightRecord
from ipoa_mission.link.messages import Message, Text
from ipoa_mission.link.telemetry import Gps, Position, WindEstimate, WindVelocity
from ipoa_mission.link.vehicle import Vehicle
from ipoa_mission.studio.flight_answers import OrderThen, Reserve, Seen, State
from ipoa_mission.studio.harness import Answer, Order
from ipoa_mission.studio.vocabulary import InFlight
from ipoa_mission.world.frame import Geodetic

POSITION_INTERVAL_S = 0.2  # by the vehicle's clock
FORECAST_INTERVAL_S = 1.0
FORECAST_DISTANCE = 10.0  # from the planned position [m]
MESSAGE_LIMIT = 6
ORDERED: dict[InFlight, Contingency] = {"hold": Contingency.HOLD, "rtl": Contingency.RTL, "land": Contingency.LAND}
OBEYED = {"rtl": "it returns, as ordered", "land": "it lands, as ordered"}
NO_MODEL = "the flight has no forecast"


class Watch:
    """Watch a vehicle; send orders from `beside`. `speedup`: of the built-in autopilot, which has no clock."""

    def __init__(
        self,
        forecast: Forecast,
        vehicle: Vehicle,
        answer: Answer,
        speedup: float | None,
        beside: "queue.SimpleQueue[Order]",
    ) -> None:
        self._forecast, self._vehicle, self._answer = forecast, vehicle, answer
        self._speedup, self._beside = speedup, beside
        self._endings: ContingenciesNow | None = None
        self._unknown = "no scenario gives the obstacles here" if forecast.scenario is None else NO_MODEL
        if forecast.scenario is not None:
            with suppress(MissionError):
                self._endings = ContingenciesNow(forecast, tuple(ORDERED.values()))
        self._budget = None if forecast.scenario is None else budget_of(forecast)
        self._expected = {item.seq - 1: item.done_s for item in forecast.estimate.items}
        self._then: tuple[tuple[OrderThen, ...], Reserve | None] = ((), None)
        self._then_s, self._told_s = -FORECAST_INTERVAL_S, -POSITION_INTERVAL_S
        self._told: tuple[str, float | None] = ("", None)
        self._said: deque[str] = deque(maxlen=MESSAGE_LIMIT)
        self._satellites: int | None = None
        self._wind: tuple[float, float] | None = None
        self._begun: tuple[float, float] | None = None
        self._ordered: Literal["rtl", "land"] | None = None
        self.obeyed: Literal["rtl", "land"] | None = None
        """The page's order by which the vehicle ends its flight, if there is one."""

    @property
    def is_held(self) -> bool:
        vehicle = self._vehicle
        return vehicle.order.is_paused or vehicle.state.custom_mode == vehicle.autopilot.modes.hold

    def hear(self, message: Message) -> None:
        """Handle a message; one without a position may still require landing earlier."""
        self.look()
        vehicle = self._vehicle
        match message:
            case Text(_, text):
                self._said.appendleft(text.strip())
            case Gps():
                self._satellites = message.satellites_visible
            case WindEstimate():
                self._wind = round(message.speed, 1), round(message.direction_deg % 360.0)
            case WindVelocity((north, east, _)):
                self._wind = round(math.hypot(north, east), 1), round(math.degrees(math.atan2(-east, -north)) % 360.0)
            case Position() if vehicle.state.armed and message.time_s - self._told_s >= POSITION_INTERVAL_S:
                self._told_s = message.time_s
                self._keep_pace(message.time_s)
                record = vehicle.record()
                if record.path:
                    self._answer(self._seen(message, record))

    def look(self, *_: object) -> None:
        with suppress(queue.Empty):
            self._order(self._beside.get_nowait()["what"])
        vehicle, absence = self._vehicle, self._vehicle.absence
        words, lost_s = vehicle.changed or vehicle.order.words, None
        if absence.seconds is not None:
            words, lost_s = "; ".join(filter(None, (absence.words, words))), round(absence.seconds)
        self.obeyed = self._obeyed(vehicle.state.custom_mode)
        words = words or vehicle.conformance.why_not or (OBEYED[self.obeyed] if self.obeyed else "")
        words = words or ("it holds its place" if self.is_held else vehicle.interrupted)
        if (words, lost_s) != self._told:
            self._told = words, lost_s
            self._answer(State(phase="flying", words=words or Stage.START, lost_s=lost_s))

    def _obeyed(self, mode: int | None) -> Literal["rtl", "land"] | None:
        """Return the order that ends the flight, once the vehicle was in its mode."""
        modes = self._vehicle.autopilot.modes
        by = {"rtl": modes.returns, "land": modes.lands}
        is_obeyed = self._ordered is not None and (mode in by[self._ordered] or self.obeyed == self._ordered)
        return self._ordered if is_obeyed else None

    def _seen(self, at: Position, record: FlightRecord) -> Seen:
        reached = record.item_reached_s
        last = max(reached, default=None)
        orders, reserve = self._orders_then(at, record.path[-1].time_s)
        return Seen(
            time_s=round(record.path[-1].time_s, 2),
            place=(at.longitude_deg, at.latitude_deg),
            up=round(at.height, 2),
            speed=round(record.path[-1].speed, 2),
            done=0 if last is None else last + 1,
            flown_s=None if last is None else round(reached[last], 2),
            expected_s=None if last is None else round(self._expected.get(last, reached[last]), 2),
            held=self.is_held,
            orders=orders,
            reserve=reserve,
            satellites=self._satellites,
            wind=self._wind,
            said=tuple(self._said),
            deviations=tuple(map(str, self._vehicle.conformance.deviations)),
        )

    def _orders_then(self, at: Position, time_s: float) -> tuple[tuple[OrderThen, ...], Reserve | None]:
        state = self._vehicle.state
        if not state.in_air:
            return (), None if state.battery_left is None else Reserve(left=state.battery_left)
        if time_s - self._then_s >= FORECAST_INTERVAL_S:
            self._then_s, now = time_s, time_s
            unknown = self._unknown
            if self._endings is not None:
                place = self._forecast.frame.local(Geodetic(at.latitude_deg, at.longitude_deg, at.altitude))
                now, aside = self._endings.time_at(place, time_s)
                is_away = aside > FORECAST_DISTANCE or (self._vehicle.interrupted and not self.is_held)
                unknown = "it is off its planned path: orders from here are not forecast" if is_away else ""
            self._then = tuple(self._each_order(now, unknown, at)), self._reserve(now, bool(unknown))
        return self._then

    def _each_order(self, now: float, unknown: str, at: Position) -> Iterator[OrderThen]:
        """Yield each order's effect, or why it is `unknown`; hold and land are checked from the actual position."""
        mode, modes = self._vehicle.state.custom_mode, self._vehicle.autopilot.modes
        done = {"hold": self.is_held, "rtl": mode in modes.returns, "land": mode in modes.lands}
        offered: list[InFlight] = [what for what in ORDERED if not done[what]]
        if self.is_held:
            yield self._go_on(now, unknown)
        if self._endings is None:
            yield from (OrderThen(what=what, clear=None, words=unknown, seconds=None) for what in offered)
            return
        told = {} if unknown else {row.contingency: (row, seconds) for row, seconds in self._endings.at(now)}
        if unknown:
            place = self._forecast.frame.local(Geodetic(at.latitude_deg, at.longitude_deg, at.altitude))
            velocity = np.array([at.velocity[1], at.velocity[0]])
            here = (Contingency.HOLD, Contingency.LAND)
            told = {ending: (self._endings.from_here(ending, place, velocity), None) for ending in here}
        for what in offered:
            if ORDERED[what] not in told:
                yield OrderThen(what=what, clear=None, words=unknown, seconds=None)
                continue
            row, seconds = told[ORDERED[what]]
            words = f"{row.leads}: {row.keeps}"
            yield OrderThen(
                what=what, clear=row.clear, words=words, seconds=None if seconds is None else round(seconds, 1)
            )

    def _go_on(self, now: float, unknown: str) -> OrderThen:
        left = self._forecast.estimate.total_s - now
        current = self._vehicle.state.current
        item = "" if current is None else f" with item {current.seq + 1 - self._vehicle.autopilot.counts_home}"
        seconds = None if unknown else round(max(left, 0.0), 1)
        return OrderThen(what="go_on", clear=None, words=unknown or f"as planned{item}", seconds=seconds)

    def _reserve(self, now: float, is_elsewhere: bool) -> Reserve | None:
        left = self._vehicle.state.battery_left
        if left is None:
            return None
        plan = None if self._budget is None or is_elsewhere else self._budget.against_plan(left, now)
        if plan is None:
            return Reserve(left=left)
        lands = plan.lands
        return Reserve(
            left=left,
            planned=round(plan.planned, 3),
            lands=round(lands.likely, 3),
            least=round(lands.low, 3),
            most=round(lands.high, 3),
            required=plan.reserve,
        )

    def _order(self, what: InFlight) -> None:
        order, modes = self._vehicle.order, self._vehicle.autopilot.modes
        self._ordered = what if what == "rtl" or what == "land" else None
        match what:
            case "hold":
                order.hold()
            case "go_on":
                order.go_on()
            case "rtl":
                order.give(modes.returning)
            case "land":
                order.give(min(modes.lands))

    def _keep_pace(self, now_s: float) -> None:
        if self._speedup is None:
            return
        if self._begun is None:
            self._begun = (now_s, time.monotonic())
        first_s, begun = self._begun
        ahead = (now_s - first_s) / self._speedup - (time.monotonic() - begun)
        if ahead > 0:
            time.sleep(ahead)
