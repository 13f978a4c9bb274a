"""The departures, holds and heights of least added time at which each pair keeps its separation."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import count
from math import ceil

import numpy as np

from ipoa_mission import Command, Item, Mission, MissionError, Severity, check_mission
from ipoa_mission.fleet.fleet import Fleet, FleetVehicle
from ipoa_mission.fleet.traffic import Encounters, PlannedDeparture
from ipoa_mission.geometry import Vector

LANDS = frozenset({Command.NAV_LAND, Command.NAV_VTOL_LAND, Command.NAV_RETURN_TO_LAUNCH})
HOLDS = frozenset({Command.NAV_WAYPOINT, Command.NAV_LOITER_TIME})  # their first parameter is a time [s]


@dataclass(frozen=True)
class RepairLimits:
    """Of a repair: greatest probability of a pair, longest delay [s], steps of height and greatest height [m]."""

    chance: float
    most_delay_s: float
    delay_step_s: float = 1.0
    height_step: float = 5.0
    height_steps: int = 8
    most_height: float = 120.0
    most_hold_s: float = 300.0
    hold_margin_s: float = 2.0


@dataclass(frozen=True, eq=False)
class TimetableSlot:
    """A vehicle's mission and departure in a timetable, and the time that they add to its flight as read [s]."""

    vehicle: FleetVehicle
    departure: PlannedDeparture
    added_s: float


@dataclass(frozen=True, eq=False)
class Timetable:
    """One slot for each vehicle of the fleet, in its order."""

    slots: tuple[TimetableSlot, ...]

    @property
    def added_s(self) -> float:
        return sum(slot.added_s for slot in self.slots)

    @property
    def departures(self) -> list[PlannedDeparture]:
        return [slot.departure for slot in self.slots]

    def fleet(self, fleet: Fleet) -> Fleet:
        return replace(fleet, vehicles=tuple(slot.vehicle for slot in self.slots))


class Deconfliction:
    """The search for a timetable: vehicles take their slots one after the other, in several orders."""

    def __init__(self, fleet: Fleet, earliest: Vector, encounters: Encounters, limits: RepairLimits) -> None:
        self.fleet = fleet
        self.encounters = encounters
        self.limits = limits
        self.planned = [
            PlannedDeparture(vehicle.flight, second)
            for vehicle, second in zip(fleet.vehicles, earliest.tolist(), strict=True)
        ]
        self._delays = np.arange(0.0, limits.most_delay_s + limits.delay_step_s, limits.delay_step_s)
        self._raised = dict[tuple[int, float], FleetVehicle | None]()

    def timetable(self) -> Timetable | None:
        """Return the timetable of least added time that is shown to hold as its missions are written; None: none."""
        tried = (self._in_order(order, changes) for changes in (False, True) for order in self._orders())
        found = [timetable for timetable in tried if timetable is not None]
        for timetable in sorted(found, key=lambda timetable: timetable.added_s):
            written = self._as_written(timetable)
            if max(self.encounters.pairs(written.departures).values()) <= self.limits.chance:
                return written
        return None

    def blocking_pair(self) -> tuple[str, str]:
        """Return the pair that loses separation most probably at its best delay, else as planned."""
        pairs = self.encounters.pairs(self.planned)
        departures = {departure.flight.name: departure for departure in self.planned}

        def difficulty(pair: tuple[str, str]) -> tuple[float, float]:
            a, b = (departures[name] for name in pair)
            both = np.concatenate([-self._delays[::-1], self._delays])
            return float(self.encounters.probabilities(a, b, both).min()), pairs[pair]

        return max(pairs, key=difficulty)

    def _orders(self) -> Iterator[list[int]]:
        """Yield orders: as given, reversed, and by the number of other flights that each meets."""
        numbers = list(range(len(self.planned)))
        yield numbers
        yield numbers[::-1]
        flights = [departure.flight for departure in self.planned]
        met = {
            n: sum(bool(self.encounters.of(flights[n], other)) for other in flights[:n] + flights[n + 1 :])
            for n in numbers
        }
        yield sorted(numbers, key=lambda n: -met[n])
        yield sorted(numbers, key=lambda n: met[n])

    def _in_order(self, order: Sequence[int], changes: bool) -> Timetable | None:
        taken = dict[int, TimetableSlot]()
        for n in order:
            slot = self._cheapest(n, [slot.departure for slot in taken.values()], changes)
            if slot is None:
                return None
            taken[n] = slot
        return Timetable(tuple(taken[n] for n in range(len(order))))

    def _cheapest(self, n: int, taken: Sequence[PlannedDeparture], changes: bool) -> TimetableSlot | None:
        """Return vehicle n's slot of least added time, clear of those taken; `changes`: also of its mission."""
        delayed = self._slot(n, self.fleet.vehicles[n], taken)
        slots = [delayed]
        if changes and (delayed is None or delayed.added_s > 0.0):
            most_s = np.inf if delayed is None else delayed.added_s
            slots += [self._slot(n, vehicle, taken) for vehicle in self._held(n, taken, most_s)]
            slots += self._higher(n, taken)
        return min((slot for slot in slots if slot is not None), key=lambda slot: slot.added_s, default=None)

    def _slot(self, n: int, vehicle: FleetVehicle, taken: Sequence[PlannedDeparture]) -> TimetableSlot | None:
        """Return the earliest departure of vehicle n, with this mission, clear of those taken."""
        departure = replace(self.planned[n], flight=vehicle.flight)
        free = np.ones(len(self._delays), dtype=bool)
        for other in taken:
            free &= self.encounters.probabilities(other, departure, self._delays) <= self.limits.chance
        if not free.any():
            return None
        delay = float(self._delays[np.argmax(free)])
        longer = vehicle.flight.duration_s - self.fleet.vehicles[n].flight.duration_s
        return TimetableSlot(vehicle, replace(departure, second=departure.second + delay), delay + longer)

    def _higher(self, n: int, taken: Sequence[PlannedDeparture]) -> Iterator[TimetableSlot | None]:
        """Yield slots of the whole route raised, until one needs no delay."""
        for step in range(1, self.limits.height_steps + 1):
            vehicle = self._raised_by(n, step * self.limits.height_step)
            slot = None if vehicle is None else self._slot(n, vehicle, taken)
            yield slot
            if vehicle is None or (slot is not None and slot.departure.second == self.planned[n].second):
                return

    def _raised_by(self, n: int, by: float) -> FleetVehicle | None:
        if (n, by) not in self._raised:
            vehicle = self.fleet.vehicles[n]
            mission = raised(vehicle.mission, by, self.limits.most_height)
            self._raised[n, by] = None if mission is None else self._changed(vehicle, mission, f"{by:g} m higher")
        return self._raised[n, by]

    def _held(self, n: int, taken: Sequence[PlannedDeparture], most_s: float) -> Iterator[FleetVehicle]:
        """Yield the vehicle with a hold of up to `most_s` before its first conflict, at up to two waypoints."""
        vehicle = self.fleet.vehicles[n]
        departure = self.planned[n]
        met = [
            (each.second, n)
            for n, one in enumerate(taken)
            for each in self.encounters.between(one, departure, self.limits.chance)
        ]
        if not met:
            return
        second, blocking = min(met)
        other = taken[blocking]
        longer = np.arange(1.0, min(self.limits.most_hold_s, most_s))
        free = self.encounters.probabilities(other, departure, longer) <= self.limits.chance
        if not free.any():
            return
        seconds = ceil(longer[np.argmax(free)])
        for seq in holding_places(vehicle, second - departure.second)[-2:]:
            for more in count():
                hold = seconds + more * self.limits.hold_margin_s
                mission = held(vehicle.mission, seq, hold)
                changed = self._changed(vehicle, mission, f"hold {hold:g} s at item {seq}")
                if changed is None or more == 3:
                    break
                yield changed

    def _changed(self, vehicle: FleetVehicle, mission: Mission, change: str) -> FleetVehicle | None:
        """Return the vehicle with another mission; None if that has errors or an unknown path, unlike the first."""
        try:
            changed = vehicle.flying(mission, self.fleet.frame, change)
        except MissionError:
            return None
        return None if _errors(mission) - _errors(vehicle.mission) else changed

    def _as_written(self, timetable: Timetable) -> Timetable:
        return Timetable(
            tuple(self._slot_as_written(slot) if slot.vehicle.change else slot for slot in timetable.slots)
        )

    def _slot_as_written(self, slot: TimetableSlot) -> TimetableSlot:
        mission, _ = slot.vehicle.written()
        vehicle = slot.vehicle.flying(mission, self.fleet.frame, slot.vehicle.change)
        return replace(slot, vehicle=vehicle, departure=replace(slot.departure, flight=vehicle.flight))


def _errors(mission: Mission) -> set[tuple[str, int | None]]:
    findings = check_mission(mission)
    return {(finding.code, finding.seq) for finding in findings if finding.severity is Severity.ERROR}


def raised(mission: Mission, by: float, most_height: float) -> Mission | None:
    """Return the mission with all between take-off and landing `by` [m] higher; None above `most_height` or unclear."""
    items = [None if item.is_as_high_as_now(mission.autopilot) else _raised(item, by) for item in mission.items]
    flown = [item for item in items if item is not None]
    heights = [item.height(mission.home) for item in flown if item.moves and item.command not in LANDS]
    if len(flown) < len(items) or max(heights, default=0.0) > most_height:
        return None
    return replace(mission, items=tuple(flown))


def _raised(item: Item, by: float) -> Item | None:
    if not item.moves or item.command in LANDS or item.command == Command.NAV_DELAY:
        return item
    return replace(item, altitude=item.altitude + by) if item.is_takeoff or item.has_position else None


def held(mission: Mission, seq: int, seconds: float) -> Mission:
    """Return the mission with a longer hold at item `seq`."""
    item = mission.items[seq - 1]
    hold, *others = item.params
    longer = replace(item, params=(hold + seconds, others[0], others[1], others[2]))
    return replace(mission, items=(*mission.items[: seq - 1], longer, *mission.items[seq:]))


def holding_places(vehicle: FleetVehicle, second: float) -> list[int]:
    """Return the waypoints that the vehicle leaves before a second of its flight, in this order."""
    visits = vehicle.forecast.itinerary.visits
    done = vehicle.forecast.expected.done
    items = vehicle.mission.items
    return [
        visit.seq
        for visit, at in zip(visits, done.tolist(), strict=True)
        if at < second and items[visit.seq - 1].command in HOLDS
    ]
