"""Fit power by airspeed and climb to battery power.

Prior: level flight takes hover power, within half of it at 10 m/s; each m/s of climb a tenth.
"""

from collections.abc import Sequence
from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import lsq_linear
from scipy.special import stdtrit

from ipoa_mission.autopilot.energy import PowerCurve
from ipoa_mission.autopilot.learned import Learned
from ipoa_mission.errors import LogUseless
from ipoa_mission.geometry import Points, Vector
from ipoa_mission.link.telemetry import Position
from ipoa_mission.logs.flight_log import LoggedFlight

AIRBORNE_HEIGHT = 2.0  # beyond the ground effect [m]
MAX_TIME_S = 86_400.0  # [s]


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
    """Return the track.

    Raises:
        MissionError: no positions, or a wrong clock.
    """
    places = (place for place in flight.messages if isinstance(place, Position))
    rows = np.array([(p.time_s - flight.armed_s, p.height, *p.velocity, p.altitude - p.height) for p in places])
    rows = rows[np.isfinite(rows).all(axis=1)] if len(rows) else np.empty((0, 6))
    if not len(rows) or np.ptp(rows[:, 0]) > MAX_TIME_S:
        raise LogUseless("it has no positions" if not len(rows) else "its clock is wrong")
    rows = rows[np.unique(rows[:, 0], return_index=True)[1]]
    return LoggedTrack(rows[:, 0], rows[:, 1], rows[:, 2:5], float(rows[0, 5]))


NAMES = ("hover_power", "square_power", "cube_power", "climb_power", "descent_power")
REFERENCE_SPEED = 10.0  # of the prior deviations [m/s]
#: Shares of the hover power, and their deviations.
PRIOR, PRIOR_DEVIATIONS = (
    np.array([1.0, 0.0, 0.0, 0.1, 0.0]),
    np.array([10.0, 0.5 / REFERENCE_SPEED**2, 0.5 / REFERENCE_SPEED**3, 0.1, 0.05]),
)
CORRELATED_S = 5.0  # for one independent second
MIN_TIME_S = 20.0  # aloft [s]
MIN_SPEED = 4.0  # [m/s]
SPEED_PERCENTILE = 98.0  # up to which power is known
BLOCK_S = 30  # forecast from the rest [s]
MIN_FLIGHTS = 3  # to forecast each from the others
MIN_DEVIATION = 0.05  # packs, payloads and days differ
MIN_DEVIATION_FAST = 0.1  # without slow flight, as a hover in wind
NINE_IN_TEN = 0.95  # upper quantile
MANY_FLIGHTS = 1.645


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

    def some(self, which: NDArray[np.bool_]) -> "PowerSeconds":
        return PowerSeconds(self.watts[which], self.airspeed[which], self.climb[which], self.aloft[which])

    @property
    def flown(self) -> "PowerSeconds":
        return self.some(self.aloft)


def learned_powers(flights: Sequence[PowerSeconds]) -> dict[str, Learned]:
    """`energy_ratio`: measured over forecast, of each flight or half minute, from the others."""
    flights = [flight.flown for flight in flights]
    if not flights:
        return {}
    together = _together(flights)
    if (together.airspeed > MIN_SPEED).sum() < MIN_TIME_S:
        return {}
    values, deviations = _fit(together)
    numbers = {
        name: Learned(value, value - MANY_FLIGHTS * off, value + MANY_FLIGHTS * off)
        for name, value, off in zip(NAMES, values.tolist(), deviations.tolist(), strict=True)
    }
    cube = numbers["cube_power"]
    numbers["cube_power"] = Learned(cube.value, max(cube.low, 0.0), cube.high)
    fastest, seen_slow = (
        float(np.percentile(together.airspeed, SPEED_PERCENTILE)),
        (together.airspeed < MIN_SPEED).sum() >= MIN_TIME_S,
    )
    return {**numbers, "airspeed": Learned(fastest, fastest, fastest), "energy_ratio": _ratio(flights, seen_slow)}


def _together(flights: Sequence[PowerSeconds]) -> PowerSeconds:
    parts = ([getattr(flight, part.name) for flight in flights] for part in fields(PowerSeconds))
    return PowerSeconds(*map(np.concatenate, parts))


def _columns(seconds: PowerSeconds) -> Points:
    v, w = seconds.airspeed, seconds.climb
    return np.column_stack([np.ones_like(v), v**2, v**3, np.maximum(w, 0.0), np.maximum(-w, 0.0)])


def _fit(seconds: PowerSeconds) -> tuple[Vector, Vector]:
    """Return the coefficients (5,) of `NAMES`, and their deviations."""
    columns, watts = _columns(seconds), seconds.watts
    hover = max(float(np.median(watts)), 1.0)
    least = np.array([0.0, -np.inf, 0.0, -np.inf, -np.inf])  # physical bounds
    noise = 0.05 * hover
    for _ in range(3):
        weight = 1.0 / noise / np.sqrt(CORRELATED_S)
        rows = np.vstack([columns * weight, np.diag(1.0 / (PRIOR_DEVIATIONS * hover))])
        wanted = np.concatenate([watts * weight, PRIOR / PRIOR_DEVIATIONS])
        values = np.asarray(lsq_linear(rows, wanted, (least, np.inf), method="bvls").x)
        noise = max(float(np.std(watts - columns @ values)), 1e-3 * hover)
    return values, np.sqrt(np.diag(np.linalg.inv(rows.T @ rows)))


def _ratio(flights: Sequence[PowerSeconds], seen_slow: bool) -> Learned:
    least = MIN_DEVIATION if seen_slow else MIN_DEVIATION_FAST
    parts = list(flights) if len(flights) >= MIN_FLIGHTS else [part for flight in flights for part in _blocks(flight)]
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
    half = max(float(stdtrit(number - 1, NINE_IN_TEN) * wide), least)
    return Learned(1.0, max(1.0 - half, 0.0), 1.0 + half)


def _blocks(flight: PowerSeconds) -> list[PowerSeconds]:
    number = np.arange(len(flight.watts)) // BLOCK_S
    return [flight.some(number == block) for block in np.unique(number)]
