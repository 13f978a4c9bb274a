from collections.abc import Iterable
from dataclasses import dataclass, field

import numpy as np

from ipoa_mission.errors import LogUseless
from ipoa_mission.geometry import Points, Vector

Battery = tuple[float, float, float]  # [s, V, A]; NaN or negative: not measured
MAX_VALUE = 10_000.0  # [V, A]
CONSTANT_SPREAD = 1e-3  # of the mean; a measured current varies more


def _rows(columns: int) -> Points:
    return np.empty((0, columns))


@dataclass(frozen=True, eq=False)
class Measured:
    """Batteries: s, V, A, each (n, 3); attitude: s, roll, pitch, yaw [rad] (m, 4). Times increase."""

    batteries: tuple[Points, ...] = ()
    attitude: Points = field(default_factory=lambda: _rows(4))

    @classmethod
    def of(cls, batteries: Iterable[Iterable[Battery]], attitude: Iterable[tuple[float, ...]] | Points) -> "Measured":
        """Make measurements of rows in any order; without voltage left out."""
        read = (_sorted(battery, 3) for battery in batteries)
        leaned = _sorted(attitude, 4)
        sound = (np.abs(leaned[:, 1:]) < 2 * np.pi + 0.01).all(axis=1)  # yaw may be up to 360 degrees
        return cls(tuple(rows for rows in read if (rows[:, 1] > 0).any()), leaned[sound])

    def between(self, begin: float, end: float) -> "Measured":
        batteries = tuple(_cut(battery, begin, end) for battery in self.batteries)
        return Measured(batteries, _cut(self.attitude, begin, end))

    def power(self) -> Points:
        """Return all batteries' power (n, 2) [s, W], at the first one's times.

        Raises:
            MissionError: no current was measured.
        """
        given, reasons = [], []
        for battery in self.batteries:
            volts, current = battery[:, 1], battery[:, 2]
            sound = battery[(volts > 0) & (volts < MAX_VALUE) & (current >= 0) & (current < MAX_VALUE)]
            amperes = sound[:, 2]
            if len(sound) < 2 or amperes.max() <= 0:
                reasons.append("its battery has no current sensor: the current is always 0 A or -1")
            elif np.ptp(amperes) <= CONSTANT_SPREAD * amperes.mean():
                reasons.append(f"the current of its battery is a constant, {amperes[0]:.3g} A, and not measured")
            else:
                given.append((sound[:, 0], sound[:, 1] * amperes))
        if not given:
            raise LogUseless(reasons[0] if reasons else "it has no battery's voltage and current")
        times = given[0][0]
        return np.column_stack([times, sum(np.interp(times, at, watts) for at, watts in given)])


def _sorted(rows: Iterable[tuple[float, ...]] | Points, columns: int) -> Points:
    table = np.asarray(list(rows), float).reshape(-1, columns)
    table = table[np.isfinite(table[:, :2]).all(axis=1)]
    return np.asarray(table[np.unique(table[:, 0], return_index=True)[1]])


def _cut(rows: Points, begin: float, end: float) -> Points:
    times: Vector = rows[:, 0]
    cut = rows[(times >= begin) & (times <= end)].copy()
    cut[:, 0] -= begin
    return cut
