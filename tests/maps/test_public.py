"""Maps of public reports, rebuilt small; docs/lab/readers.md has the log."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import shapely

from ipoa_mission.geodesy import LocalFrame
from ipoa_mission.maps.areas import find_zones
from ipoa_mission.maps.building_rules import BuildingRules
from ipoa_mission.maps.buildings import Buildings, search_buildings
from ipoa_mission.maps.map_reader import read_features

Square = Callable[..., dict[str, Any]]
WriteMap = Callable[..., Path]

#: Report, properties of an area, foot and height [m].
AREAS: list[tuple[str, dict[str, Any], float, float]] = [
    ("onthegomap/planetiler#1323, 2025-08", {"building": "yes", "height": "574'"}, 0.0, 174.9552),
    ("Zkir/UrbanEye3D#52, 2026-04", {"building:part": "yes", "height": "81 m"}, 0.0, 81.0),
    ("OSMBuildings#259, 2025-10", {"building": "civic", "building:levels": "3", "roof:levels": "2"}, 0.0, 15.0),
    ("NoiseModelling PR 843, 2025-10", {"building": "yes", "height": "12.5"}, 0.0, 12.5),
    ("OSMBuilding#127, 2025-05", {"building:part": "yes", "building:levels": "9", "building:min_level": "4"}, 12.0, 27),
    ("OvertureMaps/schema#352, 2025-06", {"height": None, "num_floors": 18, "has_parts": False}, 0.0, 54.0),
    ("openaddresses PR 7955, 2025-12", {"building": "yes", "levels": 5}, 0.0, 15.0),
    ("functions-lab/geo2sigmap PR 12, 2026-05", {"building": "yes", "building:height": "31"}, 0.0, 31.0),
    ("louis-e/arnis PR 1271, 2026-08", {"building": "yes", "height": "unknown", "building:levels": "7"}, 0.0, 21.0),
    ("CityOfNewYork/nyc-planimetrics#15, 2023-12", {"HEIGHT_ROOF": 33.0, "GROUND_ELEVATION": 400.0}, 0.0, 33.0),
    ("microsoft/GlobalMLBuildingFootprints#63, 2023-07", {"height": 6.2, "confidence": 0.8}, 0.0, 6.2),
    ("osmlab/labuildings#64, 2016-04", {"building": "yes", "building:levels": "<4"}, 0.0, 12.0),
    ("osmose-backend#278, 2018-02: a full-width mark", {"building": "yes", "building:levels": "１；７"}, 0.0, 21.0),
]


def search(path: Path, frame: LocalFrame) -> Buildings:
    return search_buildings(path, BuildingRules(), frame)


@pytest.mark.parametrize(("source", "tags", "foot", "height"), AREAS, ids=[row[0] for row in AREAS])
def test_a_building_of_a_report_is_as_high_as_it_is(
    write_map: WriteMap,
    frame: LocalFrame,
    square: Square,
    source: str,
    tags: dict[str, Any],
    foot: float,
    height: float,
) -> None:
    buildings = search(write_map((square(0, 0), tags)), frame)
    (thing,) = buildings.obstacles
    assert buildings.passed_over == buildings.unread == ()
    assert (thing.foot, thing.height) == pytest.approx((foot, height)), source


def test_an_outline_and_its_parts_of_other_heights_all_stand(
    write_map: WriteMap, frame: LocalFrame, square: Square
) -> None:
    """osmandapp/OsmAnd#24468, 2026-02."""
    outline = (square(0, 0, 40), {"building": "yes", "height": "70"})
    parts = [(square(0, 0), {"building:part": "yes", "height": "70", "min_height": "20"})]
    parts += [(square(20, 20), {"building:part": "yes", "building:levels": "4"})]
    assert [s.height for s in search(write_map(outline, *parts), frame).obstacles] == [70.0, 70.0, 12.0]


@pytest.mark.parametrize(
    ("tags", "foot", "height"),
    [
        ({"man_made": "mast", "height": "8", "location": "roof"}, 30.0, 38.0),
        ({"man_made": "antenna", "height": "8 m", "location": "rooftop"}, 30.0, 38.0),
        ({"man_made": "antenna", "height": "38", "min_height": "30", "location": "roof"}, 30.0, 38.0),
        ({"man_made": "antenna", "location": "roof"}, 30.0, 90.0),  # 60 m for an unknown one
        ({"man_made": "mast", "height": "8"}, 0.0, 8.0),
    ],
)
def test_a_mast_on_a_roof_reaches_above_it(
    write_map: WriteMap, frame: LocalFrame, square: Square, tags: dict[str, Any], foot: float, height: float
) -> None:
    """StrandedKitty/streets-gl#88 (2023-05), tordanik/OSM2World#242 (2025-03)."""
    place = {"type": "Point", "coordinates": square(10, 10)["coordinates"][0][0]}
    house = (square(0, 0), {"building": "yes", "height": "30"})
    buildings = search(write_map((place, tags), house), frame)
    heights = {(thing.foot, thing.height) for thing in buildings.obstacles}
    assert heights == {(0.0, 30.0), (foot, height)}
    assert buildings.passed_over == ()


def test_a_mast_on_a_roof_that_the_map_lacks_is_named(write_map: WriteMap, frame: LocalFrame, square: Square) -> None:
    place = {"type": "Point", "coordinates": square(10, 10)["coordinates"][0][0]}
    mast = {"man_made": "mast", "height": "8", "location": "roof"}
    buildings = search(write_map((place, mast), (square(50, 0), {"building": "yes"})), frame)
    (doubt,) = buildings.passed_over
    assert "a height that was not understood (location 'roof'), 8 m was taken" in str(doubt)


def test_a_collection_a_line_is_read(tmp_path: Path, frame: LocalFrame, square: Square) -> None:
    """microsoft/KenyaNigeriaBuildingFootprints#1, 2022-01: GDAL did not read it."""
    path = tmp_path / "town.geojsonl"
    rows = [{"type": "Feature", "properties": {"height": 9 + n}, "geometry": square(50 * n, 0)} for n in range(3)]
    path.write_text("".join(json.dumps({"type": "FeatureCollection", "features": [row]}) + "\n" for row in rows))
    assert [s.height for s in search(path, frame).obstacles] == [9, 10, 11]


def test_a_zone_with_a_label_in_one_collection_is_a_zone(tmp_path: Path, frame: LocalFrame) -> None:
    """MKergall/osmbonuspack#233: blanks after commas, a ring that is not closed, a point beside it."""
    path = tmp_path / "zone.kml"
    corners = "\n8.0, 47.0, 0\n 8.001, 47.0, 0\n 8.001, 47.001, 0\n 8.0, 47.001, 0\n"
    ring = f"<outerBoundaryIs><LinearRing><coordinates>{corners}</coordinates></LinearRing></outerBoundaryIs>"
    point = "<Point><coordinates>8.0005, 47.0005</coordinates></Point>"
    inside = f"<MultiGeometry>{point}<Polygon>{ring}</Polygon></MultiGeometry>"
    path.write_text(f"<kml><Document><Placemark><name>asd</name>{inside}</Placemark></Document></kml>")
    zones = find_zones(read_features(path), frame, path)
    assert [round(zone.shape.area, -1) for zone in zones.zones] == [8460.0]
    assert [thing.reason for thing in zones.passed_over] == ["a point"]


@pytest.mark.parametrize(
    ("field", "height"), [("Startheight", 45.0), ("buildingHeight", 45.0), ("HEIGHT_ROOF", 45.0), ("est_heig", 45.0)]
)
def test_a_name_of_a_report_that_was_cut_is_a_height(
    tmp_path: Path, frame: LocalFrame, field: str, height: float
) -> None:
    """qgis/QGIS#52153, 2023-03: `Startheigh`; mapbox/shp-write#74: eight letters."""
    pyogrio = pytest.importorskip("pyogrio")
    path = tmp_path / "town.shp"
    shape = np.array([shapely.to_wkb(shapely.box(8.0, 47.0, 8.001, 47.001))], object)
    pyogrio.raw.write(
        path, shape, [np.array([height])], [field[:10]], geometry_type="Polygon", crs="EPSG:4326",
        driver="ESRI Shapefile",
    )  # fmt: skip
    assert [s.height for s in search(path, frame).obstacles] == [height]
