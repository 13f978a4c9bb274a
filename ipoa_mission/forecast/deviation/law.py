from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ipoa_mission.autopilot.autopilot import Autopilot
from ipoa_mission.geometry import Vector


@dataclass(frozen=True)
class Quantiles:
    """Measured quantiles of a distance: exceeded with `chances` (falling) at `distances` (rising) [m].

    Between them the probability falls exponentially, and beyond the last at that rate.

    >>> import numpy as np
    >>> quantiles = Quantiles((0.0, 0.5, 1.0), (1.0, 0.1, 0.01))
    >>> quantiles.distance(0.001)
    1.5
    >>> quantiles.chance(np.array([-1.0, 0.5, 1.5])).round(6).tolist()
    [1.0, 0.1, 0.001]
    """

    distances: tuple[float, ...]
    chances: tuple[float, ...]

    def chance(self, distance: Vector) -> Vector:
        logs, slope = self._logs
        inside = np.interp(distance, self.distances, logs)
        return np.asarray(np.exp(inside + slope * np.maximum(distance - self.distances[-1], 0.0)))

    def distance(self, chance: float) -> float:
        logs, slope = self._logs
        log = float(np.log(chance))
        if log <= logs[-1]:
            return float(self.distances[-1] + (log - logs[-1]) / slope)
        return float(np.interp(log, logs[::-1], self.distances[::-1]))

    def longer(self, by: float) -> "Quantiles":
        first, *farther = self.distances
        return replace(self, distances=(first, *(distance + by for distance in farther)))

    def scaled(self, factor: float) -> "Quantiles":
        return replace(self, distances=tuple(factor * distance for distance in self.distances))

    @cached_property
    def _logs(self) -> tuple[Vector, float]:
        logs = np.log(self.chances)
        return logs, (logs[-1] - logs[-2]) / (self.distances[-1] - self.distances[-2])


@dataclass(frozen=True)
class DeviationLaw:
    """Quantiles of the measured deviation from the predicted path.

    Attributes:
        lateral: to one side at a moment of a straight flight.
        down, up: height at a moment.
        lowest, highest: of a whole flight, as a height error persists.
        farthest: to one side, where it does not grow with time.
        doubling_acceleration: lateral acceleration at which `lateral` doubles [m/s^2].
        after_cruise_factor: of the lateral deviation after the last waypoint.
        decorrelation_s, height_decorrelation_s: after which it is independent.
        growth: in wind [m for each m/s, to the side, down, up].
        source: the flights measured.
        strongest: greatest verified wind with gusts [m/s].

    Example:
        >>> from ipoa_mission import Forecast, read_mission
        >>> Forecast(read_mission("missions/sitl.plan")).deviation_law.lateral_bound(0.01) > 0.5
        True
    """

    lateral: Quantiles
    down: Quantiles
    up: Quantiles
    lowest: Quantiles
    highest: Quantiles
    farthest: Quantiles | None
    doubling_acceleration: float
    after_cruise_factor: float
    decorrelation_s: float
    height_decorrelation_s: float
    growth: tuple[float, float, float]
    source: str
    strongest: float

    def widening(self, lateral_accel: Vector) -> Vector:
        return np.asarray(1.0 + lateral_accel / self.doubling_acceleration)

    def lateral_bound(self, chance: float) -> float:
        """Return the lateral deviation [m] exceeded with this probability."""
        independent = 4  # samples in which a flight is near to a limit that is no obstacle
        return self.lateral.distance(chance / independent)

    def in_wind(self, speed: float) -> "DeviationLaw":
        if speed == 0.0:
            return self
        side, down, up = self.growth
        return replace(
            self,
            lateral=self.lateral.longer(side * speed),
            down=self.down.longer(down * speed),
            up=self.up.longer(up * speed),
            lowest=self.lowest.longer(down * speed),
            highest=self.highest.longer(up * speed),
            farthest=self.farthest and self.farthest.longer(side * speed),
        )

    def after_cruise(self) -> "DeviationLaw":
        times = self.after_cruise_factor
        return replace(self, lateral=self.lateral.scaled(times), farthest=self.farthest and self.farthest.scaled(times))


def not_measured(autopilot: Autopilot, wind: float) -> str | None:
    """Return why the law is extrapolated in this wind [m/s], or None."""
    strongest = autopilot.part(DeviationLaw).strongest
    if wind <= strongest:
        return None
    flown = f"the deviation of {autopilot.firmware_name} was measured in wind up to {strongest:g} m/s"
    return f"{flown}: the clearance in {wind:g} m/s is extrapolated"


def law_of(autopilot: Autopilot, wind: float = 0.0) -> DeviationLaw:
    return autopilot.part(DeviationLaw).in_wind(wind)
