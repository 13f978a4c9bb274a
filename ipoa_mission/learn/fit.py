"""Read flights as evidence, and fit a vehicle to them by least squares.

The prior is the simulated vehicle (`PRIOR_DEVIATIONS`).
"""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
from scipy.optimize import least_squares

from ipoa_mission import Autopilot, Forecast, Geodetic, Mission, Wind
from ipoa_mission.autopilot.commands import MULTICOPTER_LANDINGS
from ipoa_mission.autopilot.learned import Learned, LearnedVehicle
from ipoa_mission.errors import LogUseless, MissionError
from ipoa_mission.forecast.timing.flight_model import Z_90, FlightModel
from ipoa_mission.geometry import Matrix, Vector
from ipoa_mission.learn import flight_measurements
from ipoa_mission.learn.flight_measurements import FlightMeasurements
from ipoa_mission.logs.flight_log import LoggedFlight, read_flights

#: Of logarithms, and of delays [s].
PRIOR_DEVIATIONS = {"drag": 0.7, "lag": 0.7, "lift_delay": 1.5, "landing_delay": 4.0}


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
        """Return the mission's energy in the wind that its tilt shows [Wh]; None: unknown."""
        if not self.visits or vehicle.hover_power is None:
            return None
        north, east = self.measured.wind
        forecast = Forecast(replace(self.mission, vehicle=vehicle), wind=Wind.of_velocity(east, north))
        if self.visits[-1] + 1 < len(forecast.itinerary.visits):
            return None
        return None if forecast.energy is None else forecast.energy.energy_wh

    def forecast(self, vehicle: LearnedVehicle | None) -> Vector:
        """Return the items' durations on this vehicle (n,) [s]."""
        if not self.visits:
            return np.empty(0)
        forecast = Forecast(replace(self.mission, vehicle=vehicle))
        done = self.mission.autopilot.part(FlightModel).median_times(forecast.itinerary)
        return np.diff(done[list(self.visits)], prepend=0.0)


def _evidence_of(name: str, flight: LoggedFlight, mission: Mission | None) -> Evidence:
    flown = mission or flight.mission
    if flown is None:
        raise MissionError("it does not have the mission that was flown", code="log-incomplete", place=name)
    version = flight.firmware_version or flown.firmware_version
    flown = replace(flown.with_parameters(flight.parameters), firmware_version=version)
    return evidence_between(name, flown, flight.record(flown).timed_items_s)


def evidence_between(name: str, mission: Mission, done_s: Mapping[int, float]) -> Evidence:
    """`done_s`: when items were done [s since arming], by index; refuse too few."""
    visits = []
    done = []
    met = set[int]()
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
    return np.concatenate([*(flight.forecast(vehicle) - flight.seconds for flight in flights), np.empty(0)])


def flights_in(
    path: Path, read: Callable[[Autopilot], Mission] | None = None, system: int | None = None
) -> tuple[list[Evidence], list[str], str, Autopilot]:
    """Return usable flights, remarks, version and autopilot; `read` gives missions that the log lacks."""
    log = read_flights(path, system)
    mission = None if read is None else read(log.autopilot)
    usable = []
    left_out = [*log.remarks, *filter(None, [log.autopilot.beyond_the_model(log.version)])]
    for number, flight in enumerate(log.flights, 1):
        name = f"{path.name}, flight {number}" if len(log.flights) > 1 else path.name
        measured = flight_measurements.measure_flight(flight)
        evidence = Evidence(name, Mission(Geodetic(0.0, 0.0, 0.0), (), log.autopilot), (), np.empty(0), np.empty(0))
        try:
            if flight.in_mission:
                evidence = _evidence_of(name, flight, mission)
            else:
                left_out.append(f"{name}: not in a mission")
        except MissionError as error:
            left_out.append(str(error))
        if evidence.visits or measured.log_drag or measured.hover_w:
            usable.append(replace(evidence, measured=measured))
        else:
            left_out += [f"{name}: {reason}" for reason in measured.reasons.values()]
    return usable, left_out, log.version, log.autopilot


def fit(flights: Sequence[Evidence]) -> LearnedVehicle:
    """Unknown parameters are None; all unknown are an error."""
    autopilot = flights[0].mission.autopilot
    blank = LearnedVehicle(autopilot, flights=len(flights))
    names = tuple(PRIOR_DEVIATIONS)
    known = tuple(
        name
        for name, value, deviation in zip(names, *_solve(flights, blank, names), strict=True)
        if deviation < 0.5 * PRIOR_DEVIATIONS[name] and abs(value) > Z_90 * deviation
    )
    power = flight_measurements.hover_power([flight.measured for flight in flights])
    seconds = [flight.measured.powers for flight in flights if flight.measured.powers is not None]
    powers = flight_measurements.learned_powers(seconds)
    if not known and power is None and not powers:
        raise LogUseless(
            "the flights show no difference of this vehicle to the simulated one",
            hint="without attitudes in the log drag shows only near the top speed: fly faster, or add logs",
        )
    blank = replace(blank, hover_power=power).with_numbers(powers)
    values, sure = _solve(flights, blank, known) if known else ((), ())
    ends = (0.0, -Z_90, Z_90)
    intervals = {
        name: Learned(*(_number(autopilot, name, value + n * deviation) for n in ends))
        for name, value, deviation in zip(known, values, sure, strict=True)
    }
    return blank.with_numbers(intervals)


def _number(autopilot: Autopilot, name: str, change: float) -> float:
    simulated = {"drag": 1.0, "lag": autopilot.part(FlightModel).simulated_lag}
    return simulated[name] * math.exp(change) if name in simulated else change


def _solve(flights: Sequence[Evidence], blank: LearnedVehicle, names: Sequence[str]) -> tuple[Vector, Vector]:
    deviations = np.concatenate([*(flight.scatter for flight in flights), np.empty(0)])
    prior = np.array([PRIOR_DEVIATIONS[name] for name in names])
    log_drag = [flight.measured.log_drag for flight in flights if flight.measured.log_drag and "drag" in names]
    drags = np.array(log_drag).reshape(-1, 2)

    def misfit(changes: Vector) -> Vector:
        values = {name: _number(blank.autopilot, name, change) for name, change in zip(names, changes, strict=True)}
        vehicle = blank.with_numbers({name: Learned(value, value, value) for name, value in values.items()})
        by_tilt = (changes[names.index("drag")] - drags[:, 0]) / drags[:, 1] if log_drag else np.empty(0)
        return np.concatenate([errors(flights, vehicle) / deviations, by_tilt, changes / prior])

    def slopes(changes: Vector) -> Matrix:
        columns = []
        for n, name in enumerate(names):
            step = np.zeros(len(names))
            step[n] = 0.1 if name == "drag" else 0.2
            columns.append((misfit(changes + step) - misfit(changes - step)) / (2 * step[n]))
        return np.column_stack(columns)

    found = least_squares(misfit, np.zeros(len(names)), slopes, x_scale=prior, xtol=1e-3, ftol=1e-3, max_nfev=12)
    freedom = max(len(deviations) + len(log_drag) - len(names), 1)
    residual_variance = max(float((found.fun[: -len(names)] ** 2).sum()) / freedom, 1.0)
    covariance = np.linalg.inv(found.jac.T @ found.jac) * residual_variance
    return found.x, np.sqrt(np.diag(covariance))


@dataclass(frozen=True)
class CrossValidation:
    """A flight [s]: flown, by the simulated vehicle, by that of the others; energy [Wh]."""

    name: str
    flown_s: float
    before_s: float
    after_s: float
    energy_wh: float | None = None
    forecast_wh: float | None = None


def cross_validate(flights: Sequence[Evidence]) -> list[CrossValidation]:
    """Forecast each flight with the vehicle of the others, or the simulated one; at least two flights."""
    if len(flights) < 2:
        raise LogUseless("expected two flights or more: each is forecast from the others")
    judged = list[CrossValidation]()
    for one in flights:
        try:
            vehicle = fit([each for each in flights if each is not one])
        except MissionError:
            vehicle = LearnedVehicle(one.mission.autopilot)
        judged += timed([one], vehicle)
    return judged


def timed(flights: Sequence[Evidence], vehicle: LearnedVehicle) -> list[CrossValidation]:
    rows = []
    for one in flights:
        before = float(one.forecast(None).sum())
        after = float(one.forecast(vehicle).sum())
        measured_wh = one.measured.energy_wh
        forecast_wh = one.energy(vehicle) if measured_wh else None
        rows.append(CrossValidation(one.name, float(one.seconds.sum()), before, after, measured_wh, forecast_wh))
    return rows


def median_errors(judged: Sequence[CrossValidation]) -> tuple[float, float]:
    flown = [one for one in judged if one.flown_s]
    before = [abs(one.before_s / one.flown_s - 1) for one in flown]
    after = [abs(one.after_s / one.flown_s - 1) for one in flown]
    return (float(np.median(before)), float(np.median(after))) if flown else (0.0, 0.0)


def energy_error(judged: Sequence[CrossValidation]) -> float | None:
    shares = [abs(one.forecast_wh / one.energy_wh - 1) for one in judged if one.energy_wh and one.forecast_wh]
    return float(np.median(shares)) if shares else None
