from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from scipy.special import stdtrit

from ipoa_mission.autopilot.learned import Learned
from ipoa_mission.errors import LogUseless, MissionError
from ipoa_mission.learn.lean import drag_by_lean
from ipoa_mission.learn.logged_track import AIRBORNE_HEIGHT, LoggedTrack, logged_track
from ipoa_mission.learn.powers import PowerSeconds
from ipoa_mission.logs.flight_log import LoggedFlight

MAX_HOVER_SPEED, MAX_HOVER_CLIMB, MIN_HOVER_S = (
    2.0,
    0.3,
    3.0,
)  # of a hover [m/s, m/s, s]
MAX_WIND_DEVIATION = 1.0  # [m/s]
MEASURED_SHARE = 0.95  # of a flight
NINE_IN_TEN = 0.95  # upper quantile
MAX_DEVIATION = 0.25  # of a hover power


@dataclass(frozen=True)
class Witness:
    """Measurements; None with `reasons` by the vehicle's parameter.

    `leaned`: ln of drag over the simulated, and its deviation. `wind`: towards north and east [m/s].
    """

    leaned: tuple[float, float] | None = None
    wind: tuple[float, float] = (0.0, 0.0)
    powers: PowerSeconds | None = None
    hover_w: float | None = None
    energy_wh: float | None = None
    reasons: Mapping[str, str] = field(default_factory=dict)


def witness_of(flight: LoggedFlight) -> Witness:
    leaned = hover_w = energy_wh = powers = None
    wind = (0.0, 0.0)
    reasons = {}
    try:
        track = logged_track(flight)
    except MissionError as error:
        return Witness(reasons={"drag": str(error), "hover_power": str(error)})
    try:
        by_lean = drag_by_lean(flight.measured.attitude, track, flight.autopilot)
        leaned = by_lean.drag, by_lean.deviation
        wind = by_lean.wind if by_lean.wind_deviation < MAX_WIND_DEVIATION else wind
    except MissionError as error:
        reasons["drag"] = str(error)
    try:
        times, watts = flight.measured.power().T
        if np.ptp(times) > MEASURED_SHARE * np.ptp(track.times):
            energy_wh = float(np.trapezoid(watts, times)) / 3600.0
        powers = PowerSeconds.of(times, watts, track, wind)
        hover_w = _in_hover(times, watts, track)
    except MissionError as error:
        reasons["hover_power"] = str(error)
    return Witness(leaned, wind, powers, hover_w, energy_wh, reasons)


def _in_hover(times: np.ndarray, watts: np.ndarray, track: LoggedTrack) -> float:
    heights, velocity = track.at(times)
    hovers = (np.hypot(velocity[:, 0], velocity[:, 1]) < MAX_HOVER_SPEED) & (np.abs(velocity[:, 2]) < MAX_HOVER_CLIMB)
    hovers &= heights > AIRBORNE_HEIGHT
    lasts = np.gradient(times)[hovers]
    if lasts.sum() < MIN_HOVER_S:
        raise LogUseless(f"it hovers, or flies slowly and level, for {lasts.sum():.0f} s")
    return float(watts[hovers] @ lasts / lasts.sum())


def hover_power(flights: Sequence[Witness]) -> Learned | None:
    """Return the mean over flights [W] with its interval; None: unknown.

    >>> power = hover_power([Witness(hover_w=watts) for watts in (264.0, 266.0, 268.0)])
    >>> round(power.low), power.value, round(power.high)
    (263, 266.0, 269)
    """
    powers = np.array([flight.hover_w for flight in flights if flight.hover_w is not None])
    if len(powers) < 2:
        return None
    mean, error = float(powers.mean()), powers.std(ddof=1) / np.sqrt(len(powers))
    half = float(stdtrit(len(powers) - 1, NINE_IN_TEN) * error)
    return Learned(mean, mean - half, mean + half) if half <= MAX_DEVIATION * mean else None
