import csv
import io
from dataclasses import replace
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
import shapely
from pyproj import Geod

from ipoa_mission.autopilot.autopilot import Autopilot
from ipoa_mission.forecast.forecast import Forecast
from ipoa_mission.geodesy import Geodetic
from ipoa_mission.mission.items import (
    FenceCircle,
    FencePolygon,
    Item,
    Mission,
    change_speed,
    land,
    return_to_launch,
    takeoff,
    waypoint,
)
from ipoa_mission.report.exports import EXPORTS, forecast_text, lines_of, write_export
from ipoa_mission.report.table import mission_table
from ipoa_mission.scenario import parse_scenario
from tests.refused import refuses

fastkml = pytest.importorskip("fastkml")
geojson = pytest.importorskip("geojson")
gpxpy = pytest.importorskip("gpxpy")

EARTH = Geod(ellps="WGS84")
HOME = Geodetic(39.101, 121.82, 20.5)
A, B = Geodetic(39.1023, 121.8212), Geodetic(39.1031, 121.8205)
MISSION = Mission(
    HOME,
    (takeoff(HOME, 40.0), change_speed(8.0), waypoint(A, 45.0, hold_s=3.0), waypoint(B, 30.0), return_to_launch()),
    Autopilot.ARDUPILOT,
    8.0,
    (
        FencePolygon(((39.10, 121.81), (39.11, 121.81), (39.11, 121.83), (39.10, 121.83))),
        FenceCircle((39.1025, 121.8200), 40.0, inclusion=False),
    ),
    (Geodetic(39.1015, 121.8195, 30.0),),
)
TERRAIN = replace(MISSION, items=(*MISSION.items[:3], replace(MISSION.items[3], frame=10), MISSION.items[4]))


def exported(mission: Mission, suffix: str, folder: Path) -> str:
    path = folder / f"flight{suffix}"
    write_export(mission, path)
    return path.read_text()


@pytest.mark.parametrize("suffix", EXPORTS)
def test_the_same_mission_gives_the_same_bytes(suffix: str, tmp_path: Path) -> None:
    assert exported(MISSION, suffix, tmp_path) == exported(MISSION, suffix, tmp_path)
    assert "\r" not in exported(MISSION, suffix, tmp_path)


@pytest.mark.parametrize("suffix", EXPORTS)
def test_a_mission_without_items_is_no_obstacle(suffix: str, tmp_path: Path) -> None:
    assert exported(Mission(HOME, ()), suffix, tmp_path)


@pytest.mark.parametrize("suffix", EXPORTS)
def test_infinite_param_is_not_exported(suffix: str, tmp_path: Path) -> None:
    mission = replace(MISSION, items=(MISSION.items[0], change_speed(np.inf)))
    with refuses("bad-input", "item 2 (DO_CHANGE_SPEED): param2"):
        write_export(mission, tmp_path / f"flight{suffix}")


@pytest.mark.parametrize("suffix", EXPORTS)
def test_a_fence_of_two_vertices_is_not_exported(suffix: str, tmp_path: Path) -> None:
    line = FencePolygon(((39.10, 121.81), (39.11, 121.81)))
    with refuses("fence-shape", "fence[0]"):
        write_export(replace(MISSION, fence=(line,)), tmp_path / f"flight{suffix}")


def test_speed_of_nan_is_an_empty_cell(tmp_path: Path) -> None:
    mission = replace(MISSION, items=(MISSION.items[0], change_speed(np.nan)))
    assert "nan" not in exported(mission, ".csv", tmp_path)


def test_another_suffix_is_refused(tmp_path: Path) -> None:
    with refuses("wrong-suffix", "flight.dji", '".dji"'):
        write_export(MISSION, tmp_path / "flight.dji")


def test_a_kml_file_reads_as_lines_and_points_at_amsl(tmp_path: Path) -> None:
    document = fastkml.KML.from_string(exported(MISSION, ".kml", tmp_path).split("\n", 1)[1]).features[0]
    assert document.name == "flight"
    path, items, fence, rally = document.features
    (line,) = path.features
    assert line.kml_geometry.altitude_mode.value == "absolute"
    coordinates = np.array(line.geometry.coords)
    assert coordinates[0] == pytest.approx([HOME.longitude_deg, HOME.latitude_deg, 20.5])
    assert coordinates[:, 2].max() == pytest.approx(65.5, abs=0.01)
    (place,) = MISSION.rally  # RTL goes to it
    assert coordinates[-1] == pytest.approx([place.longitude_deg, place.latitude_deg, 20.5], abs=1e-6)
    assert [point.name for point in items.features] == ["0 home", "1 NAV_TAKEOFF", "3 NAV_WAYPOINT", "4 NAV_WAYPOINT"]
    assert [point.geometry.z for point in items.features] == [20.5, 60.5, 65.5, 50.5]
    assert {point.kml_geometry.altitude_mode.value for point in items.features} == {"absolute"}
    assert rally.features[0].geometry.z == 50.5
    assert [area.name for area in fence.features] == ["fence 1 (inclusion)", "fence 2 (exclusion)"]
    area, _ = EARTH.geometry_area_perimeter(shapely.geometry.shape(fence.features[1].geometry))
    assert area == pytest.approx(np.pi * 40.0**2, rel=0.002)


def test_heights_above_terrain_are_relative_to_the_ground_in_kml(tmp_path: Path) -> None:
    document = fastkml.KML.from_string(exported(TERRAIN, ".kml", tmp_path).split("\n", 1)[1]).features[0]
    path, items = document.features[:2]
    assert [line.kml_geometry.altitude_mode.value for line in path.features] == [
        "absolute",
        "relativeToGround",
        "absolute",
    ]
    over_ground = items.features[3]
    assert over_ground.kml_geometry.altitude_mode.value == "relativeToGround"
    assert over_ground.geometry.z == 30.0
    assert np.array(path.features[1].geometry.coords)[-1, 2] == pytest.approx(30.0, abs=0.01)


def test_a_geojson_file_is_valid_and_holds_everything(tmp_path: Path) -> None:
    collection = geojson.loads(exported(MISSION, ".geojson", tmp_path))
    assert collection.is_valid, collection.errors()
    kinds = [feature["properties"]["kind"] for feature in collection["features"]]
    assert kinds == ["home", "way", "item", "item", "item", "fence", "fence", "rally"]
    third = collection["features"][3]
    assert third["properties"] == {
        "kind": "item",
        "seq": 3,
        "command": "NAV_WAYPOINT",
        "frame": 3,
        "altitude": 45.0,
        "params": [3.0, 0.0, 0.0, None],
    }
    assert third["geometry"]["coordinates"] == [121.8212, 39.1023, 65.5]
    for feature in collection["features"]:
        if feature["geometry"]["type"] == "Polygon":
            ring = np.array(feature["geometry"]["coordinates"][0])
            doubled = np.sum(ring[:-1, 0] * ring[1:, 1] - ring[1:, 0] * ring[:-1, 1])
            assert doubled > 0, "RFC 7946 wants outer rings counterclockwise"
            assert (ring[0] == ring[-1]).all()


def test_a_line_may_go_from_180_to_minus_180() -> None:
    home, there = Geodetic(-17.0, 180.0 - 1e-10, 5.0), Geodetic(-17.0, 1e-10 - 180.0, 5.0)
    mission = Mission(home, (takeoff(home, 20.0), waypoint(there, 40.0), land(there)))
    points = [point for stretch in lines_of(Forecast(mission)) for point in stretch.points]
    assert {abs(longitude) for longitude, _, _ in points} == {180.0}


def test_no_line_crosses_the_antimeridian(tmp_path: Path) -> None:
    home, there = Geodetic(-17.0, 179.9995, 5.0), Geodetic(-17.0, -179.9985, 5.0)
    mission = Mission(home, (takeoff(home, 20.0), waypoint(there, 40.0), land(there)))
    first, second = lines_of(Forecast(mission))
    assert first.points[-1][0] == 180.0
    assert second.points[0][0] == -180.0
    assert first.points[-1][1:] == second.points[0][1:]
    assert first.points[-1][2] == pytest.approx(25.0 + 20.0 * 0.25, abs=0.01)
    length = sum(EARTH.line_length(*np.array(stretch.points)[:, :2].T) for stretch in (first, second))
    assert length == pytest.approx(EARTH.line_length([179.9995, 180.0015], [-17.0, -17.0]), abs=0.01)
    collection = geojson.loads(exported(mission, ".geojson", tmp_path))
    assert collection.is_valid
    places = gpxpy.parse(exported(mission, ".gpx", tmp_path)).get_points_data()
    assert max(point.point.longitude for point in places) == pytest.approx(180.0, abs=2e-9)
    assert all(-180.0 <= point.point.longitude < 180.0 for point in places), "the schema's longitudeType"


@pytest.mark.parametrize("suffix", [".kml", ".gpx"])
def test_a_name_with_control_characters_is_valid_xml(suffix: str) -> None:
    root = ElementTree.fromstring(forecast_text(Forecast(MISSION), suffix, "field\x01\x1b \ufffe\ud800 1"))
    assert "field\ufffd\ufffd \ufffd\ufffd 1" in [node.text for node in root.iter() if node.tag.endswith("}name")]


def fence_at(longitude: float, inclusion: bool) -> tuple[FenceCircle, FencePolygon]:
    concave = [(-17.0, -0.01), (-17.0, 0.01), (-16.99, 0.01), (-16.997, -0.002), (-16.99, -0.01)]
    corners = tuple((lat, (longitude + east + 180.0) % 360.0 - 180.0) for lat, east in concave)
    return FenceCircle((-17.0, longitude), 200.0, inclusion), FencePolygon(corners[::-1], inclusion)


@pytest.mark.parametrize("longitude", [179.9999, -179.9999])
def test_no_fence_crosses_the_antimeridian(longitude: float, tmp_path: Path) -> None:
    def areas(longitude: float) -> list[float]:
        home = Geodetic(-17.0, longitude, 5.0)
        mission = Mission(home, (takeoff(home, 20.0), land(home)), fence=fence_at(longitude, True))
        collection = geojson.loads(exported(mission, ".geojson", tmp_path))
        assert collection.is_valid
        drawn = [shapely.geometry.shape(feature["geometry"]) for feature in collection["features"][-2:]]
        folder = fastkml.KML.from_string(exported(mission, ".kml", tmp_path).encode()).features[0].features[-1]
        for shape, placemark in zip(drawn, folder.features, strict=True):
            in_kml = shapely.force_2d(shapely.geometry.shape(placemark.geometry))
            assert shape.equals_exact(in_kml, tolerance=1e-6)
            for polygon in shapely.get_parts(shape):
                assert polygon.is_valid
                assert polygon.exterior.is_ccw
                west, _, east, _ = polygon.bounds
                assert east - west < 0.021
        return [sum(EARTH.geometry_area_perimeter(part)[0] for part in shapely.get_parts(shape)) for shape in drawn]

    assert areas(longitude) == pytest.approx(areas(100.0), rel=1e-3)
    assert areas(longitude)[0] == pytest.approx(np.pi * 200.0**2, rel=0.002)


def test_a_gpx_file_is_a_route_at_amsl(tmp_path: Path) -> None:
    gpx = gpxpy.parse(exported(MISSION, ".gpx", tmp_path))
    (route,) = gpx.routes
    assert [(p.name, p.elevation) for p in route.points] == [
        ("1 NAV_TAKEOFF", 60.5),
        ("3 NAV_WAYPOINT", 65.5),
        ("4 NAV_WAYPOINT", 50.5),
    ]
    assert [(p.name, p.elevation) for p in gpx.waypoints] == [("home", 20.5), ("rally 1", 50.5)]
    assert (route.points[1].latitude, route.points[1].longitude) == (39.1023, 121.8212)
    assert gpxpy.parse(exported(TERRAIN, ".gpx", tmp_path)).routes[0].points[2].elevation is None


def test_a_csv_file_has_a_line_for_each_item(tmp_path: Path) -> None:
    rows = list(csv.DictReader(io.StringIO(exported(MISSION, ".csv", tmp_path))))
    assert [row["command"] for row in rows] == [
        "home",
        "NAV_TAKEOFF",
        "DO_CHANGE_SPEED",
        "NAV_WAYPOINT",
        "NAV_WAYPOINT",
        "NAV_RETURN_TO_LAUNCH",
    ]
    assert rows[3]["altitude_amsl_m"] == "65.500"
    assert rows[2]["speed_m_s"] == "8.00"
    assert rows[2]["leg_m"] == ""


def test_legs_in_the_table_are_as_long_and_point_as_the_geodesics_do() -> None:
    rows = mission_table(MISSION)
    for before, after, climb, row in ((HOME, A, 5.0, rows[3]), (A, B, -15.0, rows[4])):
        azimuth, _, level = EARTH.inv(
            before.longitude_deg, before.latitude_deg, after.longitude_deg, after.latitude_deg
        )
        assert row.length == pytest.approx(np.hypot(level, climb), abs=0.01)
        assert row.heading_deg == pytest.approx(azimuth % 360.0, abs=0.01)
        assert row.climb == pytest.approx(climb, abs=0.01)
    assert (rows[1].length, rows[1].heading_deg) == (pytest.approx(40.0), None)
    assert rows[3].hold_s == 3.0
    (place,) = MISSION.rally
    back = EARTH.inv(B.longitude_deg, B.latitude_deg, place.longitude_deg, place.latitude_deg)
    assert rows[5].length == pytest.approx(back[2] + 30.0, abs=0.05)
    assert rows[5].heading_deg == pytest.approx(back[0] % 360.0, abs=0.01)


def test_a_heading_just_west_of_north_is_0_and_a_level_leg_has_no_sign(tmp_path: Path) -> None:
    just_west = Geodetic(A.latitude_deg + 0.001, A.longitude_deg - 4.5e-7)
    legs = replace(MISSION, items=(takeoff(HOME, 40.0), waypoint(A, 45.0), waypoint(just_west, 45.0)))
    *_, row = csv.DictReader(io.StringIO(exported(legs, ".csv", tmp_path)))
    assert (row["heading_deg"], row["climb_m"]) == ("0.0", "0.00")
    last = mission_table(legs)[-1]
    assert last.heading_deg == pytest.approx(359.98, abs=0.02)
    assert last.climb == pytest.approx(-0.0036, abs=0.001)  # along the vertical of home


def test_the_table_knows_the_height_above_a_scenarios_ground() -> None:
    text = f"""
        home = {{ latitude_deg = {HOME.latitude_deg}, longitude_deg = {HOME.longitude_deg}, altitude_amsl = 20.5 }}
        start = {{ east = 0, north = 0, up = 40 }}
        goal = {{ east = 50, north = 200, up = 40 }}
        terrain = {{ kind = "flat", height = 12.0 }}
    """
    rows = mission_table(MISSION, parse_scenario(text, Path("flat.toml")))
    assert rows[3].height_above_ground == pytest.approx(33.0, abs=0.01)
    assert mission_table(MISSION)[3].height_above_ground is None
    assert mission_table(TERRAIN)[4].height_above_ground == 30.0


def test_facts_without_a_column_are_given_in_words() -> None:
    items = (
        Item(177, 2, (3.0, 2.0, 0.0, 0.0)),
        Item(18, 3, (4.0, 0.0, 20.0, 0.0), 39.102, 121.82, 9.0),
        Item(206, 2, (25.0, 0.0, 1.0, 0.0)),
        Item(16, 3, (0.0, 7.5, 0.0, 0.0), 39.102, 121.82, 9.0),
    )
    assert [row.detail for row in mission_table(Mission(HOME, items, Autopilot.ARDUPILOT))[1:]] == [
        "to item 3, 2 times",
        "4 turns, radius 20 m",
        "param1 25, param3 1",
        "within 7.5 m",
    ]
