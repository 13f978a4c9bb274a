import math
import re
from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any, Literal, NamedTuple, TypeAlias

import shapely

from ipoa_mission.errors import BadInput, NothingThere
from ipoa_mission.geodesy import LocalFrame
from ipoa_mission.geometry import union_of
from ipoa_mission.maps.feature import Feature, Mistakes
from ipoa_mission.maps.geoid import undulation
from ipoa_mission.maps.geozones import RADIUS_UNIT, VerticalLimit, limits_of, may_be_active, periods_of
from ipoa_mission.maps.kinds import Reason
from ipoa_mission.maps.lengths import length_of
from ipoa_mission.maps.map_window import MapWindow
from ipoa_mission.maps.passed import FAR_FROM_HOME, MapNotes, PassedOver
from ipoa_mission.maps.planar import close_as_polygon, polygons_of, simple_parts, to_plane
from ipoa_mission.maps.tag_heights import width_of
from ipoa_mission.unread import Unread, gathered

Restriction: TypeAlias = Literal["PROHIBITED", "REQ_AUTHORISATION", "REQ_AUTHORIZATION", "CONDITIONAL", "USPACE"]
RESTRICTIONS: tuple[Restriction, ...] = ("PROHIBITED", "REQ_AUTHORISATION", "CONDITIONAL", "USPACE")
INACTIVE = Reason("not active in the hour of the flight", False)


class MapArea(NamedTuple):
    """A valid polygon in east, north [m]."""

    name: str
    shape: Any
    lower: VerticalLimit | None = None
    upper: VerticalLimit | None = None


class Zones(NamedTuple):
    zones: tuple[MapArea, ...]
    passed_over: tuple[PassedOver, ...]
    remarks: tuple[str, ...]
    unread: tuple[Unread, ...] = ()


def find_zones(
    features: Sequence[Feature],
    frame: LocalFrame,
    path: Path,
    restrictions: Sequence[str] | None = RESTRICTIONS,
    time: float | None = None,
) -> Zones:
    """Return the zones; a closed line counts as a polygon.

    A zone that names a restriction needs one of `restrictions`, and must be active in the hour after `time` [s]. With
    None they are areas to stay inside.
    """
    window = MapWindow.of(frame)
    shapes, near = to_plane([feature.shape for feature in features], frame, window)
    window.expect_near(path)
    mistakes = Mistakes()
    notes = MapNotes(frame, path)
    zones = list[MapArea]()
    chosen = set(map(_respell, (*RESTRICTIONS, "NO_RESTRICTION") if restrictions is None else restrictions))
    is_excluded = False
    for feature, shape, is_near in zip(features, shapes, near, strict=True):
        why = _why_excluded(feature.tags, chosen, time) if is_near else None
        is_missing = (why is None or why is INACTIVE) and notes.add_missing(feature)
        if why is not None:
            notes.pass_over(feature, shape, why)
            is_excluded = True
            continue
        ends = dict[str, VerticalLimit | None]()
        if is_near:
            ends = limits_of(feature.tags, partial(notes.note, feature))
            _note_not_understood(feature, shape, notes)
            if restrictions is None:
                _note_limits_of_area(feature, ends, notes)
            ends = {side: _above_sea(side, limit, feature, notes) for side, limit in ends.items()}
        parts = [outline_of(part, feature.tags, restrictions is None) for part in simple_parts(shape)]
        open_parts = [part for part in parts if part.geom_type != "Polygon"]
        if open_parts or not (parts or is_missing):
            why = why_no_area(open_parts, feature.tags) if is_near else FAR_FROM_HOME
            notes.pass_over(feature, shapely.GeometryCollection(open_parts), why)
        for outline in parts:
            if outline.geom_type != "Polygon":
                continue
            mended = mistakes.attempt(polygons_of, outline, feature.place)
            if mended is None:
                continue
            polygons, defect = mended
            zones += [MapArea(feature.name, polygon, **ends) for polygon in polygons]
            if "limitedApplicability" in feature.tags and (time is None or periods_of(feature.tags) is None):
                notes.remarks.append(f"{feature.name}: active at times only, kept at all times")
            if defect:
                notes.remarks.append(f"{feature.name}: mended ({defect})")
    mistakes.raise_all()
    if not zones and not is_excluded:
        raise NothingThere(f"expected a polygon, but there is none among {len(features)} features", place=path)
    return Zones(tuple(zones), tuple(notes.passed_over), tuple(notes.remarks), gathered(notes.unread))


def _respell(restriction: str) -> str:
    return restriction.replace("AUTHORIZATION", "AUTHORISATION")


def _restrictions(tags: Mapping[str, str]) -> set[str]:
    """Read `restriction` (ED-269), `restrictio` (its shapefiles) or `type` (ED-318)."""
    values = {_respell(tags[key].strip().upper()) for key in ("restriction", "restrictio", "type") if key in tags}
    return values & {*RESTRICTIONS, "NO_RESTRICTION"}


def _why_excluded(tags: Mapping[str, str], chosen: set[str], time: float | None) -> Reason | None:
    restrictions = _restrictions(tags)
    if restrictions and not restrictions & chosen:
        return Reason(f"its restriction is {' and '.join(sorted(restrictions))}", False)
    is_inactive = "limitedApplicability" in tags and time is not None and not may_be_active(tags, time)
    return INACTIVE if is_inactive else None


def _note_limits_of_area(feature: Feature, ends: Mapping[str, VerticalLimit | None], notes: MapNotes) -> None:
    for side, limit in ends.items():
        if limit is not None:
            subject = f"{side} limit of a flight area (give it as `up` under [bounds])"
            notes.note(feature, subject, f"{limit.height:g} m {limit.reference}")


def _note_not_understood(feature: Feature, shape: Any, notes: MapNotes) -> None:
    tags = feature.tags
    if any(part.geom_type == "Point" for part in simple_parts(shape)):
        width_of(tags, lambda key, value: notes.note(feature, f"size of a point, {key}", value, may_limit=True))
    if "restriction" in tags and not _restrictions(tags):
        notes.note(feature, "restriction, taken as one that keeps a flight out", tags["restriction"])
    kind = tags.get("type", tags.get("Type", ""))
    if kind.lower() in ("inclusive", "inclusion"):
        notes.note(feature, "area to stay inside, taken as one that keeps a flight out", kind)
    if RADIUS_UNIT in tags:
        notes.note(feature, "unit of a radius, taken as m", tags[RADIUS_UNIT])


def _above_sea(side: str, limit: VerticalLimit | None, feature: Feature, notes: MapNotes) -> VerticalLimit | None:
    """Convert an ellipsoidal limit to mean sea level, safely if the geoid is unknown."""
    if limit is None or limit.reference != "WGS84":
        return limit
    stated = f"{limit.height:g} m WGS84"
    try:
        geoid, source = undulation(notes.frame.home.latitude_deg, notes.frame.home.longitude_deg, None, notes.path)
        notes.remarks.append(f"{feature.name}: {side} limit {stated} taken less {geoid:.2f} m of geoid ({source})")
    except BadInput:
        geoid = -107.0 if side == "upper" else 86.0  # extremes of EGM96 and EGM2008
        subject = f"geoid under the {side} limit, taken as {geoid:g} m above the ellipsoid, the worst"
        notes.note(feature, subject, stated)
    return VerticalLimit(limit.height - geoid, "AMSL")


def join_zones(zones: Sequence[MapArea]) -> tuple[Any, tuple[Any, ...]]:
    """Return the part nearest to home, and the others."""
    area = union_of([zone.shape for zone in zones])
    nearest, *others = sorted(shapely.get_parts(area), key=lambda part: float(part.distance(shapely.Point(0.0, 0.0))))
    return nearest, tuple(others)


def why_no_area(rest: Sequence[Any], tags: Mapping[str, str]) -> Reason:
    if not rest:
        return Reason("without a geometry", False)
    if all(part.geom_type == "Point" for part in rest):
        sizes = [
            key
            for key, value in tags.items()
            if re.search("buffer|range|distance", key.lower()) and length_of(value)[0]
        ]
        if not sizes:
            return Reason("a point", False)
        words = f"a point with a size that was not understood ({sizes[0]} {tags[sizes[0]][:20]!r})"
        return Reason(words, True, "name the property radius or diameter, in meters")
    remedy = "close the line in the map, so that it is the edge of a zone, or take it out"
    return Reason("a line that encloses no area", True, remedy)


def outline_of(shape: Any, tags: Mapping[str, str], is_area_to_stay_in: bool = False) -> Any:
    """Return a circle round a point with a width; its corners lie outside, except of an area to stay in."""
    width = width_of(tags, lambda *_: None) if shape.geom_type == "Point" else None
    if width is not None:
        wider = 1.0 if is_area_to_stay_in else math.cos(math.pi / 64)
        return shape.buffer(width / 2 / wider, quad_segs=16)
    return close_as_polygon(shape)
