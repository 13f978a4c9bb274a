"""KML 2.2 (OGC 07-147r2) and GPX 1.1: path, items, rally points, home; KML also has the fence.

`absolute` and `ele` are above mean sea level; a height above terrain is `relativeToGround`, GPX has none.
"""

import math
from collections.abc import Iterable
from xml.etree import ElementTree as Tree

from ipoa_mission.autopilot.commands import Frame, command_name, plain_frame
from ipoa_mission.forecast.forecast import Forecast
from ipoa_mission.mission.items import Mission
from ipoa_mission.report.exports.export_lines import Place, lines_of, marks_of, ring


def to_kml(forecast: Forecast, name: str) -> str:
    mission = forecast.given
    root = Tree.Element("kml", xmlns="http://www.opengis.net/kml/2.2")
    document = _element(root, "Document")
    _element(document, "name", name)
    for style, aabbggrr in (("way", "ff00a5ff"), ("inclusion", "ff50af4c"), ("exclusion", "ff3643f4")):
        line = _element(_element(document, "Style", id=style), "LineStyle")
        _element(line, "color", aabbggrr)
        _element(line, "width", "3")
    folder = _folder(document, "way")
    for n, stretch in enumerate(lines_of(forecast), start=1):
        line = _element(_placemark(folder, f"way {n}", "way"), "LineString")
        _element(line, "altitudeMode", "relativeToGround" if stretch.over_terrain else "absolute")
        _element(line, "coordinates", _coordinates(stretch.points))
    (_, home), *rally = marks_of(mission)
    items = _folder(document, "items")
    _kml_point(items, "0 home", home)
    for seq, item in enumerate(mission.items, start=1):
        if item.has_position:
            over_terrain = plain_frame(item.frame) == Frame.GLOBAL_TERRAIN_ALT
            amsl = mission.home.altitude + mission.altitude_above_home(item)
            place = item.longitude_deg, item.latitude_deg, item.altitude if over_terrain else amsl
            _kml_point(items, f"{seq} {command_name(item.command)}", place, over_terrain)
    _kml_fence(document, mission)
    if rally:
        folder = _folder(document, "rally points")
        for name, place in rally:
            _kml_point(folder, name, place)
    return _text_of(root)


def _kml_fence(document: Tree.Element, mission: Mission) -> None:
    if not mission.fence:
        return
    folder = _folder(document, "fence")
    for n, part in enumerate(mission.fence, start=1):
        style = "inclusion" if part.inclusion else "exclusion"
        polygon = _element(_placemark(folder, f"fence {n} ({style})", style), "Polygon")
        boundary = _element(_element(polygon, "outerBoundaryIs"), "LinearRing")
        _element(boundary, "coordinates", _coordinates((lon, lat, 0.0) for lon, lat in ring(part)))


def _kml_point(parent: Tree.Element, name: str, place: Place, over_terrain: bool = False) -> None:
    point = _element(_placemark(parent, name), "Point")
    _element(point, "altitudeMode", "relativeToGround" if over_terrain else "absolute")
    _element(point, "coordinates", _coordinates([place]))


def _folder(parent: Tree.Element, name: str) -> Tree.Element:
    folder = _element(parent, "Folder")
    _element(folder, "name", name)
    return folder


def _placemark(parent: Tree.Element, name: str, style: str | None = None) -> Tree.Element:
    placemark = _element(parent, "Placemark")
    _element(placemark, "name", name)
    if style:
        _element(placemark, "styleUrl", f"#{style}")
    return placemark


def _coordinates(places: Iterable[Place]) -> str:
    return " ".join(f"{lon:.9f},{lat:.9f},{alt:.3f}" for lon, lat, alt in places)


def to_gpx(forecast: Forecast, name: str) -> str:
    mission = forecast.given
    root = Tree.Element("gpx", xmlns="http://www.topografix.com/GPX/1/1", version="1.1", creator="ipoa-mission")
    _element(_element(root, "metadata"), "name", name)
    for label, place in marks_of(mission):
        _gpx_point(root, "wpt", place, label)
    route = _element(root, "rte")
    _element(route, "name", name)
    for seq, item in enumerate(mission.items, start=1):
        if item.has_position:
            place = item.longitude_deg, item.latitude_deg, mission.home.altitude + mission.altitude_above_home(item)
            _gpx_point(route, "rtept", place, f"{seq} {command_name(item.command)}")
    track = _element(root, "trk")
    _element(track, "name", f"{name}: way")
    for stretch in lines_of(forecast):
        segment = _element(track, "trkseg")
        for longitude, latitude, amsl in stretch.points:
            _gpx_point(segment, "trkpt", (longitude, latitude, math.nan if stretch.over_terrain else amsl))
    return _text_of(root)


def _gpx_point(parent: Tree.Element, tag: str, place: Place, name: str = "") -> None:
    longitude, latitude, amsl = place
    point = _element(parent, tag, lat=f"{latitude:.9f}", lon=f"{longitude:.9f}")
    if math.isfinite(amsl):
        _element(point, "ele", f"{amsl:.3f}")
    if name:
        _element(point, "name", name)


def _element(parent: Tree.Element, tag: str, text: str | None = None, **attributes: str) -> Tree.Element:
    element = Tree.SubElement(parent, tag, attributes)
    element.text = text
    return element


def _text_of(root: Tree.Element) -> str:
    Tree.indent(root)
    return '<?xml version="1.0" encoding="UTF-8"?>\n' + Tree.tostring(root, encoding="unicode") + "\n"
