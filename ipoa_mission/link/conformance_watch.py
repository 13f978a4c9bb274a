import logging
import math
from collections.abc import Callable
from dataclasses import replace
from enum import StrEnum
from typing import TYPE_CHECKING

from ipoa_mission.link.dialogue import Dialogue
from ipoa_mission.link.flight_order import FlightOrder
from ipoa_mission.link.logbook import Logbook
from ipoa_mission.link.messages import Message
from ipoa_mission.link.telemetry import Position
from ipoa_mission.link.vehicle_state import VehicleState
from ipoa_mission.world.frame import Geodetic


class OnDeviation(StrEnum):
    HOLD = "hold"
    RTL = "rtl"
    REPORT = "report"


if TYPE_CHECKING:
    from ipoa_mission.forecast.conformance import ConformanceMonitor, Deviation

log = logging.getLogger(__name__)
COMPARE_INTERVAL_S = 0.2  # [s] of the vehicle's clock


class Conformance:
    """React to deviations of one vehicle's flight.

    Attributes:
        tell: called with each deviation; its time counts from the arming [s].
        ends_held: whether watching ends when a deviation holds the vehicle.
    """

    def __init__(self, state: VehicleState, order: FlightOrder) -> None:
        self.on_deviation = OnDeviation.HOLD
        self.tell: Callable[[Deviation], None] = lambda deviation: None
        self.ends_held = True
        self.deviations: list[Deviation] = []
        self._state, self._order = state, order
        self._monitor: ConformanceMonitor | None = None
        self._logbook: Logbook | None = None
        self._seen_s = -math.inf
        self._is_ordered = False

    def compare(self, monitor: "ConformanceMonitor | None") -> None:
        self._monitor, self._seen_s, self._is_ordered = monitor, -math.inf, False
        self.deviations.clear()

    def of(self, logbook: Logbook) -> "Conformance":
        self._logbook = logbook
        return self

    @property
    def is_held(self) -> bool:
        holds = self._order.is_paused or self._state.custom_mode == self._state.autopilot.modes.hold
        return self._is_ordered and self.on_deviation is OnDeviation.HOLD and holds

    @property
    def is_over(self) -> bool:
        return self.ends_held and self.is_held

    @property
    def why_not(self) -> str:
        if not self._is_ordered:
            return ""
        what = "it holds" if self.is_held else f"{self.on_deviation} was ordered"
        return f"{what}, because {self.deviations[-1]}"

    def look(self, heard: Message, now_s: float) -> Dialogue[None]:
        yield from ()
        if self._monitor is None or not isinstance(heard, Position) or heard.time_s - self._seen_s < COMPARE_INTERVAL_S:
            return
        self._seen_s = heard.time_s
        if not self._state.in_air:
            return
        if not self._flies_mission:
            self._monitor.interrupt()
            return
        if self._is_ordered and self._order.is_under_way:
            return  # ignore deviations until the vehicle obeys
        if self._state.custom_mode == self._state.autopilot.modes.mission:
            self._is_ordered = False  # refused, or the mission was resumed
        place = self._monitor.local(Geodetic(heard.latitude_deg, heard.longitude_deg, heard.altitude), heard.height)
        if (deviation := self._monitor.see(heard.time_s, place, self._item)) is not None:
            self._deviates(deviation)

    @property
    def _flies_mission(self) -> bool:
        mode, modes = self._state.custom_mode, self._state.autopilot.modes
        return not self._order.is_paused and (mode == modes.mission or self._returns_at_its_end)

    @property
    def _returns_at_its_end(self) -> bool:
        logbook, mode = self._logbook, self._state.custom_mode
        if logbook is None or mode not in logbook.modes & self._state.autopilot.modes.returns:
            return False
        return logbook.is_flown or logbook.done >= logbook.total - 1

    @property
    def _item(self) -> int | None:
        current, home = self._state.current, self._state.autopilot.counts_home
        if self._logbook is not None and self._returns_at_its_end:
            return self._logbook.total - 1
        return None if current is None else current.seq - home

    def _deviates(self, deviation: "Deviation") -> None:
        armed_s = 0.0 if self._logbook is None else self._logbook.armed_s
        deviation = replace(deviation, time_s=deviation.time_s - armed_s)
        self.deviations.append(deviation)
        is_ordered = self.on_deviation is not OnDeviation.REPORT and not self._is_ordered
        log.warning("%s%s", deviation, f"; {self.on_deviation} is ordered" if is_ordered else "")
        self.tell(deviation)
        if not is_ordered:
            return
        self._is_ordered = True
        if self.on_deviation is OnDeviation.HOLD:
            self._order.hold()
        else:
            self._order.give(self._state.autopilot.modes.returning)
