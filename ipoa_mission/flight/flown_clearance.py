"""What a flight kept of a scenario's clearance: its flown path against the terrain and the obstacles."""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from ipoa_mission.centimeters import down, falls_short, up
from ipoa_mission.forecast.forecast import Forecast
from ipoa_mission.geometry import Points
from ipoa_mission.link.logbook import FlightRecord
from ipoa_mission.mission.items import Mission
from ipoa_mission.scenario import Scenario
from ipoa_mission.world.airspace import Clearance
from ipoa_mission.world.frame import Geodetic, LocalFrame, apart

#: A flight that begins farther from the scenario's home is of another place [m].
SAME_PLACE = 20_000.0
#: It rises and sinks straight up and down within so much [m].
COLUMN = 3.0


@dataclass(frozen=True)
class FlownClearance:
    """How near a flight came to anything, against what the scenario requires and what its mission has [m].

    `least` is where the least is left of what is required; its place is east, north, up of the scenario's home, and
    `place` the same on the Earth; `time_s` is since the arming. `planned` is the clearance of the mission's own legs,
    `strayed` the farthest that the flight was from them between its first and last waypoint; both are None without a
    mission that flies somewhere. `promised` is what the mission promises to keep.
    """

    least: Clearance
    place: Geodetic
    time_s: float
    required: float
    planned: float | None = None
    strayed: float | None = None
    promised: float | None = None

    @property
    def kept(self) -> bool:
        """Whether the flight kept what is required, as both are printed."""
        return not falls_short(self.least.distance, self.required)

    def words(self) -> str:
        """The finding in a sentence without a full stop."""
        where = f"{self.place.latitude_deg:.6f}, {self.place.longitude_deg:.6f}, up {self.least.place[2]:.1f} m"
        promised = "" if self.promised is None else f", {down(self.promised):.2f} m promised"
        strayed = "" if self.strayed is None else f"; at most {self.strayed:.1f} m from the planned legs"
        verdict = "" if self.kept else ", which was NOT kept"
        return (
            f"least clearance flown {down(self.least.distance):.2f} m, to {self.least.what} at {where}, "
            f"{self.time_s:.1f} s after arming{promised}; {up(self.required):.2f} m required{verdict}{strayed}"
        )


def flown_clearance(record: FlightRecord, scenario: Scenario, mission: Mission | None = None) -> FlownClearance | None:
    """The least clearance of a flown path; None where the log has no path at the scenario's place.

    Heights are those above the place of arming, which stands on the scenario's ground. The ground counts from the
    first time that it was cleared by what is required until the last, so not for take-off and landing; where all of
    that was kept, the rest of the climb and of the descent is left out too. Obstacles always count. What is
    promised is what the mission promises at the scenario's confidence.

    Raises:
        BadInput: the flight is of another place than the scenario.
        BadInput, MissionError: as the scenario's maps.
    """
    if len(record.path) < 2:
        return None
    begins = Geodetic(record.path[0].latitude_deg, record.path[0].longitude_deg)
    scenario.expect_here(begins)
    if apart(begins, scenario.frame.home) > SAME_PLACE:
        return None
    points, times = _flown(record, scenario), np.array([sample.time_s for sample in record.path])
    least, required = _least(points, scenario)
    if not np.isfinite(least.distance):
        return None
    near = int(np.argmin(np.linalg.norm(points - np.asarray(least.place), axis=1)))
    place = scenario.frame.geodetic(np.asarray(least.place))
    planned = strayed = promised = None
    forecast = None if mission is None else Forecast(mission, scenario)
    if forecast is not None and (legs := forecast.cruise):
        checks = forecast.proof.checks
        planned = min(check.nearest.distance for check in checks if check.limit in ("obstacles", "ground"))
        strayed = _farthest(_between(points, legs[0].points[0], legs[-1].points[-1]), [leg.points for leg in legs])
        promise = forecast.promise_if_known
        kept = None if promise is None else promise.clearance
        promised = None if kept is None else kept.kept
    return FlownClearance(least, place, float(times[near]), required, planned, strayed, promised)


def _flown(record: FlightRecord, scenario: Scenario) -> Points:
    """The path in the scenario's frame, (n, 3)."""
    latitude, longitude, height = (
        np.array([getattr(sample, name) for sample in record.path])
        for name in ("latitude_deg", "longitude_deg", "height")
    )
    frame: LocalFrame = scenario.frame
    level = frame.to_local(latitude, longitude, frame.home.altitude)
    ground = float(scenario.airspace.ground(level[:1])[0])
    return frame.to_local(latitude, longitude, frame.home.altitude + ground + height)


def _least(points: Points, scenario: Scenario) -> tuple[Clearance, float]:
    """The clearance, to an obstacle or to the ground, with the least left of what is required, and that."""
    world, limits = scenario.airspace, scenario.limits
    clearances = [(world.obstacle_clearance(points), limits.obstacle_distance)]
    high = np.flatnonzero(points[:, 2] - world.ground(points) >= limits.height_above_ground)
    if len(high) and high[-1] > high[0]:
        over = points[high[0] : high[-1] + 1]
        ground = world.terrain_clearance(over)
        way = over[_in_column(over) : len(over) - _in_column(over[::-1])]
        if falls_short(ground.distance, limits.height_above_ground):
            clearances.append((ground, limits.height_above_ground))
        elif len(way) > 1:  # where it rose and sank it came through every height, which tells nothing
            clearances.append((world.terrain_clearance(way), limits.height_above_ground))
    return min(clearances, key=lambda one: one[0].distance - one[1])


def _in_column(points: Points) -> int:
    """How many points, from the first, are above it or below it."""
    beside = np.flatnonzero(np.linalg.norm((points - points[0])[:, :2], axis=1) > COLUMN)
    return int(beside[0]) if len(beside) else len(points)


def _between(points: Points, first: Points, last: Points) -> Points:
    begin = int(np.argmin(np.linalg.norm(points - first, axis=1)))
    end = int(np.argmin(np.linalg.norm(points - last, axis=1)))
    return points[begin : max(end, begin) + 1]


def _farthest(points: Points, polylines: list[Points]) -> float:
    """The greatest distance of points (n, 3) to the nearest of some polylines."""
    nearest = np.full(len(points), np.inf)
    for polyline in polylines:
        for a, b in pairwise(polyline):
            along, square = b - a, float(np.dot(b - a, b - a))
            share = np.clip((points - a) @ along / square, 0.0, 1.0) if square else np.zeros(len(points))
            nearest = np.minimum(nearest, np.linalg.norm(points - (a + share[:, None] * along), axis=1))
    return float(nearest.max())
