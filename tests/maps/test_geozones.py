import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pyproj import Geod

from ipoa_mission.errors import BadInput
from ipoa_mission.geodesy import Geodetic, LocalFrame
from ipoa_mission.maps.areas import find_zones
from ipoa_mission.maps.map_reader import read_features
from ipoa_mission.scenario import Scenario, read_scenario
from tests.refused import refuses

CENTER = [8.002, 47.0]  # 152 m east of home
WORLD = """
home = { latitude_deg = 47.0, longitude_deg = 8.0, altitude_amsl = 500.0 }
start = { east = 0, north = 0, up = 10 }
goal = { east = 300, north = 0, up = 10 }
terrain = { kind = "flat", height = 3.0 }
"""


def ed269(lower: tuple[float, str], upper: tuple[float, str], unit: str, restriction: str) -> dict[str, Any]:
    volume = {
        "uomDimensions": unit,
        "lowerLimit": lower[0],
        "lowerVerticalReference": lower[1],
        "upperLimit": upper[0],
        "upperVerticalReference": upper[1],
        "horizontalProjection": {"type": "Circle", "center": CENTER, "radius": 50},
    }
    zone = {"identifier": "LS1", "restriction": restriction, "applicability": [{"permanent": "NO"}]}
    return {"title": "zones", "features": [zone | {"geometry": [volume]}]}


def ed318(lower: tuple[float, str], upper: tuple[float, str], unit: str, restriction: str) -> dict[str, Any]:
    layer = {"lower": lower[0], "lowerReference": lower[1], "upper": upper[0], "upperReference": upper[1], "uom": unit}
    extent = {"subType": "Circle", "radius": 50}
    geometry = {"type": "Point", "coordinates": CENTER, "extent": extent, "layer": layer}
    properties = {"identifier": "LS1", "restriction": restriction, "limitedApplicability": [{"startDateTime": "2026"}]}
    feature = {"type": "Feature", "properties": properties, "geometry": geometry}
    return {"type": "FeatureCollection", "features": [feature]}


def read(folder: Path, document: dict[str, Any], keys: str = "") -> Scenario:
    (folder / "zones.json").write_text(json.dumps(document))
    (folder / "w.toml").write_text(f"{WORLD}\nmaps = [{{ kind = 'no_fly', file = 'zones.json'{keys} }}]")
    return read_scenario(folder / "w.toml")


@pytest.mark.parametrize("make", [ed269, ed318])
@pytest.mark.parametrize(
    ("lower", "upper", "unit", "base", "top"),
    [
        ((20, "AGL"), (120, "AGL"), "M", 23.0, 123.0),
        ((520, "AMSL"), (620, "AMSL"), "m", 20.0, 120.0),
        ((100, "AGL"), (2000, "AMSL"), "FT", 33.48, 109.6),
        ((0, "AGL"), (50, "AGL"), "M", None, 53.0),
    ],
)
def test_the_limits_of_a_zone_are_those_of_the_wall(
    tmp_path: Path, make: Any, lower: Any, upper: Any, unit: str, base: float | None, top: float
) -> None:
    scenario = read(tmp_path, make(lower, upper, unit, "PROHIBITED"))
    (zone,) = scenario.airspace.obstacles
    assert zone.name == "LS1"
    assert zone.bounds[1, 2] == pytest.approx(top, abs=0.02)
    if base is None:
        assert zone.bounds[0, 2] < scenario.airspace.bounds.lower[2]
    else:
        assert zone.bounds[0, 2] == pytest.approx(base, abs=0.02)
    assert scenario.geofence == ()
    assert "zones.json: LS1: active at times only, kept at all times" in scenario.remarks


@pytest.mark.parametrize(
    ("lower", "refused"), [((0, "AMSL"), True), ((0, "AGL"), True), ((40, "AGL"), False), ((540, "AMSL"), False)]
)
def test_home_may_be_under_a_zone_but_not_in_one(tmp_path: Path, lower: Any, refused: bool) -> None:
    document = ed269(lower, (1000, "AMSL"), "M", "PROHIBITED")
    document["features"][0]["geometry"][0]["horizontalProjection"]["radius"] = 500
    if refused:
        with refuses("home-outside-fence", "zones.json", "LS1", kind=BadInput):
            read(tmp_path, document)
    else:
        read(tmp_path, document)


@pytest.mark.parametrize("make", [ed269, ed318])
def test_a_circle_becomes_a_polygon_just_round_it(tmp_path: Path, make: Any) -> None:
    (tmp_path / "z.json").write_text(json.dumps(make((0, "AGL"), (9, "AGL"), "M", "PROHIBITED")))
    (feature,) = read_features(tmp_path / "z.json")
    corners = np.array(feature.shape.exterior.coords)
    n = len(corners)
    _, _, away = Geod(ellps="WGS84").inv([CENTER[0]] * n, [CENTER[1]] * n, corners[:, 0], corners[:, 1])
    np.testing.assert_allclose(away, 50.05, atol=0.01)


def test_the_scenario_says_which_restrictions_count(tmp_path: Path) -> None:
    zone = ed269((0, "AGL"), (120, "AGL"), "M", "REQ_AUTHORISATION")
    assert len(read(tmp_path, zone).airspace.obstacles) == 1
    allowed = read(tmp_path, zone, ", restrictions = ['PROHIBITED']")
    assert allowed.airspace.obstacles == ()
    assert "zones.json: 1 passed over, its restriction is REQ_AUTHORISATION: LS1" in allowed.remarks


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"horizontalProjection": 3}, "horizontalProjection: expected a Polygon or a Circle"),
        ({"horizontalProjection": {"type": "Circle", "center": [8, 47], "radius": -1}}, "expected a circle"),
        (
            {"horizontalProjection": {"type": "Polygon", "coordinates": [[[8, 47], [8, 48]]]}},
            "coordinates[0]: expected",
        ),
    ],
)
def test_a_zone_that_makes_no_sense_is_refused_with_its_place(
    tmp_path: Path, change: dict[str, Any], words: str
) -> None:
    document = ed269((0, "AGL"), (120, "AGL"), "M", "PROHIBITED")
    document["features"][0]["geometry"][0] |= change
    with pytest.raises(BadInput) as caught:
        read(tmp_path, document)
    assert "zones.json: features[0].geometry[0]" in str(caught.value)
    assert words in str(caught.value)


def drawn(scenario: Scenario) -> list[tuple[str, float, float]]:
    """Name, lower and upper end of every zone above home [m]; infinite outside the bounds."""
    least, most = scenario.airspace.bounds.lower[2], scenario.airspace.bounds.upper[2]
    ends = [(zone.name, *zone.bounds[:, 2].tolist()) for zone in scenario.airspace.obstacles]
    return [(name, -np.inf if low < least else low, np.inf if high > most else high) for name, low, high in ends]


@pytest.mark.parametrize("make", [ed269, ed318])
@pytest.mark.parametrize(
    ("lower", "upper", "unit", "ends", "expected"),
    [
        ((0, "AGL"), (65, "STD"), "FL", (-np.inf, np.inf), 'upper limit, so that the zone has none'),
        ((20, "AGL"), (40, "AGL"), "LY", (-np.inf, np.inf), 'lower limit, so that the zone has none'),
        ((40, "AGL"), (20, "AGL"), "M", (-np.inf, np.inf), 'an upper limit that is not above the lower one'),
        ((0, "AGL"), (50, "AMSL"), "M", (-np.inf, np.inf),
         'limits below the ground, ignored'),
    ],
)  # fmt: skip
def test_a_limit_that_is_not_understood_opens_no_hole_and_is_named(
    tmp_path: Path, make: Any, lower: Any, upper: Any, unit: str, ends: tuple[float, float], expected: str
) -> None:
    scenario = read(tmp_path, make(lower, upper, unit, "PROHIBITED"))
    assert [zone[1:] for zone in drawn(scenario)] == [pytest.approx(ends, abs=0.02)]
    assert (expected, "LS1") in [(thing.what, thing.place) for thing in scenario.unread]
    assert all(thing.words in scenario.remarks for thing in scenario.unread)


@pytest.mark.parametrize("make", [ed269, ed318])
def test_limits_above_the_ellipsoid_are_counted_from_the_geoid(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, make: Any
) -> None:
    """By PROJ's grid, or else for any geoid."""
    grid, values = tmp_path / "geoid.gtx", np.full((5, 5), 47.25, ">f4")
    header = np.array([46.0, 7.0, 0.5, 0.5], ">f8").tobytes() + np.array([5, 5], ">i4").tobytes()
    grid.write_bytes(header + values.tobytes())
    document = make((580, "WGS84"), (680, "WGS84"), "M", "PROHIBITED")
    monkeypatch.setattr("ipoa_mission.maps.geoid.GRIDS", (str(grid),))
    scenario = read(tmp_path, document)
    (zone,) = scenario.airspace.obstacles
    assert zone.bounds[:, 2] == pytest.approx((32.75, 132.75), abs=0.02)
    assert not scenario.unread
    words = "LS1: lower limit 580 m WGS84 taken less 47.25 m of geoid (by geoid.gtx)"
    assert any(remark.endswith(words) for remark in scenario.remarks)
    monkeypatch.setattr("ipoa_mission.maps.geoid.GRIDS", ("no_such_grid.tif",))
    scenario = read(tmp_path, document)
    (zone,) = scenario.airspace.obstacles
    assert zone.bounds[:, 2] == pytest.approx((580 - 86 - 500, 680 + 107 - 500), abs=0.02)
    assert [(thing.place, thing.example) for thing in scenario.unread] == [
        ("LS1", "580 m WGS84"),
        ("LS1", "680 m WGS84"),
    ]
    assert all("the worst" in thing.what for thing in scenario.unread)


def test_a_zone_far_away_with_such_a_limit_refuses_no_file(tmp_path: Path) -> None:
    document = ed318((0, "AGL"), (40, "AGL"), "m", "PROHIBITED")
    far = ed318((0, "AGL"), (1200, "WGS84"), "m", "PROHIBITED")["features"][0]
    far["geometry"]["coordinates"] = [9.2, 47.0]  # 91 km
    document["features"].append(far)
    assert drawn(read(tmp_path, document)) == [("LS1", -np.inf, pytest.approx(43.0, abs=0.02))]


@pytest.mark.parametrize("word", ["NO_RESTRICTION", "PROHIBITED", "REQ_AUTHORIZATION", "CONDITIONAL", "USPACE"])
def test_ed318_calls_the_restriction_type(tmp_path: Path, word: str) -> None:
    document = ed318((0, "AGL"), (40, "AGL"), "m", "?")
    del document["features"][0]["properties"]["restriction"]
    document["features"][0]["properties"]["type"] = word
    assert len(drawn(read(tmp_path, document))) == (word != "NO_RESTRICTION")
    assert len(drawn(read(tmp_path, document, ", restrictions = ['PROHIBITED']"))) == (word == "PROHIBITED")
    assert len(drawn(read(tmp_path, document, ", restrictions = ['REQ_AUTHORISATION']"))) == ("AUTH" in word)
    assert len(drawn(read(tmp_path, document, ", restrictions = ['REQ_AUTHORIZATION']"))) == ("AUTH" in word)


def test_a_restriction_that_nobody_knows_keeps_a_flight_out_and_is_named(tmp_path: Path) -> None:
    scenario = read(tmp_path, ed269((0, "AGL"), (40, "AGL"), "M", "FORBIDDEN"))
    assert len(drawn(scenario)) == 1
    assert [thing.words for thing in scenario.unread] == [
        'zones.json: not read: restriction, taken as one that keeps a flight out: LS1 ("FORBIDDEN")'
    ]


def test_the_layers_of_a_collection_are_those_of_its_members(tmp_path: Path) -> None:
    low, high = (
        ed318((lower, "AGL"), (upper, "AGL"), "m", "PROHIBITED")["features"][0]["geometry"]
        for lower, upper in ((0, 20), (200, 300))
    )
    document = ed318((0, "AGL"), (1, "AGL"), "m", "PROHIBITED")
    document["features"][0]["geometry"] = {"type": "GeometryCollection", "geometries": [low, high]}
    document["features"][0]["properties"]["name"] = [
        {"lang": "sv-SE", "text": "Norra"},
        {"lang": "en", "text": "North"},
    ]
    zones = drawn(read(tmp_path, document))
    assert zones[0] == ("North", -np.inf, pytest.approx(23.0, abs=0.02))
    assert zones[1][1] == pytest.approx(203.0, abs=0.02)
    shared = high.pop("layer")
    document["features"][0]["geometry"] |= {"layer": shared}
    assert drawn(read(tmp_path, document))[1][1] == pytest.approx(203.0, abs=0.02)


def estonian(properties: dict[str, Any]) -> dict[str, Any]:
    square = [[8.002, 47.0], [8.003, 47.0], [8.003, 47.001], [8.002, 47.001], [8.002, 47.0]]
    about = {"identifier": "EEGZ1", "type": "COMMON", "restriction": "REQ_AUTHORISATION"}
    feature = {"type": "Feature", "geometry": {"type": "Polygon", "coordinates": [square]}}
    return {"type": "FeatureCollection", "features": [feature | {"properties": about | properties}]}


@pytest.mark.parametrize(
    ("properties", "ends"),
    [
        ({"lower": "SFC", "upper": "120m AGL", "lowerMeters": 0, "upperMeters": 120}, (-np.inf, 123.0)),
        ({"lower": "400 FT AGL", "upper": "6000 FT AMSL", "upperMeters": 1800}, (124.92, 1328.8)),
        ({"lowerMeters": 120, "upperMeters": 9999, "hidden": True}, (123.0, 10002.0)),
        ({"lower": "SFC", "upper": "FL 65"}, (-np.inf, np.inf)),
        ({"lower": "GND", "upper": "UNL"}, (-np.inf, np.inf)),
        ({"upper": "6000 FT AGL", "upperMeters": 1800, "geometry": {"uomDimensions": "FT", "lowerLimit": 100,
          "lowerVerticalReference": "AGL", "upperLimit": 400, "upperVerticalReference": "AGL"}}, (33.48, 124.92)),
        ({"lowerLimit": 20, "lowerVerti": "AGL", "upperLimit": 40, "upperVerti": "AGL"}, (23.0, 43.0)),
    ],
)  # fmt: skip
def test_limits_in_the_properties_are_read(tmp_path: Path, properties: dict[str, Any], ends: Any) -> None:
    scenario = read(tmp_path, estonian(properties), "")
    ((_, low, high),) = drawn(scenario)
    top = scenario.airspace.obstacles[0].bounds[1, 2]
    assert low == pytest.approx(ends[0], abs=0.05)
    assert (np.inf if ends[1] == np.inf and high == np.inf else top) == pytest.approx(ends[1], abs=0.2)


def test_times_and_radii_of_ed269_are_understood_or_named(tmp_path: Path) -> None:
    summer = {"applicability": [{"permanent": "NO", "startDateTime": "2026-06-01T00:00:00.000Z", "schedule": [],
                                 "endDateTime": "2026-08-31T00:00:00.000Z"}]}  # fmt: skip
    (tmp_path / "zones.json").write_text(json.dumps(estonian(summer)))
    maps = "\nmaps = [{ kind = 'no_fly', file = 'zones.json' }]"
    for time, count in (("2026-07-01T10:00:00Z", 1), ("2026-11-01T10:00:00Z", 0)):
        (tmp_path / "t.toml").write_text(f"time = {time}\n{WORLD}{maps}")
        assert len(drawn(read_scenario(tmp_path / "t.toml"))) == count
    scenario = read(tmp_path, ed269((0, "AGL"), (40, "AGL"), "FT", "PROHIBITED"))
    assert [thing.words for thing in scenario.unread] == [
        'zones.json: not read: unit of a radius, taken as m: LS1 ("50 FT")'
    ]
    named = read(tmp_path, estonian({"ceiling_ft": 400, "Lower_Limit": "x"}))
    assert {thing.what for thing in named.unread} == {
        'tag "ceiling_ft", which may be a limit', 'tag "Lower_Limit", which may be a limit'
    }  # fmt: skip
    misspelled = ed269((0, "AGL"), (40, "AGL"), "M", "PROHIBITED")
    (volume,) = misspelled["features"][0]["geometry"]
    volume["uperLimit"] = volume.pop("upperLimit")
    (thing,) = read(tmp_path, misspelled).unread
    assert (thing.what, thing.example) == ('tag "uperLimit", which may be a limit', "40")


@pytest.mark.parametrize("key", ["uperLimit", "UPPER"])
def test_a_misspelled_limit_of_an_ed318_layer_is_named(tmp_path: Path, key: str) -> None:
    document = ed318((0, "AGL"), (40, "AGL"), "M", "PROHIBITED")
    layer = document["features"][0]["geometry"]["layer"]
    layer[key] = layer.pop("upper")
    (thing,) = read(tmp_path, document).unread
    assert (thing.what, thing.example) == (f'tag "{key}", which may be a limit', "40")


def test_interuss_zones_are_read(samples: Path) -> None:
    path = samples / "interuss+monitoring" / "geo-awareness-che-1.json"
    zones = find_zones(read_features(path), LocalFrame(Geodetic(46.5, 7.2, 700.0)), path)
    assert len(zones.zones) == 9
    assert [(thing.name, thing.reason) for thing in zones.passed_over] == [
        ("Gantrisch Nature Park", "its restriction is NO_RESTRICTION")
    ]
    assert zones.zones[-1].upper is not None
    assert zones.zones[-1].upper.height == pytest.approx(76.2)  # 250 ft
