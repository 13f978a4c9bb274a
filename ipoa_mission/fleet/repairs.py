from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cache
from itertools import combinations
from math import ceil, floor, isnan
from typing import NamedTuple

import numpy as np

from ipoa_mission import Command, Item, Mission, MissionError, Severity, check_mission
from ipoa_mission.fleet.encounters import Conflict, Encounters, PlannedDeparture
from ipoa_mission.fleet.fleet import STEP_S, FleetVehicle
from ipoa_mission.geometry import Vector

LANDS = frozenset({Command.NAV_LAND, Command.NAV_VTOL_LAND, Command.NAV_RETURN_TO_LAUNCH})
HOLDS = frozenset({Command.NAV_WAYPOINT, Command.NAV_LOITER_TIME})  # their first parameter is a time [s]


@dataclass(frozen=True)
class RepairLimits:
    chance: float  # of a loss of separation, of a pair
    most_delay_s: float
    heights: tuple[float, ...] = (5.0, 10.0, 15.0, 20.0, 25.0, 30.0, 35.0, 40.0)  # added [m]
    most_height: float = 120.0  # [m]
    most_hold_s: float = 300.0
    hold_margins_s: tuple[float, ...] = (0.0, 2.0, 4.0)

    @property
    def delays(self) -> Vector:
        """Return each whole second up to `most_delay_s`, (n,)."""
        return np.arange(floor(self.most_delay_s) + 1.0)


class TimetableSlot(NamedTuple):
    vehicle: FleetVehicle
    departs_s: float
    added_s: float = 0.0  # to the flight as read, by delay and change

    @property
    def departure(self) -> PlannedDeparture:
        return PlannedDeparture(self.vehicle.flight, self.departs_s)


class Deconfliction:
    """Search a timetable: vehicles take slots one after the other, in several orders."""

    def __init__(self, planned: Sequence[TimetableSlot], separation: float, limits: RepairLimits) -> None:
        self.planned = planned
        self.encounters = Encounters(separation)
        self.limits = limits
        self.frame = planned[0].vehicle.mission.frame
        self._delays = limits.delays
        self._raised = cache(self._raised_by)

    def conflicts(self, slots: Sequence[TimetableSlot]) -> list[Conflict]:
        return self.encounters.conflicts([slot.departure for slot in slots])

    def timetable(self) -> list[TimetableSlot] | None:
        """Return a slot for each vehicle, of the least sum of added time found."""
        tried = (self._in_order(order, changes) for changes in (False, True) for order in self._orders())
        found = (slots for slots in tried if slots is not None)
        return min(found, key=lambda slots: sum(slot.added_s for slot in slots), default=None)

    def blocking_pair(self) -> tuple[str, str]:
        """Return the pair of the likeliest loss of separation at its best delay, else as planned."""
        delays = np.concatenate([-self._delays[::-1], self._delays])

        def difficulty(pair: tuple[PlannedDeparture, PlannedDeparture]) -> tuple[float, float]:
            probabilities = self.encounters.probabilities(*pair, delays)
            return float(probabilities.min()), float(probabilities[len(self._delays)])

        a, b = max(combinations([slot.departure for slot in self.planned], 2), key=difficulty)
        return a.flight.name, b.flight.name

    def _orders(self) -> Iterator[list[int]]:
        """Yield orders: as given, reversed, by the number of flights that each meets."""
        flights = [slot.vehicle.flight for slot in self.planned]
        met = [sum(bool(self.encounters.of(one, other)) for other in flights if other is not one) for one in flights]
        numbers = list(range(len(flights)))
        yield numbers
        yield numbers[::-1]
        yield sorted(numbers, key=lambda n: -met[n])
        yield sorted(numbers, key=lambda n: met[n])

    def _in_order(self, order: Sequence[int], changes: bool) -> list[TimetableSlot] | None:
        taken = dict[int, TimetableSlot]()
        for n in order:
            departures = [slot.departure for slot in taken.values()]
            slots = [slot for slot in self._slots(n, departures, changes) if slot is not None]
            if not slots:
                return None
            taken[n] = min(slots, key=lambda slot: slot.added_s)
        return [taken[n] for n in range(len(order))]

    def _slots(self, n: int, taken: Sequence[PlannedDeparture], changes: bool) -> Iterator[TimetableSlot | None]:
        """Yield clear slots; with `changes` also of a hold or a higher route."""
        delayed = self._slot(n, self.planned[n].vehicle, taken)
        yield delayed
        most_s = np.inf if delayed is None else delayed.added_s
        if not changes or most_s == 0.0:
            return
        for held_vehicle in self._held(n, taken, most_s):
            yield self._slot(n, held_vehicle, taken)
        for by in self.limits.heights:
            vehicle = self._raised(n, by)
            slot = None if vehicle is None else self._slot(n, vehicle, taken)
            yield slot
            if vehicle is None or (slot is not None and slot.departs_s == self.planned[n].departs_s):
                return

    def _slot(self, n: int, vehicle: FleetVehicle, taken: Sequence[PlannedDeparture]) -> TimetableSlot | None:
        planned = self.planned[n]
        departure = PlannedDeparture(vehicle.flight, planned.departs_s)
        free = np.ones(len(self._delays), dtype=bool)
        for other in taken:
            free &= self.encounters.probabilities(other, departure, self._delays) <= self.limits.chance
        if not free.any():
            return None
        delay = float(self._delays[np.argmax(free)])
        longer = STEP_S * (len(vehicle.flight.places) - len(planned.vehicle.flight.places))
        return TimetableSlot(vehicle, planned.departs_s + delay, delay + longer)

    def _held(self, n: int, taken: Sequence[PlannedDeparture], most_s: float) -> Iterator[FleetVehicle]:
        """Yield the vehicle with holds before its first conflict, at up to two waypoints."""
        vehicle = self.planned[n].vehicle
        departure = self.planned[n].departure
        chance = self.limits.chance
        conflicts = [
            (each.second, other) for other in taken for each in self.encounters.between(other, departure, chance)
        ]
        if not conflicts:
            return
        second, other = min(conflicts, key=lambda conflict: conflict[0])
        longer = np.arange(1.0, min(self.limits.most_hold_s, most_s))
        is_clear = self.encounters.probabilities(other, departure, longer) <= chance
        if not is_clear.any():
            return
        least_s = ceil(longer[np.argmax(is_clear)])
        for seq in holding_places(vehicle, second - departure.second)[-2:]:
            for margin_s in self.limits.hold_margins_s:
                hold_s = least_s + margin_s
                changed = self._changed(vehicle, held(vehicle.mission, seq, hold_s), f"hold {hold_s:g} s at item {seq}")
                if changed is not None:
                    yield changed

    def _raised_by(self, n: int, by: float) -> FleetVehicle | None:
        vehicle = self.planned[n].vehicle
        mission = raised(vehicle.mission, by, self.limits.most_height)
        return None if mission is None else self._changed(vehicle, mission, f"{by:g} m higher")

    def _changed(self, vehicle: FleetVehicle, mission: Mission, change: str) -> FleetVehicle | None:
        """Return None if the mission has new errors or an unknown path."""
        try:
            changed = vehicle.flying(mission, self.frame, change)
        except MissionError:
            return None
        return None if _errors(mission) - _errors(vehicle.mission) else changed


def _errors(mission: Mission) -> set[tuple[str, int | None]]:
    return {(found.code, found.seq) for found in check_mission(mission) if found.severity is Severity.ERROR}


def raised(mission: Mission, by: float, most_height: float) -> Mission | None:
    """Return the mission with its route `by` [m] higher; None above `most_height` or of unclear height."""
    items = list[Item]()
    for item in mission.items:
        higher = item
        if item.is_as_high_as_now(mission.autopilot):
            return None
        if item.moves and item.command not in LANDS and item.command != Command.NAV_DELAY:
            higher = replace(item, altitude=item.altitude + by)
            if not (item.is_takeoff or item.has_position) or higher.height(mission.home) > most_height:
                return None
        items.append(higher)
    return replace(mission, items=tuple(items))


def held(mission: Mission, seq: int, seconds: float) -> Mission:
    item = mission.items[seq - 1]
    hold_s = 0.0 if isnan(item.params[0]) else item.params[0]
    longer = replace(item, params=(hold_s + seconds, *item.params[1:]))
    return replace(mission, items=(*mission.items[: seq - 1], longer, *mission.items[seq:]))


def holding_places(vehicle: FleetVehicle, second: float) -> list[int]:
    """Return the numbers of waypoints that the vehicle leaves before a second of its flight."""
    ended = zip(vehicle.forecast.itinerary.visits, vehicle.forecast.expected.done.tolist(), strict=True)
    return [visit.seq for visit, at in ended if at < second and vehicle.mission.items[visit.seq - 1].command in HOLDS]
