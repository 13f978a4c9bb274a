"""Write a mission as CSV, GeoJSON (RFC 7946), KML 2.2 (OGC 07-147r2) and GPX 1.1; not in GPX the fence.

Altitudes are above mean sea level, in GeoJSON too (`altitude_datum`); the RFC's are above the ellipsoid. A height above
terrain is KML's `relativeToGround`; GeoJSON has it in properties only, GPX not at all.
"""

import json
import math
import re
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias
from xml.etree import ElementTree as Tree

import numpy as np
import shapely

from ipoa_mission.autopilot.commands import Frame, plain_frame
from ipoa_mission.errors import WrongSuffix
from ipoa_mission.files import write_atomically
from ipoa_mission.forecast.forecast import Forecast
from ipoa_mission.forecast.itinerary.flown_legs import Leg
from ipoa_mission.geodesy import Geodetic, LocalFrame
from ipoa_mission.mission.items import FenceCircle, FencePolygon, Item, Mission
from ipoa_mission.mission.positions import refuse_unsound
from ipoa_mission.mission.stored_mission import refuse_infinite
from ipoa_mission.report.table import to_csv

if TYPE_CHECKING:
    from ipoa_mission.scenario import Scenario

LonLatUp: TypeAlias = tuple[float, float, float]
"""Longitude [deg], latitude [deg], altitude [m]."""
Ring: TypeAlias = list[tuple[float, float]]
"""Longitude and latitude [deg], closed, counterclockwise."""
NOT_XML = re.compile("[^\t\n\r\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")  # by XML 1.0


@dataclass(frozen=True)
class Stretch:
    """Points that do not cross the antimeridian; AMSL, or above the ground if `over_terrain`."""

    points: tuple[LonLatUp, ...]
    over_terrain: bool


def marks_of(mission: Mission) -> Iterator[tuple[str, LonLatUp]]:
    """Yield home and the rally points with their names, AMSL."""
    home = mission.home
    yield "home", (home.longitude_deg, home.latitude_deg, home.altitude)
    for n, place in enumerate(mission.rally, start=1):
        yield f"rally {n}", (place.longitude_deg, place.latitude_deg, home.altitude + place.altitude)


def lines_of(forecast: Forecast) -> tuple[Stretch, ...]:
    """Return the flown lines, with the way from home and back down to the scenario's ground."""
    is_unknown = forecast.scenario is None and forecast.ground.is_flat
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
    over_terrain = leg.over_terrain and unknown_ground is not None
    latitude, longitude, altitude = (values.tolist() for values in frame.to_geodetic(leg.points))
    ground = (unknown_ground or 0.0) if over_terrain else 0.0
    places = [
        (round(lon, 9), round(lat, 9), round(alt - ground, 3))
        for lat, lon, alt in zip(latitude, longitude, altitude, strict=True)
    ]
    yield from (Stretch(tuple(line), over_terrain) for line in _cut_at_antimeridian(places))


def _cut_at_antimeridian(places: list[LonLatUp]) -> list[list[LonLatUp]]:
    """RFC 7946, 3.1.9."""
    lines = [[places[0]]]
    for place in places[1:]:
        before = lines[-1][-1]
        if abs(place[0] - before[0]) > 180:
            side = float(np.sign(before[0])) * 180.0
            eastward = place[0] + 2 * side - before[0]
            share = (side - before[0]) / eastward if eastward else 0.0  # from 180 to -180: one place
            latitude, altitude = (round(a + share * (b - a), 9) for a, b in zip(before[1:], place[1:], strict=True))
            lines[-1].append((side, latitude, altitude))
            lines.append([(-side, latitude, altitude)])
        lines[-1].append(place)
    return lines


def fence_rings(part: FencePolygon | FenceCircle) -> list[Ring]:
    """Return rings, cut at longitude 180 (RFC 7946, 3.1.9); a circle's 72 corners cut off at most 0.1 % of it."""
    if isinstance(part, FenceCircle):
        angles = np.linspace(0.0, 2.0 * np.pi, 72, endpoint=False)
        circle = part.radius * np.column_stack([np.cos(angles), np.sin(angles), np.zeros(len(angles))])
        latitude, longitude, _ = LocalFrame(Geodetic(*part.center)).to_geodetic(circle)
        corners = [(round(float(lon), 9), round(float(lat), 9)) for lat, lon in zip(latitude, longitude, strict=True)]
    else:
        corners = [(lon, lat) for lat, lon in part.vertices]
    eastward = np.unwrap([lon for lon, _ in corners], period=360.0).tolist()
    closed = [(lon, lat) for lon, (_, lat) in zip(eastward, corners, strict=True)]
    closed.append(closed[0])
    doubled_area = sum(a[0] * b[1] - b[0] * a[1] for a, b in pairwise(closed))
    ring = closed if doubled_area >= 0 else closed[::-1]
    return [ring] if max(map(abs, eastward)) <= 180.0 else list(_cut_ring(ring))


def _cut_ring(ring: Ring) -> Iterator[Ring]:
    outline = shapely.make_valid(shapely.Polygon(ring))
    for turn in (-360.0, 0.0, 360.0):
        cut = shapely.intersection(outline, shapely.box(turn - 180.0, -90.0, turn + 180.0, 90.0))
        for part in shapely.get_parts(cut):
            if part.geom_type == "Polygon" and not part.is_empty:
                border = shapely.orient_polygons(part).exterior.coords
                yield [(round(lon - turn, 9), round(lat, 9)) for lon, lat in border]


def _placed_items(mission: Mission) -> Iterator[tuple[int, Item, LonLatUp]]:
    """The altitude is NaN above terrain."""
    for seq, item in enumerate(mission.items, start=1):
        if item.has_position:
            amsl = mission.home.altitude + mission.altitude_above_home(item)
            yield seq, item, (item.longitude_deg, item.latitude_deg, amsl)


def to_geojson(forecast: Forecast, name: str) -> str:
    mission = forecast.mission_as_read
    (_, home), *rally = marks_of(mission)
    features = [_feature("Point", home, {"kind": "home", "seq": 0})]
    for stretch in lines_of(forecast):
        points = [point[:2] if stretch.over_terrain else point for point in stretch.points]
        features.append(_feature("LineString", points, {"kind": "way", "over_terrain": stretch.over_terrain}))
    for seq, item, (longitude, latitude, amsl) in _placed_items(mission):
        about = {
            "kind": "item",
            "seq": seq,
            "command": item.name,
            "frame": int(item.frame),
            "altitude": item.altitude,
            "params": [None if math.isnan(param) else param for param in item.params],
        }
        height = [round(amsl, 3)] if math.isfinite(amsl) else []
        features.append(_feature("Point", [longitude, latitude, *height], about))
    for part in mission.fence:
        polygons: list[Any] = [[ring] for ring in fence_rings(part)]
        kind = "Polygon" if len(polygons) == 1 else "MultiPolygon"
        coordinates = polygons[0] if kind == "Polygon" else polygons
        features.append(_feature(kind, coordinates, {"kind": "fence", "inclusion": part.inclusion}))
    for n, (_, (longitude, latitude, amsl)) in enumerate(rally, start=1):
        features.append(_feature("Point", [longitude, latitude, round(amsl, 3)], {"kind": "rally", "seq": n}))
    about_all = {"type": "FeatureCollection", "name": name, "altitude_datum": "mean sea level"}
    return json.dumps({**about_all, "features": features}, allow_nan=False) + "\n"


def _feature(kind: str, coordinates: Sequence[Any], properties: dict[str, Any]) -> dict[str, Any]:
    return {"type": "Feature", "properties": properties, "geometry": {"type": kind, "coordinates": coordinates}}


def to_kml(forecast: Forecast, name: str) -> str:
    mission = forecast.mission_as_read
    colors = {"way": "ff00a5ff", "inclusion": "ff50af4c", "exclusion": "ff3643f4"}  # alpha, blue, green, red
    styles = [
        _node("Style", _node("LineStyle", _node("color", color), _node("width", "3")), id=style)
        for style, color in colors.items()
    ]
    stretches = [
        _placemark(f"way {n}", _shape("LineString", stretch.points, stretch.over_terrain), "way")
        for n, stretch in enumerate(lines_of(forecast), start=1)
    ]
    (_, home), *rally = marks_of(mission)
    items = [_placemark("0 home", _shape("Point", [home]))]
    for seq, item, (longitude, latitude, amsl) in _placed_items(mission):
        over_terrain = plain_frame(item.frame) == Frame.GLOBAL_TERRAIN_ALT
        place = longitude, latitude, item.altitude if over_terrain else amsl
        items.append(_placemark(f"{seq} {item.name}", _shape("Point", [place], over_terrain)))
    fence = []
    for n, part in enumerate(mission.fence, start=1):
        style = "inclusion" if part.inclusion else "exclusion"
        borders = [_node("LinearRing", _coordinates((*corner, 0.0) for corner in ring)) for ring in fence_rings(part)]
        polygons = [_node("Polygon", _node("outerBoundaryIs", border)) for border in borders]
        shape = polygons[0] if len(polygons) == 1 else _node("MultiGeometry", *polygons)
        fence.append(_placemark(f"fence {n} ({style})", shape, style))
    rally_points = [_placemark(label, _shape("Point", [place])) for label, place in rally]
    marks = {"way": stretches, "items": items, "fence": fence, "rally points": rally_points}
    folders = [_node("Folder", _node("name", label), *marked) for label, marked in marks.items() if marked]
    document = _node("Document", _node("name", name), *styles, *folders)
    return _text_of(_node("kml", document, xmlns="http://www.opengis.net/kml/2.2"))


def _placemark(name: str, shape: Tree.Element, style: str | None = None) -> Tree.Element:
    styled = [_node("styleUrl", f"#{style}")] if style else []
    return _node("Placemark", _node("name", name), *styled, shape)


def _shape(tag: str, places: Iterable[LonLatUp], over_terrain: bool = False) -> Tree.Element:
    return _node(tag, _node("altitudeMode", "relativeToGround" if over_terrain else "absolute"), _coordinates(places))


def _coordinates(places: Iterable[LonLatUp]) -> Tree.Element:
    return _node("coordinates", " ".join(f"{lon:.9f},{lat:.9f},{alt:.3f}" for lon, lat, alt in places))


def to_gpx(forecast: Forecast, name: str) -> str:
    mission = forecast.mission_as_read
    marks = [_gpx_point("wpt", place, label) for label, place in marks_of(mission)]
    route = [_gpx_point("rtept", place, f"{seq} {item.name}") for seq, item, place in _placed_items(mission)]
    segments = []
    for stretch in lines_of(forecast):
        points = [(lon, lat, math.nan if stretch.over_terrain else amsl) for lon, lat, amsl in stretch.points]
        segments.append(_node("trkseg", *(_gpx_point("trkpt", point) for point in points)))
    parts = _node("metadata", _node("name", name)), *marks, _node("rte", _node("name", name), *route)
    track = _node("trk", _node("name", f"{name}: way"), *segments)
    about = {"xmlns": "http://www.topografix.com/GPX/1/1", "version": "1.1", "creator": "ipoa-mission"}
    return _text_of(_node("gpx", *parts, track, **about))


def _gpx_point(tag: str, place: LonLatUp, name: str = "") -> Tree.Element:
    longitude, latitude, amsl = place
    height = [_node("ele", f"{amsl:.3f}")] if math.isfinite(amsl) else []
    named = [_node("name", name)] if name else []
    east = min(longitude, 180.0 - 1e-9)  # the schema's longitudes end before 180
    return _node(tag, *height, *named, lat=f"{latitude:.9f}", lon=f"{east:.9f}")


def _node(tag: str, *content: Tree.Element | str, **attributes: str) -> Tree.Element:
    node = Tree.Element(tag, attributes)
    for part in content:
        if isinstance(part, str):
            node.text = NOT_XML.sub("\N{REPLACEMENT CHARACTER}", part)
        else:
            node.append(part)
    return node


def _text_of(root: Tree.Element) -> str:
    Tree.indent(root)
    return '<?xml version="1.0" encoding="UTF-8"?>\n' + Tree.tostring(root, encoding="unicode") + "\n"


Export: TypeAlias = Callable[[Forecast, str], str]
EXPORTS: dict[str, Export] = {".kml": to_kml, ".geojson": to_geojson, ".csv": to_csv, ".gpx": to_gpx}


def write_export(mission: Mission, path: str | Path, scenario: "Scenario | None" = None) -> None:
    """Write the mission in the format of the suffix; the same mission gives the same bytes.

    Args:
        mission: to write.
        path: ends in a suffix of `EXPORTS`, like `.kml`.
        scenario: gives heights above its ground; a landing goes down to it.

    Raises:
        BadInput: no such format, a position or height that cannot be drawn, or the file cannot be written.

    Example:
        >>> from ipoa_mission import read_mission, write_export
        >>> write_export(read_mission("missions/sitl.plan"), "sitl.kml")
    """
    path = Path(path)
    if path.suffix.lower() not in EXPORTS:
        raise WrongSuffix(f'expected a name that ends in {", ".join(EXPORTS)}, not in "{path.suffix}"', place=path)
    write_atomically(path, forecast_text(Forecast(mission, scenario), path.suffix.lower(), path.stem))


def forecast_text(forecast: Forecast, suffix: str, name: str) -> str:
    """Raise BadInput for an undrawable position or height."""
    refuse_unsound(forecast.mission_as_read)
    refuse_infinite(forecast.mission_as_read.items)
    return EXPORTS[suffix](forecast, name)
