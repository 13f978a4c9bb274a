from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise
from typing import TypeAlias

import numpy as np

from ipoa_mission.forecast.forecast import Forecast
from ipoa_mission.forecast.itinerary.flown_legs import Leg
from ipoa_mission.mission.items import FenceCircle, FencePolygon, Mission
from ipoa_mission.world.frame import Geodetic, LocalFrame

Place: TypeAlias = tuple[float, float, float]
"""Longitude [deg], latitude [deg], altitude [m]."""


@dataclass(frozen=True)
class Stretch:
    """Points that do not cross the antimeridian; AMSL, or above the ground if `over_terrain`."""

    points: tuple[Place, ...]
    over_terrain: bool


def marks_of(mission: Mission) -> Iterator[tuple[str, Place]]:
    """Yield home and the rally points with their names, AMSL."""
    home = mission.home
    yield "home", (home.longitude_deg, home.latitude_deg, home.altitude)
    for n, place in enumerate(mission.rally, start=1):
        yield f"rally {n}", (place.longitude_deg, place.latitude_deg, home.altitude + place.altitude)


def lines_of(forecast: Forecast) -> tuple[Stretch, ...]:
    """Return the way from home and back, down to the scenario's ground."""
    is_unknown = forecast.scenario is None and forecast.ground.is_level
    lines: list[Stretch] = []
    for leg in forecast.legs:
        for stretch in _stretches(leg, forecast.frame, forecast.mission.home.altitude if is_unknown else None):
            before = lines[-1] if lines else None
            joins = before and before.over_terrain == stretch.over_terrain and before.points[-1] == stretch.points[0]
            if before and joins and not leg.alternative:
                lines[-1] = Stretch(before.points + stretch.points[1:], stretch.over_terrain)
            elif not leg.alternative or leg.jumped_from >= 0:
                lines.append(stretch)
    return tuple(lines)


def _stretches(leg: Leg, frame: LocalFrame, unknown_ground: float | None) -> Iterator[Stretch]:
    latitude, longitude, altitude = frame.to_geodetic(leg.points)
    over_terrain = leg.over_terrain and unknown_ground is not None
    altitude = altitude - (unknown_ground or 0.0) if over_terrain else altitude
    places = [
        (round(float(lon), 9), round(float(lat), 9), round(float(alt), 3))
        for lat, lon, alt in zip(latitude, longitude, altitude, strict=True)
    ]
    yield from (Stretch(tuple(line), over_terrain) for line in _cut_at_antimeridian(places))


def _cut_at_antimeridian(places: list[Place]) -> list[list[Place]]:
    """Cut a line at longitude 180: RFC 7946, 3.1.9."""
    lines = [[places[0]]]
    for place in places[1:]:
        before = lines[-1][-1]
        if abs(place[0] - before[0]) > 180:
            side = float(np.sign(before[0])) * 180.0
            there = (place[0] + 2 * side, *place[1:])
            share = (side - before[0]) / (there[0] - before[0])
            latitude, altitude = (round(a + share * (b - a), 9) for a, b in zip(before[1:], there[1:], strict=True))
            lines[-1].append((side, latitude, altitude))
            lines.append([(-side, latitude, altitude)])
        lines[-1].append(place)
    return lines


def ring(part: FencePolygon | FenceCircle) -> list[tuple[float, float]]:
    """Return (longitude, latitude), closed and counterclockwise as in GeoJSON and KML.

    A circle's 72 corners cut off at most a thousandth of its radius.
    """
    if isinstance(part, FenceCircle):
        angles = np.linspace(0.0, 2.0 * np.pi, 72, endpoint=False)
        circle = part.radius * np.column_stack([np.cos(angles), np.sin(angles), np.zeros(len(angles))])
        latitude, longitude, _ = LocalFrame(Geodetic(*part.center)).to_geodetic(circle)
        corners = [(round(float(lon), 9), round(float(lat), 9)) for lat, lon in zip(latitude, longitude, strict=True)]
    else:
        corners = [(lon, lat) for lat, lon in part.vertices]
    closed = [*corners, corners[0]]
    doubled_area = sum(a[0] * b[1] - b[0] * a[1] for a, b in pairwise(closed))
    return closed if doubled_area >= 0 else closed[::-1]
