"""Compute the area that tours and forecast flights see."""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np
import shapely

from ipoa_mission.forecast.forecast import Forecast
from ipoa_mission.forecast.timing.track import THINNING_TOLERANCE, Track
from ipoa_mission.geodesy import LocalFrame
from ipoa_mission.geometry import Points
from ipoa_mission.survey.survey_area import ARC, Area
from ipoa_mission.survey.survey_lines import union_along
from ipoa_mission.survey.survey_section import between
from ipoa_mission.survey.tour import Tour


@dataclass(frozen=True)
class AsFlown:
    """The seen share of the visible area, and how far paths leave the area [m]."""

    share: float
    outside_m: float


def as_flown(flights: Iterable[tuple[Track, Points]], area: Any, visible: Any, width: float) -> AsFlown:
    """Return the coverage of flights: tracks, and the times (n, 2) at which lines begin and end [s]."""
    lines, outside = list[Any](), 0.0
    shapely.prepare(area)
    for track, ends in flights:
        lines += [_path(track, *times) for times in ends.tolist()]
        whole = _path(track, float(ends[0, 0]), float(ends[-1, 1]))
        strayed = shapely.points(shapely.get_coordinates(whole.difference(area)))
        outside = max(outside, float(shapely.distance(area, strayed).max(initial=0.0)))
    unseen = visible.difference(union_along(np.array(lines), width / 2, arc=16)).area
    return AsFlown(1.0 - unseen / visible.area, outside)


def expected_lines(forecast: Forecast, tour: Tour, frame: LocalFrame) -> tuple[Track, Points]:
    """Return the track, and when lines begin and end (n, 2) [s]."""
    tolerance = 0.05  # between an item and its line's end [m]
    prediction, move = forecast.guarantee.flight.prediction, between(forecast.frame, frame)
    items = [visit.item for visit in forecast.itinerary.visits]
    latitude, longitude = np.array([[item.latitude_deg, item.longitude_deg] for item in items]).T
    places = frame.to_local(latitude, longitude, forecast.mission.home.altitude)[:, :2]
    visits, n = list[int](), 0
    for end in (end for swath in tour.swaths for end in (swath.begin, swath.end)):
        n += int(np.argmax(np.linalg.norm(places[n:] - end, axis=1) < tolerance))
        visits.append(n)
    track = prediction.track
    plan = np.column_stack([move(track.points[:, :2]), track.points[:, 2]])
    return Track(track.times, plan, track.speeds), prediction.done[visits].reshape(-1, 2)


def _path(track: Track, begin: float, end: float) -> Any:
    before = max(int(np.searchsorted(track.times, begin, "right")) - 1, 0)
    near = slice(before, np.searchsorted(track.times, end) + 1)  # for speed
    first, last = Track(track.times[near], track.points[near], track.speeds[near]).at(np.array([begin, end]))
    places = np.vstack([first, track.between(begin, end).points, last])[:, :2]
    return shapely.simplify(shapely.LineString(places), THINNING_TOLERANCE, preserve_topology=False)


@dataclass(frozen=True, eq=False)
class Coverage:
    """The seen part of an area.

    Attributes:
        share: of `Area.visible`, 0 to 1.
        gaps: of what can be covered (shapely).
        seen: shapely.
        outside_m: farthest the path is outside the area, or inside a hole or `keep_out` [m].
    """

    share: float
    gaps: Any
    seen: Any
    outside_m: float


def coverage(area: Area, tour: Tour, width: float, keep_out: Any = None) -> Coverage:
    """Return the coverage by a tour; `width` [m] of the sensor, `keep_out` a shapely geometry."""
    can = area.visible(keep_out, width)
    lines = np.array([swath.ends for swath in tour.swaths]).reshape(-1, 2, 2)
    seen = area.shape.intersection(union_along(shapely.linestrings(lines), width / 2, ARC))
    gaps = can.difference(seen)
    whole = float(can.area)
    share = 1.0 if whole <= 0.0 else 1.0 - float(gaps.area) / whole
    return Coverage(share, gaps, seen, _outside(area.shape, tour, keep_out))


def _outside(shape: Any, tour: Tour, keep_out: Any) -> float:
    """Return how far a tour leaves an area [m]."""

    def places(stray: Any) -> Any:
        return shapely.points(shapely.get_coordinates(shapely.segmentize(stray, max(0.1, stray.length / 20_000))))

    if len(tour.path) < 2:
        return 0.0
    path = shapely.LineString(tour.path)
    farthest = [float(shape.distance(place)) for place in places(path.difference(shape))]
    if keep_out is not None:
        farthest += [float(keep_out.boundary.distance(place)) for place in places(path.intersection(keep_out))]
    return max(farthest, default=0.0)
