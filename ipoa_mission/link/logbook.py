"""Record a flight from the messages of a vehicle, or of a log."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from typing import Protocol

from ipoa_mission.autopilot.autopilot import Autopilot
from ipoa_mission.autopilot.commands import LAST_NAV, MULTICOPTER_LANDINGS, Command
from ipoa_mission.geodesy import Geodetic, apart
from ipoa_mission.link import messages as m
from ipoa_mission.link.dialogue import Dialogue, Pause
from ipoa_mission.link.vehicle_state import IN_AIR_HEIGHT
from ipoa_mission.mission.flight_record import FlightRecord, Sample
from ipoa_mission.mission.items import Item
from ipoa_mission.progress import Progress, count, silent

LANDING_RADIUS = 20.0  # around the place of its LAND [m]


@dataclass
class _Recording:
    zero: float
    first: int
    reached: dict[int, float] = field(default_factory=dict)
    late: set[int] = field(default_factory=set)
    path: list[Sample] = field(default_factory=list)
    current: int = 0
    state: int = 0
    confirmed: bool = False
    mode: int | None = None
    disarming_s: float = -math.inf
    disarmed_s: float | None = None
    landed_in_link_loss: bool = False


class Logbook:
    """Messages of a vehicle as flights; one begins whenever the vehicle is armed."""

    def __init__(self, items: Sequence[Item], autopilot: Autopilot, armed: bool = False) -> None:
        self._items = tuple(items)
        self._autopilot = autopilot
        self._first = autopilot.seq_offset
        flown = [index for index, item in enumerate(items) if item.command < LAST_NAV]
        self._final = flown[-1] if flown else len(items) - 1
        self._texts: list[str] = []
        self.clock_s = 0.0  # since the vehicle's boot
        self._current = self._first
        self._flight: _Recording | None = None
        self._was_away = False
        self._gap_ends_s = 0.0
        self.armed = armed

    @property
    def lands(self) -> bool:
        return bool(self._items) and self._items[self._final].command in MULTICOPTER_LANDINGS

    @property
    def total(self) -> int:
        return len(self._items)

    @property
    def done(self) -> int:
        return max(self._flight.reached, default=-1) + 1 if self._flight else 0

    @property
    def disarmed_s(self) -> float | None:
        return self._flight.disarmed_s if self._flight else None

    @property
    def armed_s(self) -> float:
        """[s] on the vehicle's clock."""
        return self._flight.zero if self._flight else 0.0

    @property
    def modes(self) -> frozenset[int]:
        returns = bool(self._items) and self._items[self._final].command == Command.NAV_RETURN_TO_LAUNCH
        modes = self._autopilot.modes
        return frozenset({modes.mission}) | (modes.returns if returns else frozenset())

    @property
    def is_flown(self) -> bool:
        flight = self._flight
        return flight is not None and (flight.state == m.MissionState.COMPLETE or self._final in flight.reached)

    def note(self, message: m.Message) -> None:
        flight = self._flight
        match message:
            case m.Position(time_s=time_s) | m.LocalPosition(time_s=time_s) | m.Attitude(time_s=time_s):
                self._advance(time_s)
                if flight and isinstance(message, m.Position) and flight.disarmed_s is None:
                    place = (message.latitude_deg, message.longitude_deg, message.altitude, message.height)
                    flight.path.append(Sample(time_s - flight.zero, *place, math.hypot(*message.velocity)))
            case m.SystemTime(boot_s=time_s):
                self._advance(time_s)
            case m.CommandAck(number, m.CommandResult.ACCEPTED) if (
                number == Command.COMPONENT_ARM_DISARM and not self.armed
            ):
                self._begin()
            case m.Text(_, text):
                self._texts.append(text)
                if flight and text.startswith(("Disarming motors", "Disarmed")):  # earlier than the next heartbeat
                    flight.disarming_s = self.clock_s - flight.zero
            case m.Heartbeat():
                self._note_heartbeat(message)
            case m.Reached(seq) if flight and flight.disarmed_s is None:
                self._turn_to(flight, seq)
                self._note_done(flight, seq - self._first)
            case m.Current(seq, _, state):
                self._current = seq
                if flight and flight.disarmed_s is None:
                    self._turn_to(flight, seq)
                    flight.state = state

    def note_return(self) -> None:
        """Note the end of a link loss: the mode may say how a vehicle landed meanwhile."""
        self._was_away = True
        self.note_gap()

    def note_gap(self) -> None:
        self._gap_ends_s = math.inf

    def record(self) -> FlightRecord:
        flight = self._flight if self._flight and self._flight.confirmed else _Recording(self.clock_s, self._first)
        reached = {index: t for index, t in sorted(flight.reached.items()) if 0 <= index < len(self._items)}
        why_not = self._why_not(flight)
        if self.lands:
            reached.pop(self._final, None)
            if not why_not and flight.disarmed_s is not None:
                reached[self._final] = flight.disarmed_s
        last_s = self.clock_s - flight.zero if flight.disarmed_s is None else flight.disarmed_s
        end = last_s if self.lands else reached.get(self._final, last_s)
        in_air = self.armed and bool(flight.path) and flight.path[-1].height > IN_AIR_HEIGHT
        path = tuple(flight.path)
        record = FlightRecord(reached, end, path, tuple(self._texts), not why_not, why_not, self.armed, in_air)
        return replace(record, late_items=frozenset(flight.late - {self._final}))

    def _begin(self) -> None:
        self.armed = True
        self._gap_ends_s = 0.0
        self._texts.clear()
        self._flight = _Recording(self.clock_s, self._current, current=self._current)

    def _note_heartbeat(self, heartbeat: m.Heartbeat) -> None:
        if heartbeat.armed and not self.armed:
            self._begin()
        flight = self._flight
        if flight is None or flight.disarmed_s is not None:
            return
        since = self.clock_s - flight.zero
        if heartbeat.armed:
            flight.confirmed = True
            flight.mode = heartbeat.custom_mode
            self._was_away = False
        elif flight.confirmed:
            self.armed = False
            flight.landed_in_link_loss = self._was_away
            modes = self._autopilot.modes
            if self._was_away and heartbeat.custom_mode in modes.returns | {modes.landing}:
                flight.mode = heartbeat.custom_mode
            flight.disarmed_s = flight.disarming_s if since - flight.disarming_s < 2.0 else since
        elif since > 3.0:  # no heartbeat confirms the acknowledged arming
            self.armed = False
            self._flight = None

    def _advance(self, time_s: float) -> None:
        if math.isinf(self._gap_ends_s) and time_s > self.clock_s:
            self._gap_ends_s = time_s + 2.0
        self.clock_s = max(time_s, self.clock_s)

    def _note_done(self, flight: _Recording, index: int) -> None:
        if index not in flight.reached and self.clock_s < self._gap_ends_s:
            flight.late.add(index)
        flight.reached.setdefault(index, self.clock_s - flight.zero)

    def _turn_to(self, flight: _Recording, seq: int) -> None:
        if flight.current < seq < self._first + len(self._items):
            for index in range(flight.current - self._first, seq - self._first):
                self._note_done(flight, index)
        flight.current = max(flight.current, seq)

    def _why_not(self, flight: _Recording) -> str:
        if not self.lands:
            return "the mission ends in the air"
        if flight.disarmed_s is None:
            return "the vehicle is not down and disarmed"
        off_m = self._landing_offset(flight)
        mode = "" if flight.mode is None else f", in {self._autopilot.modes.name(flight.mode)}"
        if not (self.is_flown or flight.current >= self._final + self._first):
            item = f"item {flight.current + 1 - self._first} of {len(self._items)}"
            if flight.landed_in_link_loss:
                place = f", {off_m:.0f} m from the place of its LAND" if off_m else ""
                return f"it was last heard at {item}, and landed while the link was lost{place}{mode}"
            return f"it was disarmed at {item}{mode}"
        if flight.mode not in self.modes:
            return f"it left its mission before the landing{mode}"
        return f"it landed {off_m:.0f} m from the place of its LAND" if off_m > LANDING_RADIUS else ""

    def _landing_offset(self, flight: _Recording) -> float:
        """Return the horizontal distance from the place of a final LAND [m]."""
        last = self._items[self._final]
        if last.command != Command.NAV_LAND or not last.has_position or not flight.path:
            return 0.0
        end = flight.path[-1]
        return apart(Geodetic(end.latitude_deg, end.longitude_deg), Geodetic(last.latitude_deg, last.longitude_deg))


class Observer(Protocol):
    def observe(self, heard: m.Message, now_s: float) -> Dialogue[None]:
        """`now_s` is on the vehicle's clock."""


def watch(
    logbook: Logbook, progress: Progress = silent, *observers: Observer, is_over: Callable[[], bool] = lambda: False
) -> Dialogue[FlightRecord]:
    """The flight ends by landing, at a last item without one, or by `is_over`. The logbook hears before `observers`."""
    done = -1
    while True:
        heard = yield Pause(math.inf)
        assert heard is not None, "only a message ends the pause"
        if logbook.done != done:
            done = logbook.done
            count(progress, done, logbook.total, "item ")
        if logbook.disarmed_s is not None or (logbook.is_flown and not logbook.lands):
            return logbook.record()
        for observer in observers:
            yield from observer.observe(heard, logbook.clock_s)
        if is_over():
            return logbook.record()
