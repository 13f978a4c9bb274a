import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from ipoa_mission.errors import BadInput
from ipoa_mission.geodesy import Geodetic, LocalFrame
from ipoa_mission.scenario import Scenario, parse_scenario, read_scenario
from ipoa_mission.world.terrain import Grid
from tests.refused import refuses

FRAME = LocalFrame(Geodetic(47.0, 8.0, 500.0))
FLIGHT = """
home = { latitude_deg = 47.0, longitude_deg = 8.0, altitude_amsl = 500.0 }
start = { east = 0, north = 0, up = 10 }
goal = { east = 100, north = 0, up = 10 }
"""
Ring = list[tuple[float, float]]
Read = Callable[..., Scenario]


def box(west: float, south: float, east: float, north: float) -> Ring:
    return [(west, south), (east, south), (east, north), (west, north)]


@pytest.fixture
def read(tmp_path: Path) -> Read:
    """Read a flight with one map of polygons in local meters, and `keys` of its table."""

    def make(keys: str, *rings: Ring | list[Ring], flight: str = FLIGHT, **tags: Any) -> Scenario:
        features = []
        for number, each in enumerate(rings):
            several = each if isinstance(each[0], list) else [each]
            coordinates = []
            for ring in several:
                corners = np.array([(*corner, 0.0) for corner in [*ring, ring[0]]], float)
                latitude, longitude, _ = FRAME.to_geodetic(corners)
                coordinates.append(np.column_stack([longitude, latitude]).tolist())
            geometry = {"type": "Polygon", "coordinates": coordinates}
            properties = {"name": f"zone {number}"} | tags
            features.append({"type": "Feature", "properties": properties, "geometry": geometry})
        (tmp_path / "x.geojson").write_text(json.dumps({"type": "FeatureCollection", "features": features}))
        return parse_scenario(f"{flight}\nmaps = [{{ file = 'x.geojson', {keys} }}]", tmp_path / "here.toml")

    return make


def test_buildings_are_obstacles_beside_those_drawn_by_hand(read: Read) -> None:
    flight = FLIGHT + "obstacles = [{ kind = 'sphere', east = 50, north = 30, up = 20, radius = 5 }]"
    scenario = read("kind = 'buildings'", box(40, -20, 60, -10), flight=flight, building="yes", height="23")
    ball, house = scenario.airspace.obstacles
    assert (ball.name, house.name) == ("sphere 0", "zone 0")
    np.testing.assert_allclose(house.bounds, [[40, -20, 0], [60, -10, 23]], atol=1e-6)


def test_buildings_far_from_the_flight_widen_no_bounds_and_are_left_out(read: Read) -> None:
    rings = [box(40, -30, 60, -20), box(90, 40, 110, 70), box(900, 900, 920, 920)]
    scenario = read("kind = 'buildings'", *rings, building="yes", height="23")
    bounds = scenario.airspace.bounds
    assert (bounds.lower[:2], bounds.upper[:2]) == (pytest.approx((-50, -80)), pytest.approx((160, 120)))
    assert bounds.upper[2] == pytest.approx(23 + 50)
    assert [house.name for house in scenario.airspace.obstacles] == ["zone 0", "zone 1"]
    assert scenario.remarks == ("x.geojson: 1 passed over, more than 100 m outside the bounds: zone 2",)


def test_a_flight_area_is_the_footprint_of_the_bounds_and_a_fence(read: Read) -> None:
    area = [(-20.0, -30.0), (150.0, -40.0), (120.0, 60.0), (-20.0, 50.0)]
    hole = box(40, 20, 60, 40)
    scenario = read("kind = 'flight_area'", [area, hole])
    bounds = scenario.airspace.bounds
    assert (bounds.lower[:2], bounds.upper[:2]) == (pytest.approx((-20, -40)), pytest.approx((150, 60)))
    # East edge from (150, -40) to (120, 60): 30 m west for 100 m north.
    assert bounds.margin(np.array([[100.0, 0.0, 10.0]]))[0] == pytest.approx(
        (138 - 100) * 100 / np.hypot(30, 100), abs=1e-4
    )
    assert bounds.margin(np.array([[50.0, 30.0, 10.0]]))[0] == pytest.approx(-10, abs=1e-4)
    inside, outside = scenario.geofence
    assert (inside.inclusion, outside.inclusion) == (True, False)
    assert inside.polygon is not None
    np.testing.assert_allclose(sorted(inside.polygon), sorted(area), atol=1e-6)


def test_a_no_fly_zone_is_a_wall_from_below_to_above_everything(read: Read) -> None:
    scenario = read("kind = 'no_fly'", box(40, 5, 60, 30))
    (zone,) = scenario.airspace.obstacles
    low, high = scenario.airspace.bounds.lower[2], scenario.airspace.bounds.upper[2]
    heights = np.linspace(low, high, 9)
    points = np.column_stack([np.full(9, 50.0), np.full(9, -3.0), heights])
    np.testing.assert_allclose(zone.distance(points), 8.0, atol=1e-6)
    assert high == pytest.approx(10 + 50)  # the zone does not widen the bounds
    assert [fence.inclusion for fence in scenario.geofence] == [False]


def test_a_no_fly_zone_with_a_top_may_be_flown_over_and_is_no_fence(read: Read) -> None:
    scenario = read("kind = 'no_fly', top = 30", box(40, 5, 60, 30))
    (zone,) = scenario.airspace.obstacles
    assert zone.distance(np.array([[50.0, 10.0, 42.0]]))[0] == pytest.approx(12)
    assert scenario.geofence == ()


def test_a_map_may_stay_out_of_the_geofence(read: Read) -> None:
    assert read("kind = 'no_fly', geofence = false", box(40, 5, 60, 30)).geofence == ()


def test_fences_drawn_by_hand_come_first(read: Read) -> None:
    flight = FLIGHT + "fence = [{ center = { east = 0, north = 0 }, radius = 400 }]"
    scenario = read("kind = 'no_fly'", box(40, 5, 60, 30), flight=flight)
    assert [fence.radius for fence in scenario.geofence] == [400, None]


def test_the_path_keeps_a_fence_that_was_drawn_by_hand(read: Read) -> None:
    """Inside a box and a circle of 60 m, outside of a circle of 10 m."""
    fence = """
    fence = [
      { polygon = [[-30, -40], [200, -40], [200, 40], [-30, 40]] },
      { center = { east = 20, north = 0 }, radius = 60 },
      { center = { east = 40, north = 0 }, radius = 10, inclusion = false },
    ]
    """
    airspace = read("kind = 'buildings'", box(40, 25, 60, 30), flight=FLIGHT + fence, building="yes").airspace
    spots = np.array([(-29, 0, 10), (-31, 0, 10), (79, 0, 10), (81, 0, 10), (0, 39, 10), (0, 41, 10)], float)
    assert (airspace.bounds.margin(spots) > 0).tolist() == [True, False] * 3
    (out,) = [obstacle for obstacle in airspace.obstacles if obstacle.name == "fence[2]"]
    heights = np.linspace(airspace.bounds.lower[2], airspace.bounds.upper[2], 5)
    np.testing.assert_allclose(out.distance(np.array([(40, 25, height) for height in heights])), 15.0)


def test_a_fence_that_leaves_home_out_is_refused(read: Read) -> None:
    house = ("kind = 'buildings'", box(40, 25, 60, 30))
    outside = "fence = [{ center = { east = 100, north = 0 }, radius = 60 }]"
    with refuses("home-outside-fence", "here.toml: fence", "40", kind=BadInput):
        read(*house, flight=FLIGHT + outside, building="yes")
    inside = "fence = [{ center = { east = 10, north = 0 }, radius = 60, inclusion = false }]"
    with refuses("home-outside-fence", "here.toml: fence[0]", kind=BadInput):
        read(*house, flight=FLIGHT + inside, building="yes")
    crossed = "fence = [{ polygon = [[-10, -10], [10, 10], [10, -10], [-10, 10]] }]"
    with refuses("invalid-ring", "here.toml: fence[0]", "do not cross or overlap: self-intersection"):
        read(*house, flight=FLIGHT + crossed, building="yes")


def test_home_outside_the_flight_area_is_refused(read: Read) -> None:
    with refuses("home-outside-fence", "x.geojson", "25.0", kind=BadInput):
        read("kind = 'flight_area'", box(25, -30, 150, 60))


def test_home_in_a_no_fly_zone_is_refused(read: Read) -> None:
    with refuses("home-outside-fence", "x.geojson", "zone 0", kind=BadInput):
        read("kind = 'no_fly'", box(-5, -5, 5, 5))


def test_the_flight_area_with_home_counts_and_those_that_touch_it(read: Read) -> None:
    scenario = read("kind = 'flight_area'", box(-20, -20, 50, 50), box(50, -20, 150, 50))
    assert scenario.airspace.bounds.upper[0] == pytest.approx(150)
    apart = read("kind = 'flight_area'", box(160, -20, 250, 50), box(-20, -20, 150, 50))
    assert apart.airspace.bounds.upper[0] == pytest.approx(150)
    assert len(apart.geofence) == 1
    remark = "x.geojson: 1 passed over, an area that does not touch the one around home: area 2"
    assert remark in apart.remarks


def test_a_map_of_nothing_is_refused(read: Read) -> None:
    with pytest.raises(BadInput) as caught:
        read("kind = 'buildings'", box(40, 5, 60, 30), leisure="park")
    assert str(caught.value).endswith("x.geojson: expected buildings, but none of 1 features is tagged as one")
    assert 'take = "all"' in str(caught.value.hint)
    assert len(read("kind = 'buildings', take = 'all'", box(40, 5, 60, 30), man_made="bridge").airspace.obstacles) == 1


@pytest.mark.parametrize(
    ("keys", "words"),
    [
        ("kind = 'roads'", "maps[0].kind: expected 'buildings', 'no_fly', 'flight_area', not 'roads'"),
        ("kind = 'buildings', defalt_height = 3", "maps[0].defalt_height: unknown key; did you mean default_height?"),
        ("kind = 'buildings', point_radius = 0", "maps[0].point_radius: expected a number greater than 0, not 0"),
        ("kind = 'no_fly', base = 9, top = 3", "maps[0]: expected base below top, not 9 and 3"),
    ],
)
def test_wrong_keys_are_named(read: Read, keys: str, words: str) -> None:
    with pytest.raises(BadInput) as caught:
        read(keys, box(40, 5, 60, 30))
    assert str(caught.value).endswith(f"here.toml: {words}")


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("maps = [{ kind = 'no_fly', file = 'no.kml' }]", "maps[0].file: expected a map, but there is no file no.kml"),
        (
            "terrain = { kind = 'elevation', file = 'no.tif' }",
            "terrain.file: expected an elevation model, but there is no file no.tif",
        ),
    ],
)
def test_files_that_are_not_there_are_named(line: str, words: str) -> None:
    with pytest.raises(BadInput) as caught:
        parse_scenario(FLIGHT + line, Path("here.toml"))
    assert str(caught.value) == f"here.toml: {words}"


def test_the_bounds_reach_over_a_hill_between_the_ends() -> None:
    hill = "terrain = { kind = 'analytic', peaks = [{ height = 300, east = 50, north = 0, a = 20, b = 20 }] }"
    assert parse_scenario(FLIGHT + hill, Path("here.toml")).airspace.bounds.upper[2] > 300


def test_the_old_town_is_read_from_its_four_maps(missions: Path) -> None:
    pytest.importorskip("rasterio")
    scenario = read_scenario(missions / "oldtown.toml")
    airspace = scenario.airspace
    assert isinstance(airspace.terrain, Grid)
    names = [obstacle.name for obstacle in airspace.obstacles]
    assert {"town hall", "church", "arch", "barn", "mast", "school"} <= set(names)
    assert len(scenario.geofence) == 3
    assert "20 kV line" in names
    assert any("1 power line of unknown voltage without a height, given 15 m" in remark for remark in scenario.remarks)
    for place in (scenario.start_point, scenario.goal_point):
        assert airspace.clearance(place[None, :])[0] > 5
        assert airspace.bounds.margin(place[None, :])[0] > 5


def test_the_maps_of_the_old_town_say_that_they_are_synthetic(missions: Path) -> None:
    rasterio = pytest.importorskip("rasterio")
    for name in ("oldtown.geojson", "oldtown-area.geojson", "oldtown-zones.kml"):
        assert "Synthetic: no such place exists." in (missions / name).read_text(encoding="utf-8")
    with rasterio.open(missions / "oldtown.tif") as model:
        assert "Synthetic" in model.tags()["TIFFTAG_IMAGEDESCRIPTION"]
