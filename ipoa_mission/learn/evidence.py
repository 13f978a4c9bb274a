from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from ipoa_mission import Geodetic, Mission
from ipoa_mission.autopilot.autopilot import Autopilot
from ipoa_mission.autopilot.commands import MULTICOPTER_LANDINGS
from ipoa_mission.autopilot.learned import LearnedVehicle
from ipoa_mission.errors import MissionError
from ipoa_mission.forecast.forecast import Forecast
from ipoa_mission.forecast.timing.flight_model import FlightModel
from ipoa_mission.geometry import Vector
from ipoa_mission.learn.flight_measurements import FlightMeasurements, measure_flight
from ipoa_mission.logs.flight_log import LoggedFlight, read_flights
from ipoa_mission.wind import Wind


@dataclass(frozen=True, eq=False)
class Evidence:
    """A flight on a vehicle with its parameters; without a mission it has no items.

    `seconds` (n,) since the last logged visit, `scatter` (n,) their deviations [s].
    """

    name: str
    mission: Mission
    visits: tuple[int, ...]
    seconds: Vector
    scatter: Vector
    measured: FlightMeasurements = field(default_factory=FlightMeasurements)

    def energy(self, vehicle: LearnedVehicle) -> float | None:
        """Return the mission's energy in the lean's wind [Wh]; None: unknown."""
        if not self.visits or vehicle.hover_power is None:
            return None
        forecast = Forecast(replace(self.mission, vehicle=vehicle), wind=Wind.towards_north_east(*self.measured.wind))
        if self.visits[-1] + 1 < len(forecast.itinerary.visits):
            return None
        return None if forecast.energy is None else forecast.energy.energy_wh

    def forecast(self, vehicle: LearnedVehicle | None) -> Vector:
        """Return the items' durations on this vehicle (n,) [s]."""
        if not self.visits:
            return np.empty(0)
        forecast = Forecast(replace(self.mission, vehicle=vehicle))
        done = self.mission.autopilot.part(FlightModel).median_times(forecast.itinerary, forecast.mission)
        return np.diff(done[list(self.visits)], prepend=0.0)


def evidence_of(name: str, flight: LoggedFlight, mission: Mission | None = None) -> Evidence:
    """`mission` where the log has none; refuse an unknown one, or too few items."""
    flown = mission or flight.mission
    if flown is None:
        raise MissionError("it does not have the mission that was flown", code="log-incomplete", place=name)
    version = flight.firmware_version or flown.firmware_version
    flown = replace(flown.with_parameters(flight.parameters), firmware_version=version)
    return evidence_between(name, flown, flight.record(flown).item_reached_s)


def evidence_between(name: str, mission: Mission, done_s: Mapping[int, float]) -> Evidence:
    """`done_s`: when items were done [s since arming], by index; refuse too few."""
    visits, done, met = [], [], set[int]()
    route = Forecast(mission).itinerary
    for n, visit in enumerate(route.visits):
        at = done_s.get(visit.seq - 1)
        if at is not None and visit.seq not in met:
            visits.append(n)
            done.append(at)
        met.add(visit.seq)
    if len(visits) < 2 or min(done_s) > 0:
        words = f"it has the times of {len(visits)} of {len(mission.items)} items"
        raise MissionError(words, code="log-incomplete", place=name)
    seconds = np.diff(done, prepend=0.0)
    least, share, landing = mission.autopilot.part(FlightModel).scatter
    ends = np.array([route.visits[n].item.command in MULTICOPTER_LANDINGS for n in visits])
    return Evidence(name, mission, tuple(visits), seconds, np.where(ends, landing, least) + share * seconds)


def errors(flights: Sequence[Evidence], vehicle: LearnedVehicle | None) -> Vector:
    """Return forecast minus flown durations (m,) [s]."""
    return _joined(flight.forecast(vehicle) - flight.seconds for flight in flights)


def scatter(flights: Sequence[Evidence]) -> Vector:
    """Return the standard deviations of `errors` (m,) [s]."""
    return _joined(flight.scatter for flight in flights)


def _joined(parts: Iterable[Vector]) -> Vector:
    return np.concatenate([*parts, np.empty(0)])


def flights_in(
    path: Path, read: Callable[[Autopilot], Mission] | None = None, system: int | None = None
) -> tuple[list[Evidence], list[str], str, Autopilot]:
    """Return usable flights, remarks, version and autopilot; `read` returns a mission where the log has none."""
    log = read_flights(path, system)
    mission = None if read is None else read(log.autopilot)
    usable, left_out = [], [*log.remarks, *filter(None, [log.autopilot.beyond_the_model(log.version)])]
    for number, flight in enumerate(log.flights, 1):
        name = f"{path.name}, flight {number}" if len(log.flights) > 1 else path.name
        measured = measure_flight(flight)
        evidence = Evidence(name, Mission(Geodetic(0.0, 0.0, 0.0), (), log.autopilot), (), np.empty(0), np.empty(0))
        try:
            if flight.in_mission:
                evidence = evidence_of(name, flight, mission)
            else:
                left_out.append(f"{name}: not in a mission")
        except MissionError as error:
            left_out.append(str(error))
        if evidence.visits or measured.log_drag or measured.hover_w:
            usable.append(replace(evidence, measured=measured))
        else:
            left_out += [f"{name}: {reason}" for reason in measured.reasons.values()]
    return usable, left_out, log.version, log.autopilot
