from dataclasses import dataclass

import numpy as np

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
