"""Compute the coverage and overlaps of tours and forecast flights, over the ground: roofs overlap less."""

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
import shapely

from ipoa_mission import Command, Forecast
from ipoa_mission.forecast.timing.track import THINNING_TOLERANCE, Track
from ipoa_mission.geodesy import Geodetic
from ipoa_mission.geometry import Matrix, Points, Vector
from ipoa_mission.ground import Ground
from ipoa_mission.survey.sight import Sight, lift_path
from ipoa_mission.survey.survey_area import ARC, Area
from ipoa_mission.survey.survey_lines import union_along
from ipoa_mission.survey.tour import Swath, Tour


@dataclass(frozen=True)
class AsFlown:
    """The seen share of the visible area, and how far paths leave the area [m]."""

    share: float
    outside_m: float


def as_flown(flights: Iterable[tuple[Track, Matrix]], area: Any, visible: Any, width: float) -> AsFlown:
    """Return the coverage of flights: tracks, and the times (n, 2) at which lines begin and end [s]."""
    lines = list[Any]()
    outside = 0.0
    shapely.prepare(area)
    for track, ends in flights:
        lines += [_path(track, *times) for times in ends.tolist()]
        flight_path = _path(track, float(ends[0, 0]), float(ends[-1, 1]))
        strayed = shapely.points(shapely.get_coordinates(flight_path.difference(area)))
        outside = max(outside, float(shapely.distance(area, strayed).max(initial=0.0)))
    unseen = visible.difference(union_along(np.array(lines), width / 2, arc=16)).area
    return AsFlown(1.0 - unseen / visible.area, outside)


def predict_lines(forecast: Forecast, tour: Tour) -> tuple[Track, Matrix]:
    """Return the track, and when lines begin and end (n, 2) [s]."""
    tolerance = 0.05  # between an item and its line's end [m]
    prediction = forecast.guarantee.flight.prediction
    items = [visit.item for visit in forecast.itinerary.visits]
    latitude, longitude = np.array([[item.latitude_deg, item.longitude_deg] for item in items]).T
    places = forecast.mission.frame.to_local(latitude, longitude, forecast.mission.home.altitude)[:, :2]
    visits = list[int]()
    n = 0
    for end in (end for swath in tour.swaths for end in (swath.begin, swath.end)):
        n += int(np.argmax(np.linalg.norm(places[n:] - end, axis=1) < tolerance))
        visits.append(n)
    return prediction.track, prediction.done[visits].reshape(-1, 2)


def _path(track: Track, begin: float, end: float) -> Any:
    before = max(int(np.searchsorted(track.times, begin, "right")) - 1, 0)
    near = slice(before, np.searchsorted(track.times, end) + 1)  # for speed
    first, last = Track(track.times[near], track.points[near], track.speeds[near]).at(np.array([begin, end]))
    places = np.vstack([first, track.between(begin, end).points, last])[:, :2]
    return shapely.simplify(shapely.LineString(places), THINNING_TOLERANCE, preserve_topology=False)


@dataclass(frozen=True, eq=False)
class Coverage(AsFlown):
    """Of lines: also the gaps of the visible area, and the seen area."""

    gaps: Any
    seen: Any


def coverage(area: Area, tour: Tour, width: float, keep_out: Any = None) -> Coverage:
    """Return the coverage by a tour; `width` [m] of the sensor, `keep_out` a shapely geometry."""
    can = area.visible(keep_out, width)
    seen = area.shape.intersection(union_along(shapely.linestrings(tour.lines), width / 2, ARC))
    gaps = can.difference(seen)
    visible_m2 = float(can.area)
    share = 1.0 if visible_m2 <= 0.0 else 1.0 - float(gaps.area) / visible_m2
    return Coverage(share, _outside(area.shape, tour, keep_out), gaps, seen)


def _outside(shape: Any, tour: Tour, keep_out: Any) -> float:

    def places(part: Any) -> Any:
        return shapely.points(shapely.get_coordinates(shapely.segmentize(part, max(0.1, part.length / 20_000))))

    if len(tour.path) < 2:
        return 0.0
    path = shapely.LineString(tour.path)
    farthest = [float(shape.distance(place)) for place in places(path.difference(shape))]
    if keep_out is not None:
        farthest += [float(keep_out.boundary.distance(place)) for place in places(path.intersection(keep_out))]
    return max(farthest, default=0.0)


@dataclass(frozen=True)
class Overlap:
    """The smallest share of a photo, and that photo's place, east and north [m]."""

    share: float
    at: tuple[float, float]


@dataclass(frozen=True)
class Overlaps:
    """The smallest overlap with the next photo and with the next line's, or None."""

    front: Overlap | None
    side: Overlap | None

    def __str__(self) -> str:
        parts = (("ahead", self.front), ("to the side", self.side))
        return " and ".join(f"{100 * least.share:.1f} % {direction}" for direction, least in parts if least is not None)

    def falls_short(self, front: float, side: float) -> Iterator[str]:
        rounding = 0.002  # of a photo, by coordinates in 1e-7 degrees
        for name, least, requested in (("front", self.front, front), ("side", self.side, side)):
            if least is not None and least.share < requested - rounding:
                where = "at east {:.0f}, north {:.0f} m".format(*least.at)
                yield f"survey.{name}_overlap: {100 * requested:.0f} % requested, but {100 * least.share:.1f} % {where}"


@dataclass(frozen=True, eq=False)
class PhotoLine:
    """A straight line's ends (2, 3), and its photos' places."""

    ends: Points
    photos: Points

    @property
    def ahead(self) -> Vector:
        leg = self.ends[1, :2] - self.ends[0, :2]
        return np.asarray(leg / np.linalg.norm(leg))


def smallest_overlaps(lines: Sequence[PhotoLine], sight: Sight, ground: Ground, free: Any) -> Overlaps:
    """Return the smallest overlaps of all photos; lines are neighbors only across the polygons `free`."""
    half = sight.across / sight.least / 2, sight.along / sight.least / 2
    fronts = list[Overlap]()
    sides = list[Overlap]()
    shapely.prepare(free)
    for line in lines:
        ahead = line.ahead
        if len(line.photos) > 1:
            fronts.append(_least(_shares(line.photos[:-1], line.photos[1:], ahead, half[::-1], ground), line.photos))
        right = np.array([ahead[1], -ahead[0]])
        for towards in (right, -right):
            taken, others = _neighbors(line, lines, towards, sight, free)
            if len(taken):
                sides.append(_least(_shares(taken, others, towards, half, ground), taken))
    return Overlaps(*(min(overlaps, key=lambda each: each.share, default=None) for overlaps in (fronts, sides)))


def lines_of_forecast(forecast: Forecast, lag: float) -> Iterator[PhotoLine]:
    """Return the lines with photos; `lag`: a photo's mean delay [m], at most twice as much."""
    home = forecast.mission.home
    every = 0.0
    begin: Vector | None = None
    for item in forecast.mission.items:
        if item.command == Command.DO_SET_CAM_TRIGG_DIST:
            every = item.params[0]
        elif item.command == Command.NAV_WAYPOINT:
            place = Geodetic(item.latitude_deg, item.longitude_deg, home.altitude + item.height(home))
            end = np.asarray(forecast.mission.frame.local(place))
            if begin is not None and every > 0.0 and (end[:2] != begin[:2]).any():
                yield _line(begin, end, every + 2 * lag)
            begin = end


def lines_of_tour(tour: Tour, sight: Sight, ground: Ground) -> Iterator[PhotoLine]:
    for swath in tour.swaths:
        every = sight.triggering(swath.length)[0]
        if every > 0.0 and swath.length > 0.0:
            for begin, end in pairwise(lift_path(swath.ends, sight, ground)[0]):
                yield _line(begin, end, every + 2 * sight.lag)


def photo_places(swath: Swath, sight: Sight) -> Points:
    distance, count = sight.triggering(swath.length)
    return np.asarray(swath.begin + np.arange(count)[:, None] * (distance + sight.lag) * swath.ahead)


def _line(begin: Vector, end: Vector, apart: float) -> PhotoLine:
    length = float(np.linalg.norm(end[:2] - begin[:2]))
    shares = np.arange(0.0, length, apart) / length
    return PhotoLine(np.array([begin, end]), begin + shares[:, None] * (end - begin))


def _shares(taken: Points, others: Points, towards: Vector, half: tuple[float, float], ground: Ground) -> Vector:
    """Return the share (n,) of each photo (n, 3) that another one (n, 3), in direction `towards` (2,), shows too.

    `half`: half of the footprint in that direction, and across, per meter of height.
    """
    aside = np.array([-towards[1], towards[0]])
    along = np.linspace(-1.0, 1.0, num=41)
    across = np.linspace(-1.0, 1.0, num=5)
    rays = (along[None, :, None] * half[0] * towards + across[:, None, None] * half[1] * aside).reshape(-1, 2)
    height = taken[:, 2] - ground(taken)
    for _ in range(6):
        seen = taken[:, None, :2] + height.reshape(len(taken), -1, 1) * rays
        height = taken[:, 2:] - ground(seen.reshape(-1, 2)).reshape(len(taken), -1)
    above = others[:, 2:] - (taken[:, 2:] - height)
    there = ((seen - others[:, None, :2]) @ towards) / (half[0] * np.maximum(above, 1e-6))
    there = np.maximum.accumulate(there.reshape(len(taken), len(across), len(along)), axis=2)
    begins = np.array([[np.interp(-1.0, row, along) for row in photo] for photo in there])
    begins[there[:, :, -1] < -1.0] = 1.0
    return np.asarray((1.0 - begins).mean(axis=1) / 2)


def _neighbors(
    line: PhotoLine, lines: Sequence[PhotoLine], towards: Vector, sight: Sight, free: Any
) -> tuple[Points, Points]:
    """Return the photos (n, 3) with a neighboring line on one side, and the nearest places (n, 3) on that."""
    ends = np.array([other.ends for other in lines])
    legs = ends[:, 1, :2] - ends[:, 0, :2]
    lengths = np.linalg.norm(legs, axis=1)
    ahead = line.ahead
    max_sine = math.sin(math.radians(2.0))
    is_parallel = np.abs(legs[:, 0] * ahead[1] - legs[:, 1] * ahead[0]) < max_sine * lengths
    ends = ends[is_parallel]
    legs = legs[is_parallel]
    lengths = lengths[is_parallel]
    off = line.photos[:, None, :2] - ends[None, :, 0, :2]
    share = (off * legs).sum(axis=2) / lengths**2
    away = ((share[:, :, None] * legs - off) * towards).sum(axis=2)
    beyond = np.abs(share - np.clip(share, 0.0, 1.0)) * lengths
    min_separation = 0.1 * sight.spacing  # nearer lines are one line
    tolerance = 0.05  # [m]
    is_neighbor = (beyond <= sight.spacing / 2) & (away > min_separation) & (away < sight.across)
    away = np.where(is_neighbor, away, np.inf)
    apart = away.min(axis=1)
    n = np.flatnonzero(np.isfinite(apart))
    other = away.argmin(axis=1)[n]
    along = np.clip(share[n, other, None], 0.0, 1.0)
    others = ends[other, 0] + along * (ends[other, 1] - ends[other, 0])
    is_near = apart[n] <= sight.spacing + tolerance
    between = shapely.linestrings(np.stack([line.photos[n, :2], others[:, :2]], axis=1))
    is_near[~is_near] = shapely.covers(free, between[~is_near])
    return line.photos[n[is_near]], others[is_near]


def _least(shares: Vector, taken: Points) -> Overlap:
    worst = int(shares.argmin())
    east, north = taken[worst, :2].tolist()
    return Overlap(float(shares[worst]), (east, north))
