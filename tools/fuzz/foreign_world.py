"""A scenario round a foreign map or elevation model, so that it is read as `plan` reads it."""

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import shapely

from ipoa_mission.errors import BadInput
from ipoa_mission.maps.elevation import ground_altitude
from ipoa_mission.maps.map_reader import read_features
from ipoa_mission.maps.raster import open_raster
from ipoa_mission.scenario.scenario_file import parse_scenario

WEST = 0.002  # home lies so far west of a map, outside of all its zones [deg]
SCENARIO = """
home = {{ latitude_deg = {latitude!r}, longitude_deg = {longitude!r}, altitude_amsl = {altitude!r} }}
start = {{ east = 0.0, north = 0.0, height_above_ground = 15.0 }}
goal = {{ east = 5.0, north = 0.0, height_above_ground = 15.0 }}
bounds = {{ margin = {margin} }}
vehicle = {{ radius = 0.5, cruise_speed = 5.0 }}
"""


def read_map(path: Path, kind: str) -> None:
    """Read a map as `buildings`, `no_fly` or `flight_area` of a scenario, and print its remarks.

    Raises:
        MissionError: as a scenario that names it.
    """
    shapes = [feature.shape for feature in read_features(path)]
    west, south, east, north = shapely.total_bounds(shapes)
    if not west <= east:
        raise BadInput(f"{path}: expected shapes, but there are none among {len(shapes)} features")
    home = shapely.Point((west + east) / 2, (south + north) / 2)
    if kind == "no_fly":
        home = shapely.Point(max(west - WEST, -180.0), home.y)
    elif kind == "flight_area":
        closed = shapely.get_parts(shapely.polygonize([shapely.node(shape.boundary) for shape in _areas(shapes)]))
        home = max(closed, key=lambda area: float(area.area), default=home).representative_point()
    text = SCENARIO.format(latitude=float(home.y), longitude=float(home.x), altitude=0.0, margin=500)
    text += f'[[maps]]\nkind = "{kind}"\nfile = {_quoted(path)}\n'
    _tell(text, path)


def _areas(shapes: Sequence[Any]) -> list[Any]:
    """The polygons among some shapes, closed lines among them."""
    parts = [part for shape in shapes for part in shapely.get_parts(shapely.get_parts(shape))]
    closed = [part for part in parts if part.geom_type == "LineString" and part.is_closed]
    return [part for part in parts if part.geom_type == "Polygon"] + [shapely.Polygon(line) for line in closed]


def read_elevation(path: Path) -> None:
    """Read an elevation model as the terrain of a scenario in its middle, and print its remarks.

    Raises:
        MissionError: as a scenario that names it.
    """
    with open_raster(path, None) as raster:
        middle = (np.array([size // 2]) for size in (raster.dataset.width, raster.dataset.height))
        latitude, longitude = (float(each[0]) for each in raster.places(*middle))
    altitude = ground_altitude(path, latitude, longitude)
    text = SCENARIO.format(latitude=latitude, longitude=longitude, altitude=altitude, margin=20)
    _tell(f'{text}[terrain]\nkind = "elevation"\nfile = {_quoted(path)}\n', path)


def _tell(text: str, path: Path) -> None:
    for remark in parse_scenario(text, path.parent / "scenario.toml").remarks:
        print(f"note: {remark}")


def _quoted(path: Path) -> str:
    return json.dumps(str(path.resolve()), ensure_ascii=False)
