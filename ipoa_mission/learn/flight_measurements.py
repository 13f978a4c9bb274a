from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation
from scipy.special import stdtrit

from ipoa_mission.autopilot.autopilot import Autopilot
from ipoa_mission.autopilot.learned import Learned
from ipoa_mission.errors import LogUseless, MissionError
from ipoa_mission.forecast.timing.flight_model import FlightModel
from ipoa_mission.geometry import GRAVITY, Points, Vector
from ipoa_mission.learn.powers import AIRBORNE_HEIGHT, LoggedTrack, PowerSeconds, logged_track
from ipoa_mission.logs.flight_log import LoggedFlight

SAMPLE_STEP_S = 0.2
SMOOTHED_SAMPLES = 5


def drag_by_lean(
    attitude: Points, track: LoggedTrack, autopilot: Autopilot
) -> tuple[tuple[float, float], tuple[float, float]]:
    """Estimate from `Measured` attitudes (n, 4); refuse too little fast level flight.

    Return ln of drag over the simulated with its deviation, and the wind if it is sure (`FlightMeasurements`).
    """
    min_speed = 2.5  # [m/s]; slower, drag is within the lean's error
    min_time_s = 5.0
    steady_limit = 1.0  # of climb [m/s] and acceleration [m/s^2]
    max_gap_s = 2.0  # between attitudes
    if len(attitude) < 2 or np.ptp(attitude[:, 0]) < min_time_s:
        raise LogUseless("it has no attitudes")
    times = np.arange(attitude[0, 0], attitude[-1, 0], SAMPLE_STEP_S)
    angles = np.column_stack([np.interp(times, attitude[:, 0], np.unwrap(angle)) for angle in attitude[:, :0:-1].T])
    axes = Rotation.from_euler("ZYX", angles).as_matrix()  # columns ahead, right, down
    heights, velocity = track.at(times)
    gained = _smoothed(np.gradient(velocity[:, :2], SAMPLE_STEP_S, axis=0))
    pull = _smoothed(-GRAVITY * axes[:, :2, 2] / axes[:, 2, 2, None])
    steady = (np.abs(gained).max(axis=1) < steady_limit) & (np.abs(velocity[:, 2]) < steady_limit)
    high = max(AIRBORNE_HEIGHT, 0.6 * float(track.heights.max()))  # wind differs below
    steady &= (heights > high) & (axes[:, 2, 2] > 0.0)
    before = np.searchsorted(attitude[:, 0], times, side="right") - 1
    steady &= np.diff(attitude[:, 0], append=np.inf)[before] < max_gap_s
    steady[:SMOOTHED_SAMPLES] = steady[-SMOOTHED_SAMPLES:] = False
    fast_s = (np.hypot(*velocity[steady, :2].T) > min_speed).sum() * SAMPLE_STEP_S
    if fast_s < min_time_s:
        words = f"expected {min_time_s:g} s or more of level flight over {min_speed:g} m/s, not {fast_s:.1f} s"
        raise LogUseless(words)
    velocity = velocity[steady]
    axes = axes[steady]
    held = (pull - gained)[steady]
    airframe = autopilot.part(FlightModel).airframe(track.home_altitude)

    correlated_samples = 10
    prior_deviations = np.array([0.7, 3.0, 3.0, 0.2, 0.2])  # ln drag, wind [m/s], tilt ahead and right [m/s^2]

    def misfit(change: Vector, noise: float) -> Vector:
        slowed = np.exp(change[0]) * airframe.slowing(velocity - [change[1], change[2], 0.0], axes)[:, :2]
        wrong = slowed + axes[:, :2, :2] @ change[3:] - held
        return np.concatenate([wrong.ravel() / noise / np.sqrt(correlated_samples), change / prior_deviations])

    noise = 0.2
    for _ in range(2):
        fitted = least_squares(misfit, np.zeros(5), args=(noise,))
        noise *= float(np.std(fitted.fun[:-5])) * np.sqrt(correlated_samples)
    variances = np.diag(np.linalg.inv(fitted.jac.T @ fitted.jac))
    drag, north, east = (float(number) for number in fitted.x[:3])
    deviation = float(np.sqrt(variances[0] + 0.05**2))  # from flight to flight
    is_wind_sure = np.sqrt(variances[1:3].max()) < 1.0  # [m/s]
    return (drag, deviation), (north, east) if is_wind_sure else (0.0, 0.0)


def _smoothed(values: Points) -> Points:
    window = np.ones(SMOOTHED_SAMPLES) / SMOOTHED_SAMPLES
    return np.column_stack([np.convolve(column, window, "same") for column in values.T])


@dataclass(frozen=True)
class FlightMeasurements:
    """Measurements; None with `reasons` by the vehicle's parameter.

    `log_drag`: ln of drag over the simulated, and its deviation. `wind`: towards north and east [m/s].
    """

    log_drag: tuple[float, float] | None = None
    wind: tuple[float, float] = (0.0, 0.0)
    powers: PowerSeconds | None = None
    hover_w: float | None = None
    energy_wh: float | None = None
    reasons: Mapping[str, str] = field(default_factory=dict)


def measure_flight(flight: LoggedFlight) -> FlightMeasurements:
    log_drag = hover_w = energy_wh = powers = None
    wind = (0.0, 0.0)
    reasons = {}
    try:
        track = logged_track(flight)
    except MissionError as error:
        return FlightMeasurements(reasons={"drag": str(error), "hover_power": str(error)})
    try:
        log_drag, wind = drag_by_lean(flight.measured.attitude, track, flight.autopilot)
    except MissionError as error:
        reasons["drag"] = str(error)
    try:
        times, watts = flight.measured.power().T
        if np.ptp(times) > 0.95 * np.ptp(track.times):
            energy_wh = float(np.trapezoid(watts, times)) / 3600.0
        powers = PowerSeconds.of(times, watts, track, wind)
        hover_w = _in_hover(times, watts, track)
    except MissionError as error:
        reasons["hover_power"] = str(error)
    return FlightMeasurements(log_drag, wind, powers, hover_w, energy_wh, reasons)


def _in_hover(times: np.ndarray, watts: np.ndarray, track: LoggedTrack) -> float:
    heights, velocity = track.at(times)
    max_speed = 2.0  # [m/s]
    max_climb = 0.3  # [m/s]
    min_time_s = 3.0
    hovers = (np.hypot(velocity[:, 0], velocity[:, 1]) < max_speed) & (np.abs(velocity[:, 2]) < max_climb)
    hovers &= heights > AIRBORNE_HEIGHT
    lasts = np.gradient(times)[hovers]
    if lasts.sum() < min_time_s:
        raise LogUseless(f"expected {min_time_s:g} s or more of slow level flight, not {lasts.sum():.1f} s")
    return float(watts[hovers] @ lasts / lasts.sum())


def hover_power(flights: Sequence[FlightMeasurements]) -> Learned | None:
    """Return the mean over flights [W] with its interval; None: unknown.

    >>> power = hover_power([FlightMeasurements(hover_w=watts) for watts in (264.0, 266.0, 268.0)])
    >>> round(power.low), power.value, round(power.high)
    (263, 266.0, 269)
    """
    powers = np.array([flight.hover_w for flight in flights if flight.hover_w is not None])
    if len(powers) < 2:
        return None
    mean = float(powers.mean())
    error = powers.std(ddof=1) / np.sqrt(len(powers))
    half = float(stdtrit(len(powers) - 1, 0.95) * error)
    return Learned(mean, mean - half, mean + half) if half <= 0.25 * mean else None
