"""Fit a vehicle by least squares.

The prior is the simulated vehicle (`PRIOR_DEVIATIONS`). A parameter stays if the flights do not halve its deviation, or
its interval contains the simulated value.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import least_squares

from ipoa_mission.autopilot.autopilot import Autopilot
from ipoa_mission.autopilot.learned import Learned, LearnedVehicle
from ipoa_mission.errors import LogUseless, MissionError
from ipoa_mission.forecast.timing.flight_model import FlightModel
from ipoa_mission.geometry import Points, Vector
from ipoa_mission.learn.evidence import Evidence, errors, scatter
from ipoa_mission.learn.flight_measurements import hover_power
from ipoa_mission.learn.powers import DEVIATIONS_OF_90_PERCENT, learned_powers

#: Of logarithms, and of delays [s].
PRIOR_DEVIATIONS = {"drag": 0.7, "lag": 0.7, "lift_delay": 1.5, "landing_delay": 4.0}


def fit(flights: Sequence[Evidence]) -> LearnedVehicle:
    """Unknown parameters are None; all unknown are an error."""
    autopilot = flights[0].mission.autopilot
    blank = LearnedVehicle(autopilot, flights=len(flights))
    names = tuple(PRIOR_DEVIATIONS)
    known = tuple(
        name
        for name, value, deviation in zip(names, *_solve(flights, blank, names), strict=True)
        if deviation < 0.5 * PRIOR_DEVIATIONS[name] and abs(value) > DEVIATIONS_OF_90_PERCENT * deviation
    )
    power = hover_power([flight.measured for flight in flights])
    powers = learned_powers([flight.measured.powers for flight in flights if flight.measured.powers is not None])
    if not known and power is None and not powers:
        raise LogUseless(
            "the flights show no difference of this vehicle to the simulated one",
            hint="without attitudes in the log drag shows only near the top speed: fly faster, or add logs",
        )
    blank = replace(blank, hover_power=power).with_numbers(powers)
    values, sure = _solve(flights, blank, known) if known else ((), ())
    ends = (0.0, -DEVIATIONS_OF_90_PERCENT, DEVIATIONS_OF_90_PERCENT)
    intervals = {
        name: Learned(*(_number(autopilot, name, value + n * deviation) for n in ends))
        for name, value, deviation in zip(known, values, sure, strict=True)
    }
    return blank.with_numbers(intervals)


def _number(autopilot: Autopilot, name: str, change: float) -> float:
    simulated = autopilot.part(FlightModel).simulated[name]
    return simulated * math.exp(change) if name in ("drag", "lag") else simulated + change


def _solve(flights: Sequence[Evidence], blank: LearnedVehicle, names: Sequence[str]) -> tuple[Vector, Vector]:
    """Return the best changes (k,) and their standard deviations (k,)."""
    deviations, prior = scatter(flights), np.array([PRIOR_DEVIATIONS[name] for name in names])
    log_drag = [flight.measured.log_drag for flight in flights if flight.measured.log_drag and "drag" in names]
    drags = np.array(log_drag).reshape(-1, 2)

    def misfit(changes: Vector) -> Vector:
        values = {name: _number(blank.autopilot, name, change) for name, change in zip(names, changes, strict=True)}
        vehicle = blank.with_numbers({name: Learned(value, value, value) for name, value in values.items()})
        by_lean = (changes[names.index("drag")] - drags[:, 0]) / drags[:, 1] if log_drag else np.empty(0)
        return np.concatenate([errors(flights, vehicle) / deviations, by_lean, changes / prior])

    def slopes(changes: Vector) -> Points:
        columns = []
        for n, name in enumerate(names):
            step = np.zeros(len(names))
            step[n] = 0.1 if name == "drag" else 0.2
            columns.append((misfit(changes + step) - misfit(changes - step)) / (2 * step[n]))
        return np.column_stack(columns)

    found = least_squares(misfit, np.zeros(len(names)), slopes, x_scale=prior, xtol=1e-3, ftol=1e-3, max_nfev=12)
    freedom = max(len(deviations) + len(log_drag) - len(names), 1)
    spread = max(float((found.fun[: -len(names)] ** 2).sum()) / freedom, 1.0)
    covariance = np.linalg.inv(found.jac.T @ found.jac) * spread
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


def cross_validate(flights: Sequence[Evidence]) -> tuple[CrossValidation, ...]:
    """Forecast each flight with the vehicle of the others, or the simulated one; at least two flights."""
    if len(flights) < 2:
        raise LogUseless("expected two flights or more: each is forecast from the others")
    judged = []
    for one in flights:
        try:
            vehicle = fit([each for each in flights if each is not one])
        except MissionError:
            vehicle = LearnedVehicle(one.mission.autopilot)
        judged.append(_timed(one, vehicle))
    return tuple(judged)


def timed(flights: Sequence[Evidence], vehicle: LearnedVehicle) -> tuple[CrossValidation, ...]:
    return tuple(_timed(one, vehicle) for one in flights)


def _timed(one: Evidence, vehicle: LearnedVehicle) -> CrossValidation:
    before, after = (float(one.forecast(each).sum()) for each in (None, vehicle))
    measured_wh = one.measured.energy_wh
    forecast_wh = one.energy(vehicle) if measured_wh else None
    return CrossValidation(one.name, float(one.seconds.sum()), before, after, measured_wh, forecast_wh)


def median_errors(judged: Sequence[CrossValidation]) -> tuple[float, float]:
    flown = [one for one in judged if one.flown_s]
    before = [abs(one.before_s / one.flown_s - 1) for one in flown]
    after = [abs(one.after_s / one.flown_s - 1) for one in flown]
    return (float(np.median(before)), float(np.median(after))) if flown else (0.0, 0.0)


def energy_error(judged: Sequence[CrossValidation]) -> float | None:
    shares = [abs(one.forecast_wh / one.energy_wh - 1) for one in judged if one.energy_wh and one.forecast_wh]
    return float(np.median(shares)) if shares else None
