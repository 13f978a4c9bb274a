from dataclasses import dataclass

import numpy as np

from ipoa_mission.geometry import Vector


@dataclass(frozen=True)
class Quantiles:
    """Measured quantiles of a distance: exceeded with `chances` (falling) at `distances` (rising) [m].

    Between them the probability falls exponentially, and beyond the last at the same rate as before it.

    >>> import numpy as np
    >>> spread = Quantiles((0.0, 0.5, 1.0), (1.0, 0.1, 0.01))
    >>> spread.distance(0.001)
    1.5
    >>> spread.chance(np.array([-1.0, 0.5, 1.5])).round(6).tolist()
    [1.0, 0.1, 0.001]
    """

    distances: tuple[float, ...]
    chances: tuple[float, ...]

    def chance(self, distance: Vector) -> Vector:
        logs = np.log(self.chances)
        slope = (logs[-1] - logs[-2]) / (self.distances[-1] - self.distances[-2])
        inside = np.interp(distance, self.distances, logs)
        return np.asarray(np.exp(inside + slope * np.maximum(distance - self.distances[-1], 0.0)))

    def distance(self, chance: float) -> float:
        logs = np.log(self.chances)
        slope = (logs[-1] - logs[-2]) / (self.distances[-1] - self.distances[-2])
        log = float(np.log(chance))
        if log <= logs[-1]:
            return float(self.distances[-1] + (log - logs[-1]) / slope)
        return float(np.interp(log, logs[::-1], self.distances[::-1]))
