"""Measure drag and power in a logged flight.

Power by airspeed and climb is fitted to battery power. Prior: level flight takes hover power, within half of it at
10 m/s; each m/s of climb a tenth.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields, replace

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares, lsq_linear
from scipy.spatial.transform import Rotation
from scipy.special import stdtrit

from ipoa_mission import Autopilot
from ipoa_mission.autopilot.energy import PowerCurve
from ipoa_mission.autopilot.learned import Learned
from ipoa_mission.errors import LogUseless, MissionError
from ipoa_mission.forecast.timing.flight_model import Z_90, FlightModel
from ipoa_mission.geometry import GRAVITY, Matrix, Points, Vector
from ipoa_mission.logs.flight_log import LoggedFlight
from ipoa_mission.logs.logged import in_order

LEAST_MEASURED_HEIGHT = 2.0  # beyond the ground effect [m]
MIN_TIME_S = 20.0  # aloft
SAMPLE_STEP_S = 0.2
SMOOTHED_SAMPLES = 5
#: Shares of the hover power, and their deviations.
POWER_PRIOR = np.array([1.0, 0.0, 0.0, 0.1, 0.0])
POWER_PRIOR_DEVIATIONS = np.array([10.0, 0.5 / 10.0**2, 0.5 / 10.0**3, 0.1, 0.05])  # at 10 m/s


@dataclass(frozen=True, eq=False)
class LoggedTrack:
    """Times (n,) [s], heights above home (n,) [m], velocity north, east, down (n, 3) [m/s]."""

    times: Vector
    heights: Vector
    velocity: Points
    home_altitude: float

    def at(self, times: Vector) -> tuple[Vector, Points]:
        velocity = np.column_stack([np.interp(times, self.times, axis) for axis in self.velocity.T])
        return np.interp(times, self.times, self.heights), velocity


def logged_track(flight: LoggedFlight) -> LoggedTrack:
    rows = np.array([(p.time_s - flight.armed_s, p.height, *p.velocity, p.altitude - p.height) for p in flight.places])
    rows = rows[np.isfinite(rows).all(axis=1)] if len(rows) else np.empty((0, 6))
    if not len(rows) or np.ptp(rows[:, 0]) > 86_400.0:  # [s]
        raise LogUseless("it has no positions" if not len(rows) else "its clock is wrong")
    rows = in_order(rows)
    return LoggedTrack(rows[:, 0], rows[:, 1], rows[:, 2:5], float(rows[0, 5]))


@dataclass(frozen=True, eq=False)
class PowerSeconds:
    """The seconds aloft of a flight (n,): power [W], airspeed and climb [m/s]."""

    watts: Vector
    airspeed: Vector
    climb: Vector

    @classmethod
    def of(cls, times: Vector, watts: Vector, track: LoggedTrack, wind: tuple[float, float]) -> "PowerSeconds":
        """Make seconds of powers [W] at times [s] (n,), in a wind towards north and east [m/s]."""
        heights, velocity = track.at(times)
        seconds = np.floor(times - times[0]).astype(int)
        counted = np.bincount(seconds)
        there = counted > 0

        def mean(values: Vector) -> Vector:
            return np.bincount(seconds, values)[there] / counted[there]

        airspeed = np.hypot(velocity[:, 0] - wind[0], velocity[:, 1] - wind[1])
        flown = cls(mean(watts), mean(airspeed), mean(-velocity[:, 2]))
        return flown.selected(mean(heights) > LEAST_MEASURED_HEIGHT)

    def selected(self, which: NDArray[np.bool_]) -> "PowerSeconds":
        return PowerSeconds(self.watts[which], self.airspeed[which], self.climb[which])


def learned_powers(flights: Sequence[PowerSeconds]) -> dict[str, Learned]:
    """`energy_ratio`: measured over forecast, of each flight or half minute, from the others."""
    if not flights:
        return {}
    min_speed = 4.0  # [m/s]
    together = _together(flights)
    if (together.airspeed > min_speed).sum() < MIN_TIME_S:
        return {}
    values, deviations = _fit(together)
    names = ("hover_power", "square_power", "cube_power", "climb_power", "descent_power")
    half = Z_90 * deviations
    learned = map(Learned, values.tolist(), (values - half).tolist(), (values + half).tolist())
    numbers = dict(zip(names, learned, strict=True))
    numbers["cube_power"] = replace(numbers["cube_power"], low=max(numbers["cube_power"].low, 0.0))
    fastest = float(np.percentile(together.airspeed, 98.0))
    flew_slowly = (together.airspeed < min_speed).sum() >= MIN_TIME_S
    return {**numbers, "airspeed": Learned(fastest, fastest, fastest), "energy_ratio": _ratio(flights, flew_slowly)}


def _together(flights: Sequence[PowerSeconds]) -> PowerSeconds:
    parts = ([getattr(flight, part.name) for flight in flights] for part in fields(PowerSeconds))
    return PowerSeconds(*map(np.concatenate, parts))


def _fit(seconds: PowerSeconds) -> tuple[Vector, Vector]:
    """Return the powers (5,) of a `PowerCurve`, and their deviations."""
    v = seconds.airspeed
    climb = seconds.climb
    watts = seconds.watts
    columns = np.column_stack([np.ones_like(v), v**2, v**3, np.maximum(climb, 0.0), np.maximum(-climb, 0.0)])
    hover = max(float(np.median(watts)), 1.0)
    least = np.array([0.0, -np.inf, 0.0, -np.inf, -np.inf])  # physical bounds
    noise = 0.05 * hover
    correlated_s = 5.0  # one independent sample
    for _ in range(3):
        weight = 1.0 / noise / np.sqrt(correlated_s)
        rows = np.vstack([columns * weight, np.diag(1.0 / (POWER_PRIOR_DEVIATIONS * hover))])
        wanted = np.concatenate([watts * weight, POWER_PRIOR / POWER_PRIOR_DEVIATIONS])
        values = np.asarray(lsq_linear(rows, wanted, (least, np.inf), method="bvls").x)
        noise = max(float(np.std(watts - columns @ values)), 1e-3 * hover)
    return values, np.sqrt(np.diag(np.linalg.inv(rows.T @ rows)))


def _ratio(flights: Sequence[PowerSeconds], flew_slowly: bool) -> Learned:
    least = 0.05 if flew_slowly else 0.1  # packs, payloads and days differ
    parts = list(flights)
    if len(parts) < 3:
        blocks = [np.arange(len(flight.watts)) // 30 for flight in flights]  # [s]
        parts = [f.selected(n == block) for f, n in zip(flights, blocks, strict=True) for block in np.unique(n)]
    shares = []
    for n, part in enumerate(parts):
        others = parts[:n] + parts[n + 1 :]
        if others and len(part.watts) >= MIN_TIME_S:
            values, _ = _fit(_together(others))
            shares.append(float(part.watts.sum() / PowerCurve(*values).power(part.airspeed, part.climb).sum()))
    if len(shares) < 2:
        return Learned(1.0, 1.0 - 2 * least, 1.0 + 2 * least)
    number = len(shares)
    wide = np.sqrt(np.mean((np.array(shares) - 1.0) ** 2) * (1.0 + 1.0 / number))
    half = max(float(stdtrit(number - 1, 0.95) * wide), least)
    return Learned(1.0, max(1.0 - half, 0.0), 1.0 + half)


def drag_by_tilt(
    attitude: Matrix, track: LoggedTrack, autopilot: Autopilot
) -> tuple[tuple[float, float], tuple[float, float]]:
    """Estimate from `Measured` attitudes (n, 4); refuse too little fast level flight.

    Return ln of drag over the simulated with its deviation, and the wind if it is sure (`FlightMeasurements`).
    """
    min_speed = 2.5  # [m/s]; slower, drag is within the tilt's error
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
    high = max(LEAST_MEASURED_HEIGHT, 0.6 * float(track.heights.max()))  # wind differs below
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


def _smoothed(values: Matrix) -> Matrix:
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
        log_drag, wind = drag_by_tilt(flight.measured.attitude, track, flight.autopilot)
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
    hovers &= heights > LEAST_MEASURED_HEIGHT
    lasts = np.gradient(times)[hovers]
    if lasts.sum() < min_time_s:
        raise LogUseless(f"expected {min_time_s:g} s or more of slow level flight, not {lasts.sum():.1f} s")
    return float(watts[hovers] @ lasts / lasts.sum())


def hover_power(flights: Sequence[FlightMeasurements]) -> Learned | None:
    """Return the mean over flights [W] with its interval; None: unknown."""
    powers = np.array([flight.hover_w for flight in flights if flight.hover_w is not None])
    if len(powers) < 2:
        return None
    mean = float(powers.mean())
    error = powers.std(ddof=1) / np.sqrt(len(powers))
    half = float(stdtrit(len(powers) - 1, 0.95) * error)
    return Learned(mean, mean - half, mean + half) if half <= 0.25 * mean else None
