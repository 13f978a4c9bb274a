"""Altitudes of drawings, units in other keys, supports of wires, other words for a height: none lowers an obstacle."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import shapely

from ipoa_mission.geodesy import LocalFrame
from ipoa_mission.ground import Ground
from ipoa_mission.maps.areas import Zones, find_zones
from ipoa_mission.maps.building_rules import BuildingRules
from ipoa_mission.maps.buildings import Buildings, raise_obstacles, search_buildings
from ipoa_mission.maps.map_reader import read_features
from ipoa_mission.world.terrain import Flat

WriteMap = Callable[..., Path]
At = Callable[[float, float], list[float]]
Square = Callable[..., dict[str, Any]]
HOUSE = {"building": "yes"}


def find(path: Path, frame: LocalFrame) -> Buildings:
    return search_buildings(path, BuildingRules(), frame)


def tops(path: Path, frame: LocalFrame, ground: float = 0.0) -> list[float]:
    raised = raise_obstacles(find(path, frame).obstacles, Ground(Flat(ground)))
    return [round(float(each.bounds[1, 2]), 2) for each in raised]


def high(shape: dict[str, Any], altitude: float) -> dict[str, Any]:
    return {"type": "Polygon", "coordinates": [[[*place, altitude] for place in shape["coordinates"][0]]]}


def test_the_third_coordinate_is_the_least_altitude_of_a_top(
    write_map: WriteMap, frame: LocalFrame, square: Square
) -> None:
    collection = {"type": "GeometryCollection", "geometries": [high(square(0, 0), 560.0)]}  # home is at 500 m
    path = write_map(
        (high(square(0, 0), 560.0), HOUSE), (high(square(50, 0), 510.0), HOUSE), (high(square(90, 0), 560.0), HOUSE),
        (collection, HOUSE), (high(square(0, 50), 560.0), {**HOUSE, "height": "70"}),
    )  # fmt: skip
    assert tops(path, frame, ground=5.0) == [60.0, 25.0, 60.0, 60.0, 75.0]
    remarks = find(path, frame).remarks
    assert "3 shapes drawn above the height of the tags, taken up to there" in remarks


@pytest.mark.parametrize(
    ("altitude", "height", "is_doubtful"), [(60, "20", True), (60, "70", False), (480, "20", False), (0, "20", False)]
)
def test_an_altitude_far_below_home_may_be_a_height_above_ground(
    write_map: WriteMap, frame: LocalFrame, square: Square, altitude: float, height: str, is_doubtful: bool
) -> None:
    path = write_map((high(square(0, 0), altitude), {**HOUSE, "height": height}))  # home is at 500 m
    words = [thing.words for thing in find(path, frame).unread]
    what = "altitude of a shape over 30 m below home, maybe its height above ground"
    assert words == [f'{path.name}: not read: {what}: features[0] ("60 m")'] * is_doubtful
    assert tops(path, frame) == [float(height)]


@pytest.mark.parametrize(
    "position", [[8.0, 47.0], [8.0, 47.0, None], [8.0, 47.0, "60"], [8.0, 47.0, 1.7e9], [8.0, 47.0, float("nan")]]
)
def test_a_third_coordinate_that_is_no_altitude_changes_nothing(
    write_map: WriteMap, frame: LocalFrame, position: list[Any]
) -> None:
    path = write_map(({"type": "Point", "coordinates": position}, {"man_made": "mast", "height": "20"}))
    assert tops(path, frame) == [20.0]


@pytest.mark.parametrize(
    ("mode", "altitude", "extrude", "top"),
    [
        ("relativeToGround", 60, 0, 63.0),
        ("absolute", 560, 0, 60.0),
        ("absolute", 510, 0, 23.0),  # below the top of 20 m
        ("clampToGround", 60, 0, 23.0),
        ("relativeToGround", 60, 1, 63.0),
    ],
)
@pytest.mark.parametrize("kind", ["Polygon", "LinearRing", "Track"])
def test_a_floating_outline_of_a_kml_is_a_roof(
    tmp_path: Path, frame: LocalFrame, mode: str, altitude: float, extrude: int, top: float, kind: str
) -> None:
    corners = [(8.0, 47.0), (8.001, 47.0), (8.001, 47.001), (8.0, 47.0)]
    ring = "<coordinates>" + " ".join(f"{x},{y},{altitude}" for x, y in corners) + "</coordinates>"
    drawn = {
        "Polygon": f"<outerBoundaryIs><LinearRing>{ring}</LinearRing></outerBoundaryIs>",
        "LinearRing": ring,
        "Track": "".join(f"<coord>{x} {y} {altitude}</coord>" for x, y in corners),
    }
    path = tmp_path / "hall.kml"
    path.write_text(
        '<kml><Placemark><ExtendedData><Data name="building"><value>yes</value></Data></ExtendedData>'
        f"<{kind}><extrude>{extrude}</extrude><altitudeMode>{mode}</altitudeMode>{drawn[kind]}</{kind}>"
        "</Placemark></kml>"
    )
    assert tops(path, frame, ground=3.0) == [top]


def test_a_shapefile_and_a_geopackage_keep_the_third_coordinate(tmp_path: Path, frame: LocalFrame) -> None:
    pyogrio = pytest.importorskip("pyogrio")
    corners = [(8.0, 47.0), (8.001, 47.0), (8.001, 47.001), (8.0, 47.0)]
    roof = shapely.to_wkb(shapely.Polygon([(*corner, 560.0) for corner in corners]), output_dimension=3)
    flat = shapely.to_wkb(shapely.Polygon([(*corner, 0.0) for corner in corners]), output_dimension=3)
    for name in ("town.shp", "town.gpkg", "town.fgb"):
        pyogrio.raw.write(
            tmp_path / name, np.array([roof, flat], object), [np.array(["yes", "yes"])], ["building"],
            geometry_type="Polygon Z", crs="EPSG:4326",
        )  # fmt: skip
        assert sorted(tops(tmp_path / name, frame)) == [20.0, 60.0]


@pytest.mark.parametrize(
    ("support", "line", "heights"),
    [
        ({"power": "tower", "height": "75"}, {"power": "line", "voltage": "110000"}, [75.0, 40.0]),
        ({"power": "tower"}, {"power": "line", "voltage": "110000"}, [40.0, 40.0]),
        ({"power": "pole", "height": "12"}, {"power": "minor_line", "height": "14"}, [14.0, 14.0]),
        ({"aerialway": "pylon", "height": "62"}, {"aerialway": "gondola"}, [62.0, 40.0]),
    ],
)
def test_a_wire_hangs_as_high_as_its_supports(
    write_map: WriteMap, frame: LocalFrame, at: At, support: dict[str, str], line: dict[str, str], heights: list[float]
) -> None:
    wire = {"type": "LineString", "coordinates": [at(0, 0), at(90, 0), at(90, 200)]}
    found = find(write_map(({"type": "Point", "coordinates": at(0, 0)}, support), (wire, line)), frame)
    assert [each.height for each in found.obstacles if each.hangs] == heights
    assert any("between higher supports" in remark for remark in found.remarks) == (heights[0] > heights[1])


@pytest.mark.parametrize(
    ("tags", "height"),
    [
        ({"höjd": 66}, 66.0), ({"Hojde": 66}, 66.0), ({"korkeus": 66}, 66.0), ({"wysokość": "66 m"}, 66.0),
        ({"yükseklik": 66}, 66.0), ({"высота": 66}, 66.0), ({"heigth": 66}, 66.0), ({"BLDGHT": 66}, 66.0),
        ({"antalEtager": 22}, 66.0), ({"GASTW": 22}, 66.0), ({"AOG": 22}, 66.0), ({"FLOORCOUNT": 22}, 66.0),
        ({"liczbaKondygnacji": 22}, 66.0), ({"liczba_kondygnacji_podziemnych": 22}, 20.0),
        ({"height": 200, "height_unit": "ft"}, 60.96), ({"height": {"value": 0.05, "unit": "km"}}, 50.0),
        ({"height": 200, "units": "ft"}, 200.0),  # perhaps of another key
        ({"height": 30, "min_height": "3-6"}, 30.0),
    ],
)  # fmt: skip
def test_a_height_in_other_words_is_read(
    write_map: WriteMap, frame: LocalFrame, square: Square, tags: dict[str, Any], height: float
) -> None:
    (house,) = find(write_map((square(0, 0), {**HOUSE, **tags})), frame).obstacles
    assert (house.foot, house.height) == (0.0, pytest.approx(height))


@pytest.mark.parametrize(
    "text", ["Mast, height 66 m", "66 m high", "<td>HEIGHT</td><td>66</td>", "Höhe: 66,5 m", "height 1 200 m"]
)
@pytest.mark.parametrize("key", ["description", "note"])
def test_a_height_in_a_text_is_named_and_no_flight_passes_near(
    write_map: WriteMap, frame: LocalFrame, square: Square, key: str, text: str
) -> None:
    found = find(write_map((square(0, 0), {**HOUSE, key: text}), (square(50, 0), {**HOUSE, key: "5 m high"})), frame)
    (thing,) = found.passed_over
    assert thing.may_be_obstacle
    assert thing.code == "not-read"
    assert "features[0]" in thing.name


def test_a_description_in_a_kml_is_read(tmp_path: Path, frame: LocalFrame) -> None:
    path = tmp_path / "hall.kml"
    path.write_text(
        "<kml><Placemark><description><![CDATA[<b>HEIGHT</b> 66]]></description>"
        '<ExtendedData><Data name="building"><value>yes</value></Data></ExtendedData><LinearRing><coordinates>'
        "8.0,47.0 8.001,47.0 8.001,47.001</coordinates></LinearRing></Placemark></kml>"
    )
    assert [thing.code for thing in find(path, frame).passed_over] == ["not-read"]


def test_numbers_of_a_building_without_a_height_are_named(
    write_map: WriteMap, frame: LocalFrame, square: Square
) -> None:
    tags = {**HOUSE, "tallness": 66, "tallest": "45 m", "area": 5000, "fid": 77, "addr:housenumber": "45", "rooms": 4}
    remarks = find(write_map((square(0, 0), tags)), frame).remarks
    assert remarks == (
        "1 building without a height, given 20 m",
        "numbers of things without a height, not read: tallness, tallest",
    )


def zones(path: Path, frame: LocalFrame, is_flight_area: bool = False) -> Zones:
    return find_zones(read_features(path), frame, path, *([None] if is_flight_area else []))


@pytest.mark.parametrize(
    ("tags", "radius"),
    [
        ({"diameter": 200}, 100.0), ({"radius": 0.1, "radius_units": "NM"}, 185.2), ({"radiusKm": 0.1}, 100.0),
        ({"radius": {"value": 0.1, "unit": "km"}}, 100.0), ({"rayon": "80 m"}, 80.0),
        ({"radius": 300, "radius_unit": "ft"}, 91.44), ({"Poloměr": 80}, 80.0),
    ],
)  # fmt: skip
@pytest.mark.parametrize("is_flight_area", [False, True])
def test_a_point_with_a_size_is_a_circle_on_the_safe_side(
    write_map: WriteMap, frame: LocalFrame, at: At, tags: dict[str, Any], radius: float, is_flight_area: bool
) -> None:
    path = write_map(({"type": "Point", "coordinates": at(0, 0)}, tags))
    (zone,) = zones(path, frame, is_flight_area).zones
    distances = np.linalg.norm(shapely.get_coordinates(zone.shape), axis=1)
    corners = radius if is_flight_area else radius / np.cos(np.pi / 64)
    assert distances == pytest.approx(corners, rel=1e-6)


def test_a_point_with_an_unknown_size_may_be_a_zone(
    write_map: WriteMap, frame: LocalFrame, at: At, square: Square
) -> None:
    point = {"type": "Point", "coordinates": at(0, 0)}
    found = zones(write_map((point, {"buffer": 80}), (point, {"name": "label"}), (square(90, 0), {})), frame)
    assert [(thing.may_be_obstacle, thing.reason) for thing in found.passed_over] == [
        (True, "a point with a size that was not understood (buffer '80')"),
        (False, "a point"),
    ]


@pytest.mark.parametrize("is_flight_area", [False, True])
def test_a_size_of_a_zone_read_in_part_keeps_a_plan_from_being_safe(
    write_map: WriteMap, frame: LocalFrame, at: At, is_flight_area: bool
) -> None:
    path = write_map(({"type": "Point", "coordinates": at(0, 0)}, {"name": "heliport", "radius": "1/2 km"}))
    found = zones(path, frame, is_flight_area)
    (unread,) = found.unread
    assert (unread.words, unread.may_limit) == (
        'map.geojson: not read: size of a point, radius: heliport ("1/2 km")', True,
    )  # fmt: skip
    assert len(found.zones) == 1


def test_limits_of_a_flight_area_are_named(write_map: WriteMap, frame: LocalFrame, square: Square) -> None:
    tags = {"name": "field", "upper": 40, "upperReference": "AGL", "uom": "M", "restriction": "NO_RESTRICTION"}
    path = write_map((square(-50, -50, 200.0), tags))
    found = zones(path, frame, is_flight_area=True)
    assert len(found.zones) == 1
    (unread,) = found.unread
    assert unread.words == (
        'map.geojson: not read: upper limit of a flight area (give it as `up` under [bounds]): field ("40 m AGL")'
    )


@pytest.mark.parametrize(
    ("limit", "height", "reference"),
    [
        ({"value": 120, "unit": 0, "referenceDatum": 0}, 120.0, "AGL"),
        ({"value": 2500, "unit": 1, "referenceDatum": 1}, 762.0, "AMSL"),
        ({"value": 400, "unit": "ft", "referenceDatum": "AGL"}, 121.92, "AGL"),
    ],
)
def test_limits_of_openaip_are_read(
    write_map: WriteMap, frame: LocalFrame, square: Square, limit: dict[str, Any], height: float, reference: str
) -> None:
    (zone,) = zones(write_map((square(0, 0), {"name": "CTR", "upperLimit": limit})), frame).zones
    assert zone.lower is None
    assert zone.upper == (pytest.approx(height), reference)


def test_a_flight_level_of_openaip_is_named(write_map: WriteMap, frame: LocalFrame, square: Square) -> None:
    limit = {"value": 65, "unit": 6, "referenceDatum": 2}
    found = zones(write_map((square(0, 0), {"name": "TMA", "upperLimit": limit})), frame)
    assert found.zones[0].upper is None
    assert json.dumps("upper limit, so that the zone has none")[1:-1] in found.unread[0].what
