"""Evaluate a learned vehicle: forecast each flight from the others."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ipoa_mission.autopilot.learned import LearnedVehicle
from ipoa_mission.errors import LogUseless, MissionError
from ipoa_mission.learn.evidence import Evidence
from ipoa_mission.learn.fit import fit


@dataclass(frozen=True)
class LeftOut:
    """A flight [s]: flown, by the simulated vehicle, by that of the others; energy [Wh]."""

    name: str
    flown_s: float
    before_s: float
    after_s: float
    energy_wh: float | None = None
    forecast_wh: float | None = None


def left_out(flights: Sequence[Evidence]) -> tuple[LeftOut, ...]:
    """Forecast each flight with the vehicle of the others, or the simulated one.

    Raises:
        MissionError: fewer than two flights.
    """
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


def timed(flights: Sequence[Evidence], vehicle: LearnedVehicle) -> tuple[LeftOut, ...]:
    return tuple(_timed(one, vehicle) for one in flights)


def _timed(one: Evidence, vehicle: LearnedVehicle) -> LeftOut:
    before, after = (float(one.forecast(each).sum()) for each in (None, vehicle))
    measured_wh = one.witness.energy_wh
    forecast_wh = one.energy(vehicle) if measured_wh else None
    return LeftOut(one.name, float(one.seconds.sum()), before, after, measured_wh, forecast_wh)


def median_errors(judged: Sequence[LeftOut]) -> tuple[float, float]:
    flown = [one for one in judged if one.flown_s]
    before = [abs(one.before_s / one.flown_s - 1) for one in flown]
    after = [abs(one.after_s / one.flown_s - 1) for one in flown]
    return (float(np.median(before)), float(np.median(after))) if flown else (0.0, 0.0)


def energy_error(judged: Sequence[LeftOut]) -> float | None:
    shares = [abs(one.forecast_wh / one.energy_wh - 1) for one in judged if one.energy_wh and one.forecast_wh]
    return float(np.median(shares)) if shares else None
