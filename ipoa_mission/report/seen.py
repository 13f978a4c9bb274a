from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import shapely

from ipoa_mission.centimeters import down, falls_short, up
from ipoa_mission.forecast.deviation.kept_limits import NO_DEVIATION, DeviationBound, deviation_bound_of
from ipoa_mission.forecast.deviation.law import law_of
from ipoa_mission.forecast.forecast import Forecast
from ipoa_mission.forecast.timing.track import Track
from ipoa_mission.geometry import Points, Vector, arc_lengths
from ipoa_mission.scenario import Scenario
from ipoa_mission.world.airspace import Airspace

SAMPLES = 800
LANDING_RADIUS = 1.0  # [m]


@dataclass(frozen=True, eq=False)
class Seen(Track):
    """Samples of a track, with the distance over ground `along` (n,) [m].

    `ground` is the height below [m], `apart` the distance to the nearest obstacle [m], or infinite.
    """

    along: Vector
    ground: Vector
    apart: Vector


def follow(track: Track, airspace: Airspace, samples: int = SAMPLES) -> Seen:
    """Sample densely where a path is slow and where it is fast.

    A landing ends on the ground, which the time models ignore.
    """
    gone = arc_lengths(track.points[:, :2])
    share = track.times / max(float(track.times[-1]), 1e-9) + gone / max(float(gone[-1]), 1e-9)
    wanted = np.linspace(share[0], share[-1], samples)
    times = np.interp(wanted, share, track.times)
    points = track.at(times)
    ground = airspace.ground(points)
    landing = np.hypot(*(points[:, :2] - points[-1, :2]).T) < LANDING_RADIUS
    points[landing, 2] = np.maximum(points[landing, 2], ground[landing])
    return Seen(
        times=times,
        along=arc_lengths(points[:, :2]),
        points=points,
        speeds=np.interp(times, track.times, track.speeds),
        ground=ground,
        apart=airspace.obstacle_distance(points),
    )


def deviation_bound_seen(forecast: Forecast) -> DeviationBound:
    scenario = forecast.world
    chance = scenario.safety.chance
    return (
        NO_DEVIATION
        if chance is None
        else deviation_bound_of(law_of(forecast.mission.autopilot, scenario.wind.strongest), chance)
    )


def outline_round(points: Points, level: float) -> list[Points]:
    """Return closed rings within `level` [m], the outer one first."""
    if level <= 0.0:
        return []
    around = shapely.LineString(points[:, :2]).simplify(level / 10).buffer(level, quad_segs=4)
    return [shapely.get_coordinates(ring) for ring in (around.exterior, *around.interiors)]


@dataclass(frozen=True)
class Danger:
    """`touching`: the hull would collide."""

    words: str
    touching: bool


def dangers(course: Seen, scenario: Scenario) -> list[Danger]:
    """Return where the path, a cut corner or the return comes too close; ground only where the path meets it."""
    met, required = [], scenario.limits.obstacle_distance
    nearest = scenario.airspace.obstacle_clearance(course.points)
    if falls_short(nearest.distance, required):
        how = "runs into" if nearest.distance < 0 else f"comes within {down(nearest.distance):.2f} m of"
        where = _where(course.times[nearest.leg], nearest.place)
        words = f"the path as predicted {how} {nearest.what} {where}; {up(required):.2f} m are required"
        met.append(Danger(words, nearest.distance < scenario.vehicle.radius))
    height = course.points[:, 2] - course.ground
    away = np.hypot(*(course.points[:, :2] - course.points[0, :2]).T) > LANDING_RADIUS
    lowest = int(np.argmin(np.where(away, height, np.inf)))
    if away[lowest] and height[lowest] < 0:
        where = _where(course.times[lowest], course.points[lowest])
        met.append(Danger(f"the path as predicted runs into the ground {where}", True))
    return met


def _where(time: float, place: Sequence[float] | Vector) -> str:
    east, north, up = place
    return f"after {time:.0f} s, at east {east:.0f}, north {north:.0f}, up {up:.0f} m"
