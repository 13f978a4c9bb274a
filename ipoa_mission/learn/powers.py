"""Fit power by airspeed and climb to battery power.

Prior: level flight takes hover power, within half of it at 10 m/s; each m/s of climb a tenth.
"""

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import lsq_linear
from scipy.special import stdtrit

from ipoa_mission.autopilot.energy import PowerCurve
from ipoa_mission.autopilot.learned import Learned
from ipoa_mission.errors import LogUseless
from ipoa_mission.geometry import Points, Vector
from ipoa_mission.logs.flight_log import LoggedFlight

AIRBORNE_HEIGHT = 2.0  # beyond the ground effect [m]
MIN_TIME_S = 20.0  # aloft
DEVIATIONS_OF_90_PERCENT = 1.645  # of many samples


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
    rows = rows[np.unique(rows[:, 0], return_index=True)[1]]
    return LoggedTrack(rows[:, 0], rows[:, 1], rows[:, 2:5], float(rows[0, 5]))


#: Shares of the hover power, and their deviations.
PRIOR, PRIOR_DEVIATIONS = (
    np.array([1.0, 0.0, 0.0, 0.1, 0.0]),
    np.array([10.0, 0.5 / 10.0**2, 0.5 / 10.0**3, 0.1, 0.05]),  # at 10 m/s
)


@dataclass(frozen=True, eq=False)
class PowerSeconds:
    """A flight by second (n,): power [W], airspeed and climb [m/s], aloft."""

    watts: Vector
    airspeed: Vector
    climb: Vector
    aloft: NDArray[np.bool_]

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
        return cls(mean(watts), mean(airspeed), mean(-velocity[:, 2]), mean(heights) > AIRBORNE_HEIGHT)

    def selected(self, which: NDArray[np.bool_]) -> "PowerSeconds":
        return PowerSeconds(self.watts[which], self.airspeed[which], self.climb[which], self.aloft[which])


def learned_powers(flights: Sequence[PowerSeconds]) -> dict[str, Learned]:
    """`energy_ratio`: measured over forecast, of each flight or half minute, from the others."""
    flights = [flight.selected(flight.aloft) for flight in flights]
    if not flights:
        return {}
    min_speed = 4.0  # [m/s]
    together = _together(flights)
    if (together.airspeed > min_speed).sum() < MIN_TIME_S:
        return {}
    values, deviations = _fit(together)
    names = ("hover_power", "square_power", "cube_power", "climb_power", "descent_power")
    half = DEVIATIONS_OF_90_PERCENT * deviations
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
        rows = np.vstack([columns * weight, np.diag(1.0 / (PRIOR_DEVIATIONS * hover))])
        wanted = np.concatenate([watts * weight, PRIOR / PRIOR_DEVIATIONS])
        values = np.asarray(lsq_linear(rows, wanted, (least, np.inf), method="bvls").x)
        noise = max(float(np.std(watts - columns @ values)), 1e-3 * hover)
    return values, np.sqrt(np.diag(np.linalg.inv(rows.T @ rows)))


def _ratio(flights: Sequence[PowerSeconds], flew_slowly: bool) -> Learned:
    least = 0.05 if flew_slowly else 0.1  # packs, payloads and days differ; fast flight is like a hover in wind
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
