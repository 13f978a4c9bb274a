"""GeoJSON (RFC 7946): path, items, rally points and fence.

The third coordinate is above mean sea level (`altitude_datum`); the RFC's is above the ellipsoid. Heights above terrain
are in the properties only.
"""

import json
import math
from typing import Any

from ipoa_mission.autopilot.commands import command_name
from ipoa_mission.forecast.forecast import Forecast
from ipoa_mission.mission.items import Item, Mission
from ipoa_mission.report.exports.export_lines import lines_of, marks_of, ring


def to_geojson(forecast: Forecast, name: str) -> str:
    """Write one feature a line."""
    mission = forecast.given
    (_, home), *rally = marks_of(mission)
    features = [_point(home, {"kind": "home", "seq": 0})]
    for stretch in lines_of(forecast):
        points = [point[:2] if stretch.over_terrain else point for point in stretch.points]
        line = {"type": "LineString", "coordinates": points}
        features.append(_feature(line, {"kind": "way", "over_terrain": stretch.over_terrain}))
    features += [_item(seq, item, mission) for seq, item in enumerate(mission.items, start=1) if item.has_position]
    for part in mission.fence:
        polygon = {"type": "Polygon", "coordinates": [ring(part)]}
        features.append(_feature(polygon, {"kind": "fence", "inclusion": part.inclusion}))
    for n, (_, (longitude, latitude, amsl)) in enumerate(rally, start=1):
        features.append(_point((longitude, latitude, round(amsl, 3)), {"kind": "rally", "seq": n}))
    lines = ",\n".join(json.dumps(feature, allow_nan=False) for feature in features)
    head = json.dumps({"type": "FeatureCollection", "name": name, "altitude_datum": "mean sea level"})
    return f'{head[:-1]}, "features": [\n{lines}\n]}}\n'


def _item(seq: int, item: Item, mission: Mission) -> dict[str, Any]:
    height = mission.altitude_above_home(item)
    place: tuple[float, ...] = (item.longitude_deg, item.latitude_deg)
    if math.isfinite(height):
        place = (*place, round(mission.home.altitude + height, 3))
    properties = {
        "kind": "item",
        "seq": seq,
        "command": command_name(item.command),
        "frame": int(item.frame),
        "altitude": item.altitude,
        "params": [param if math.isfinite(param) else None for param in item.params],
    }
    return _point(place, properties)


def _point(place: tuple[float, ...], properties: dict[str, Any]) -> dict[str, Any]:
    return _feature({"type": "Point", "coordinates": place}, properties)


def _feature(geometry: dict[str, Any], properties: dict[str, Any]) -> dict[str, Any]:
    return {"type": "Feature", "properties": properties, "geometry": geometry}
