"""KML 2.2 (OGC 07-147r2): way, items, fence and rally points.

`absolute` is above mean sea level; heights above terrain become `relativeToGround`.
"""

from collections.abc import Iterable
from xml.etree import ElementTree as Tree

from ipoa_mission.autopilot.commands import Frame, command_name, plain_frame
from ipoa_mission.forecast.forecast import Forecast
from ipoa_mission.mission.items import Item, Mission
from ipoa_mission.report.exports.export_lines import lines_of, ring

NAMESPACE = "http://www.opengis.net/kml/2.2"
STYLES = {"way": "ff00a5ff", "inclusion": "ff50af4c", "exclusion": "ff3643f4"}  # aabbggrr


def to_kml(forecast: Forecast, name: str) -> str:
    mission = forecast.given
    root = Tree.Element("kml", xmlns=NAMESPACE)
    document = Tree.SubElement(root, "Document")
    _text(document, "name", name)
    for style, color in STYLES.items():
        line = Tree.SubElement(Tree.SubElement(document, "Style", id=style), "LineStyle")
        _text(line, "color", color)
        _text(line, "width", "3")
    _way(document, forecast)
    items = _folder(document, "items")
    _point(items, "0 home", (mission.home.longitude_deg, mission.home.latitude_deg, mission.home.altitude), "absolute")
    for seq, item in enumerate(mission.items, start=1):
        if item.has_position:
            place, mode = _place(item, mission)
            _point(items, f"{seq} {command_name(item.command)}", place, mode)
    _areas(document, mission)
    if mission.rally:
        rally = _folder(document, "rally points")
        for n, point in enumerate(mission.rally, start=1):
            amsl = mission.home.altitude + point.altitude
            _point(rally, f"rally {n}", (point.longitude_deg, point.latitude_deg, amsl), "absolute")
    Tree.indent(root)
    return '<?xml version="1.0" encoding="UTF-8"?>\n' + Tree.tostring(root, encoding="unicode") + "\n"


def _way(document: Tree.Element, forecast: Forecast) -> None:
    folder = _folder(document, "way")
    for n, stretch in enumerate(lines_of(forecast), start=1):
        placemark = _placemark(folder, f"way {n}", "way")
        line = Tree.SubElement(placemark, "LineString")
        _text(line, "altitudeMode", "relativeToGround" if stretch.over_terrain else "absolute")
        _text(line, "coordinates", _coordinates(stretch.points))


def _areas(document: Tree.Element, mission: Mission) -> None:
    if not mission.fence:
        return
    folder = _folder(document, "fence")
    for n, part in enumerate(mission.fence, start=1):
        style = "inclusion" if part.inclusion else "exclusion"
        polygon = Tree.SubElement(_placemark(folder, f"fence {n} ({style})", style), "Polygon")
        boundary = Tree.SubElement(Tree.SubElement(polygon, "outerBoundaryIs"), "LinearRing")
        _text(boundary, "coordinates", _coordinates((lon, lat, 0.0) for lon, lat in ring(part)))


def _place(item: Item, mission: Mission) -> tuple[tuple[float, float, float], str]:
    if plain_frame(item.frame) == Frame.GLOBAL_TERRAIN_ALT:
        return (item.longitude_deg, item.latitude_deg, item.altitude), "relativeToGround"
    amsl = mission.home.altitude + mission.altitude_above_home(item)
    return (item.longitude_deg, item.latitude_deg, amsl), "absolute"


def _folder(parent: Tree.Element, name: str) -> Tree.Element:
    folder = Tree.SubElement(parent, "Folder")
    _text(folder, "name", name)
    return folder


def _placemark(parent: Tree.Element, name: str, style: str | None = None) -> Tree.Element:
    placemark = Tree.SubElement(parent, "Placemark")
    _text(placemark, "name", name)
    if style:
        _text(placemark, "styleUrl", f"#{style}")
    return placemark


def _point(parent: Tree.Element, name: str, place: tuple[float, float, float], mode: str) -> None:
    point = Tree.SubElement(_placemark(parent, name), "Point")
    _text(point, "altitudeMode", mode)
    _text(point, "coordinates", _coordinates([place]))


def _coordinates(places: Iterable[tuple[float, float, float]]) -> str:
    return " ".join(f"{lon:.9f},{lat:.9f},{alt:.3f}" for lon, lat, alt in places)


def _text(parent: Tree.Element, tag: str, text: str) -> None:
    Tree.SubElement(parent, tag).text = text
