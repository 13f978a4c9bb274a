"""UAS zones as authorities publish them: their circles, limits and restrictions."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pyproj import Geod

from ipoa_mission.errors import BadInput
from ipoa_mission.maps.areas import find_zones
from ipoa_mission.maps.read import read_features
from ipoa_mission.scenario import Scenario, read_scenario
from ipoa_mission.world.frame import Geodetic, LocalFrame

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
        with pytest.raises(BadInput, match="expected home outside of no-fly zones, but it is in LS1"):
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
        ({"uomDimensions": "LY"}, "expected a number in M or FT, not '0' in 'LY'"),
        ({"lowerVerticalReference": "FL"}, "lowerReference: expected AGL or AMSL, not 'FL'"),
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
    with pytest.raises(BadInput) as told:
        read(tmp_path, document)
    assert "zones.json: features[0].geometry[0]" in str(told.value)
    assert words in str(told.value)


def test_interuss_zones_are_read(samples: Path) -> None:
    path = samples / "interuss+monitoring" / "geo-awareness-che-1.json"
    found = find_zones(read_features(path), LocalFrame(Geodetic(46.5, 7.2, 700.0)), path)
    assert len(found.zones) == 9
    assert [(thing.name, thing.reason) for thing in found.passed_over] == [
        ("Gantrisch Nature Park", "its restriction is NO_RESTRICTION")
    ]
    assert found.zones[-1].upper is not None
    assert found.zones[-1].upper.height == pytest.approx(76.2)  # 250 ft
