"""Find no-fly zones and flight areas in a map."""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Literal, TypeAlias

import shapely

from ipoa_mission.errors import BadInput, NothingThere
from ipoa_mission.geodesy import LocalFrame
from ipoa_mission.geometry import union_of
from ipoa_mission.maps.feature import Feature, Mistakes
from ipoa_mission.maps.geoid import undulation
from ipoa_mission.maps.geozones import RADIUS_UNIT, VerticalLimit, ZoneLimits, limits_of, may_be_active, periods_of
from ipoa_mission.maps.kinds import Reason
from ipoa_mission.maps.map_window import MapWindow
from ipoa_mission.maps.passed import FAR_FROM_HOME, PassedOver, not_read, passed_over
from ipoa_mission.maps.planar import closed_as_polygon, flat, polygons_of, to_plane
from ipoa_mission.maps.tag_heights import radius_of
from ipoa_mission.unread import Unread, gathered

Restriction: TypeAlias = Literal["PROHIBITED", "REQ_AUTHORISATION", "REQ_AUTHORIZATION", "CONDITIONAL", "USPACE"]
RESTRICTIONS: tuple[Restriction, ...] = ("PROHIBITED", "REQ_AUTHORISATION", "CONDITIONAL", "USPACE")


@dataclass(frozen=True)
class MapArea:
    """A valid polygon in east, north [m]."""

    name: str
    shape: Any
    lower: VerticalLimit | None = None
    upper: VerticalLimit | None = None


@dataclass(frozen=True)
class Zones:
    zones: tuple[MapArea, ...]
    passed_over: tuple[PassedOver, ...]
    remarks: tuple[str, ...]
    unread: tuple[Unread, ...] = ()


def find_zones(
    features: Sequence[Feature],
    frame: LocalFrame,
    path: Path,
    restrictions: Sequence[str] = RESTRICTIONS,
    time: float | None = None,
) -> Zones:
    """Return the zones; a closed line counts as a polygon.

    A zone that names a restriction needs one of `restrictions`, and must be active in the hour after `time` [s].
    """
    about = MapWindow.of(frame)
    shapes, near = to_plane([feature.shape for feature in features], frame, about)
    about.expect_near(path)
    mistakes = Mistakes()
    zones = list[MapArea]()
    remarks = list[str]()
    passed, unread = list[PassedOver](), list[Unread]()
    wanted = {_respelled(restriction) for restriction in restrictions}
    for feature, shape, is_near in zip(features, shapes, near, strict=True):
        named = _restrictions(feature.tags)
        if is_near and named and not named & wanted:
            words = f"its restriction is {' and '.join(sorted(named))}"
            passed.append(passed_over(feature, shape, Reason(words, False), path))
            continue
        missed = not_read(feature, frame, path)
        if isinstance(missed, Unread):
            unread.append(missed)
        elif missed is not None:
            passed.append(missed)
        at_times = "limitedApplicability" in feature.tags
        if is_near and at_times and time is not None and not may_be_active(feature.tags, time):
            passed.append(passed_over(feature, shape, Reason("not active in the hour of the flight", False), path))
            continue
        limits = limits_of(feature.tags)
        if is_near:
            unread += _not_understood(feature, limits, bool(named), path)
            limits, unknown = _above_sea(limits, feature.name, frame, path, remarks)
            unread += unknown
        parts = [_outline(part, feature.tags) for part in flat(shape)]
        rest = [part for part in parts if part.geom_type != "Polygon"]
        if rest or not (parts or missed):
            why = _why_no_zone(rest) if is_near else FAR_FROM_HOME
            passed.append(passed_over(feature, shapely.GeometryCollection(rest), why, path))
        for outline in (part for part in parts if part.geom_type == "Polygon"):
            if (mended := mistakes.attempt(polygons_of, outline, feature.place)) is None:
                continue
            zones += [MapArea(feature.name, polygon, limits.lower, limits.upper) for polygon in mended[0]]
            if at_times and (time is None or periods_of(feature.tags) is None):
                remarks.append(f"{feature.name}: active at times only, kept at all times")
            if mended[1]:
                remarks.append(f"{feature.name}: mended ({mended[1]})")
    mistakes.raise_all()
    if not zones and not any("restriction" in thing.reason or "active" in thing.reason for thing in passed):
        raise NothingThere(f"expected a polygon, but there is none among {len(features)} features", place=path)
    return Zones(tuple(zones), tuple(passed), tuple(remarks), gathered(unread))


def _respelled(restriction: str) -> str:
    return restriction.replace("AUTHORIZATION", "AUTHORISATION")


def _restrictions(tags: Mapping[str, str]) -> set[str]:
    """Read `restriction` (ED-269), `restrictio` (its shapefiles) or `type` (ED-318)."""
    values = {_respelled(tags[key].strip().upper()) for key in ("restriction", "restrictio", "type") if key in tags}
    return values & {*RESTRICTIONS, "NO_RESTRICTION"}


def _not_understood(feature: Feature, limits: ZoneLimits, is_named: bool, path: Path) -> Iterator[Unread]:
    tags, place = feature.tags, feature.name.removeprefix(f"{path}: ")
    yield from (Unread(path.name, subject, place, value) for subject, value in limits.not_understood)
    if "restriction" in tags and not is_named:
        yield Unread(path.name, "restriction, taken as one that keeps a flight out", place, tags["restriction"])
    if (kind := tags.get("type", tags.get("Type", ""))).lower() in ("inclusive", "inclusion"):
        yield Unread(path.name, "area to stay inside, taken as one that keeps a flight out", place, kind)
    if RADIUS_UNIT in tags:
        yield Unread(path.name, "unit of a radius, taken as m", place, tags[RADIUS_UNIT])


def _above_sea(
    limits: ZoneLimits, name: str, frame: LocalFrame, path: Path, remarks: list[str]
) -> tuple[ZoneLimits, list[Unread]]:
    """Convert ellipsoidal limits to mean sea level, safely if the geoid is unknown."""
    ends, unknown = {"lower": limits.lower, "upper": limits.upper}, list[Unread]()
    for side, limit in ends.items():
        if limit is None or limit.reference != "WGS84":
            continue
        stated = f"{limit.height:g} m WGS84"
        try:
            geoid, how = undulation(frame.home.latitude_deg, frame.home.longitude_deg, None, path)
            remarks.append(f"{name}: {side} limit {stated} taken less {geoid:.2f} m of geoid ({how})")
        except BadInput:
            geoid = -107.0 if side == "upper" else 86.0  # extremes of EGM96 and EGM2008
            subject = f"geoid under the {side} limit, taken as {geoid:g} m above the ellipsoid, the worst"
            unknown.append(Unread(path.name, subject, name.removeprefix(f"{path}: "), stated))
        ends[side] = VerticalLimit(limit.height - geoid, "AMSL")
    return replace(limits, lower=ends["lower"], upper=ends["upper"]), unknown


def join_zones(zones: Sequence[MapArea]) -> tuple[Any, tuple[Any, ...]]:
    """Return the part nearest to home, and the others."""
    whole = union_of([zone.shape for zone in zones])
    nearest, *others = sorted(shapely.get_parts(whole), key=lambda part: float(part.distance(shapely.Point(0.0, 0.0))))
    return nearest, tuple(others)


def _why_no_zone(rest: Sequence[Any]) -> Reason:
    if not rest:
        return Reason("without a geometry", False)
    if all(part.geom_type == "Point" for part in rest):
        return Reason("a point", False)
    remedy = "close the line in the map, so that it is the edge of a zone, or take it out"
    return Reason("a line that encloses no area", True, remedy)


def _outline(shape: Any, tags: Mapping[str, str]) -> Any:
    if shape.geom_type == "Point" and (radius := radius_of(tags)) is not None:
        return shape.buffer(radius / math.cos(math.pi / 64), quad_segs=16)  # circumscribed: 64 corners
    return closed_as_polygon(shape)
