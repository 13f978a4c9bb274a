"""A scenario round a foreign map or elevation model, so that it is read as `plan` reads it."""

import json
from pathlib import Path

import shapely

from ipoa_mission.errors import BadInput
from ipoa_mission.maps.elevation import ground_altitude
from ipoa_mission.maps.raster import open_raster
from ipoa_mission.maps.read import read_features
from ipoa_mission.scenario.read import parse_scenario

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
    home = shapely.Point(max(west - WEST, -180.0), (south + north) / 2)
    if kind == "flight_area":
        areas = [shapely.convex_hull(shape) for shape in shapes]
        home = max(areas, key=lambda area: float(area.area)).representative_point()
    text = SCENARIO.format(latitude=float(home.y), longitude=float(home.x), altitude=0.0, margin=500)
    text += f'[[maps]]\nkind = "{kind}"\nfile = {_quoted(path)}\n'
    _tell(text, path)


def read_elevation(path: Path) -> None:
    """Read an elevation model as the terrain of a scenario in its middle, and print its remarks.

    Raises:
        MissionError: as a scenario that names it.
    """
    with open_raster(path, None) as raster:
        middle = raster.dataset.width // 2, raster.dataset.height // 2
        latitude, longitude = (float(each) for each in raster.places(*middle))  # type: ignore[arg-type]
    altitude = ground_altitude(path, latitude, longitude)
    text = SCENARIO.format(latitude=latitude, longitude=longitude, altitude=altitude, margin=20)
    _tell(f'{text}[terrain]\nkind = "elevation"\nfile = {_quoted(path)}\n', path)


def _tell(text: str, path: Path) -> None:
    for remark in parse_scenario(text, path.parent / "scenario.toml").remarks:
        print(f"note: {remark}")


def _quoted(path: Path) -> str:
    return json.dumps(str(path.resolve()), ensure_ascii=False)
