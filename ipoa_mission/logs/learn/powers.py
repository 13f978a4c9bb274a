"""The power of a vehicle by airspeed and climb, fitted to what its batteries gave second by second.

What is believed before: that flying level takes what hovering does, give or take half of it at 10 m/s, and that a climb
takes a tenth of it for each m/s. Wind is what the lean told of it, or none.
"""

from collections.abc import Sequence
from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import lsq_linear
from scipy.special import stdtrit

from ipoa_mission.geometry import Points, Vector
from ipoa_mission.logs.learn.logged_track import CLEAR, LoggedTrack
from ipoa_mission.vehicles.energy.curve import PowerCurve
from ipoa_mission.vehicles.learned import Learned

NAMES = ("hover_power", "square_power", "cube_power", "climb_power", "descent_power")
AT = 10.0  # m/s: where the believed deviations of the square and the cube are meant
#: What is believed of each number as a share of the power in hover, and by how much it may be off.
BELIEVED, OFF = np.array([1.0, 0.0, 0.0, 0.1, 0.0]), np.array([10.0, 0.5 / AT**2, 0.5 / AT**3, 0.1, 0.05])
ALONE_S = 5.0  # a second is much like the next: one in so many tells by itself
LEAST_S = 20.0  # aloft, and this fast, is enough to tell of flying
FAST = 4.0  # [m/s]
FASTEST = 98.0  # per cent of the time are slower than what counts as seen
BLOCK_S = 30  # of one flight, told by the rest of it
SEVERAL = 3  # flights, and each is told by the others
SUREST = 0.05  # no flight is told more exactly: packs, payloads and days differ
NO_HOVER = 0.1  # nor this, by flights that were never slow through the air, as who hovers in wind
NINE_IN_TEN = 0.95  # quantile of the upper end
MANY_FLIGHTS = 1.645


@dataclass(frozen=True, eq=False)
class PowerSeconds:
    """A flight second by second: what the batteries gave [W], airspeed and climb [m/s], whether it was aloft, (n,)."""

    watts: Vector
    airspeed: Vector
    climb: Vector
    aloft: NDArray[np.bool_]

    @classmethod
    def of(cls, times: Vector, watts: Vector, track: LoggedTrack, wind: tuple[float, float]) -> "PowerSeconds":
        """Out of measured powers (n,) [W] at times (n,) [s], in a wind towards north and east [m/s]."""
        heights, velocity = track.at(times)
        seconds = np.floor(times - times[0]).astype(int)
        counted = np.bincount(seconds)
        there = counted > 0

        def mean(values: Vector) -> Vector:
            return np.bincount(seconds, values)[there] / counted[there]

        airspeed = np.hypot(velocity[:, 0] - wind[0], velocity[:, 1] - wind[1])
        return cls(mean(watts), mean(airspeed), mean(-velocity[:, 2]), mean(heights) > CLEAR)

    def some(self, which: NDArray[np.bool_]) -> "PowerSeconds":
        """Some of the seconds."""
        return PowerSeconds(self.watts[which], self.airspeed[which], self.climb[which], self.aloft[which])

    @property
    def flown(self) -> "PowerSeconds":
        """The seconds aloft."""
        return self.some(self.aloft)


def learned_powers(flights: Sequence[PowerSeconds]) -> dict[str, Learned]:
    """The numbers of a vehicle's power by their names, each with its interval; none where the flights do not tell them.

    `energy_ratio` is by how much each flight, or each half minute of the only one, differs from what the others tell.
    """
    flights = [flight.flown for flight in flights]
    if not flights:
        return {}
    together = _together(flights)
    if (together.airspeed > FAST).sum() < LEAST_S:
        return {}
    values, deviations = _fit(together)
    numbers = {
        name: Learned(value, value - MANY_FLIGHTS * off, value + MANY_FLIGHTS * off)
        for name, value, off in zip(NAMES, values.tolist(), deviations.tolist(), strict=True)
    }
    cube = numbers["cube_power"]
    numbers["cube_power"] = Learned(cube.value, max(cube.low, 0.0), cube.high)
    fastest, seen_slow = float(np.percentile(together.airspeed, FASTEST)), (together.airspeed < FAST).sum() >= LEAST_S
    return {**numbers, "airspeed": Learned(fastest, fastest, fastest), "energy_ratio": _ratio(flights, seen_slow)}


def _together(flights: Sequence[PowerSeconds]) -> PowerSeconds:
    parts = ([getattr(flight, part.name) for flight in flights] for part in fields(PowerSeconds))
    return PowerSeconds(*map(np.concatenate, parts))


def _columns(seconds: PowerSeconds) -> Points:
    v, w = seconds.airspeed, seconds.climb
    return np.column_stack([np.ones_like(v), v**2, v**3, np.maximum(w, 0.0), np.maximum(-w, 0.0)])


def _fit(seconds: PowerSeconds) -> tuple[Vector, Vector]:
    """The numbers (5,) in the order of `NAMES`, and their standard deviations."""
    columns, watts = _columns(seconds), seconds.watts
    hover = max(float(np.median(watts)), 1.0)
    least = np.array([0.0, -np.inf, 0.0, -np.inf, -np.inf])  # hovering and drag take something
    noise = 0.05 * hover
    for _ in range(3):
        weight = 1.0 / noise / np.sqrt(ALONE_S)
        rows = np.vstack([columns * weight, np.diag(1.0 / (OFF * hover))])
        wanted = np.concatenate([watts * weight, BELIEVED / OFF])
        values = np.asarray(lsq_linear(rows, wanted, (least, np.inf), method="bvls").x)
        noise = max(float(np.std(watts - columns @ values)), 1e-3 * hover)
    return values, np.sqrt(np.diag(np.linalg.inv(rows.T @ rows)))


def _ratio(flights: Sequence[PowerSeconds], seen_slow: bool) -> Learned:
    """How far what was measured lies about what the rest tells."""
    least = SUREST if seen_slow else NO_HOVER
    parts = list(flights) if len(flights) >= SEVERAL else [part for flight in flights for part in _blocks(flight)]
    shares = []
    for n, part in enumerate(parts):
        others = parts[:n] + parts[n + 1 :]
        if others and len(part.watts) >= LEAST_S:
            values, _ = _fit(_together(others))
            shares.append(float(part.watts.sum() / PowerCurve(*values).power(part.airspeed, part.climb).sum()))
    if len(shares) < 2:
        return Learned(1.0, 1.0 - 2 * least, 1.0 + 2 * least)
    number = len(shares)
    wide = np.sqrt(np.mean((np.array(shares) - 1.0) ** 2) * (1.0 + 1.0 / number))
    aside = max(float(stdtrit(number - 1, NINE_IN_TEN) * wide), least)
    return Learned(1.0, max(1.0 - aside, 0.0), 1.0 + aside)


def _blocks(flight: PowerSeconds) -> list[PowerSeconds]:
    number = np.arange(len(flight.watts)) // BLOCK_S
    return [flight.some(number == block) for block in np.unique(number)]
