"""GPX 1.1: a route, a track, home and rally points.

`ele` is above sea level; a height above terrain has none.
"""

import math
from xml.etree import ElementTree as Tree

from ipoa_mission.autopilot.commands import command_name
from ipoa_mission.forecast.forecast import Forecast
from ipoa_mission.report.exports.export_lines import lines_of

NAMESPACE = "http://www.topografix.com/GPX/1/1"


def to_gpx(forecast: Forecast, name: str) -> str:
    root = Tree.Element("gpx", xmlns=NAMESPACE, version="1.1", creator="ipoa-mission")
    Tree.SubElement(Tree.SubElement(root, "metadata"), "name").text = name
    mission = forecast.given
    home = mission.home
    _place(root, "wpt", home.latitude_deg, home.longitude_deg, home.altitude, "home")
    for n, place in enumerate(mission.rally, start=1):
        _place(root, "wpt", place.latitude_deg, place.longitude_deg, home.altitude + place.altitude, f"rally {n}")
    route = Tree.SubElement(root, "rte")
    Tree.SubElement(route, "name").text = name
    for seq, item in enumerate(mission.items, start=1):
        if item.has_position:
            amsl = home.altitude + mission.altitude_above_home(item)
            _place(route, "rtept", item.latitude_deg, item.longitude_deg, amsl, f"{seq} {command_name(item.command)}")
    track = Tree.SubElement(root, "trk")
    Tree.SubElement(track, "name").text = f"{name}: way"
    for stretch in lines_of(forecast):
        segment = Tree.SubElement(track, "trkseg")
        for longitude_deg, latitude_deg, amsl in stretch.points:
            _place(segment, "trkpt", latitude_deg, longitude_deg, math.nan if stretch.over_terrain else amsl)
    Tree.indent(root)
    return '<?xml version="1.0" encoding="UTF-8"?>\n' + Tree.tostring(root, encoding="unicode") + "\n"


def _place(parent: Tree.Element, tag: str, latitude: float, longitude: float, amsl: float, name: str = "") -> None:
    place = Tree.SubElement(parent, tag, lat=f"{latitude:.9f}", lon=f"{longitude:.9f}")
    if math.isfinite(amsl):
        Tree.SubElement(place, "ele").text = f"{amsl:.3f}"
    if name:
        Tree.SubElement(place, "name").text = name
