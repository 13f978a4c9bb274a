import json
from pathlib import Path

import numpy as np
import pytest

from ipoa_mission import Mission, check_mission, read_scenario
from ipoa_mission.finding import Severity
from ipoa_mission.geodesy import Geodetic
from ipoa_mission.mission.items import land, takeoff, waypoint
from ipoa_mission.scenario import Scenario

HOME = Geodetic(47.0, 8.0, 500.0)


def flown(tmp_path: Path, tags: dict[str, str], geometry: object, kind: str = "buildings") -> tuple[Scenario, Mission]:
    rows = [{"type": "Feature", "geometry": geometry, "properties": tags}, far_house()]
    (tmp_path / "map.geojson").write_text(json.dumps({"type": "FeatureCollection", "features": rows}))
    (tmp_path / "one.toml").write_text(
        "home = { latitude_deg = 47.0, longitude_deg = 8.0, altitude_amsl = 500.0 }\n"
        "start = { east = 0, north = 0, up = 80 }\ngoal = { east = 100, north = 0, up = 80 }\n"
        f"[[maps]]\nkind = '{kind}'\nfile = 'map.geojson'\n"
    )
    scenario = read_scenario(tmp_path / "one.toml")
    goal = scenario.frame.geodetic(np.array([100.0, 0.0, 0.0]))
    items = (takeoff(HOME, 80.0), waypoint(goal, 80.0), land(goal))
    return scenario, Mission(HOME, items, scenario.vehicle.autopilot)


def far_house() -> dict[str, object]:
    return {"type": "Feature", "geometry": box(8.004), "properties": {"building": "yes", "height": "9"}}


def box(west: float) -> dict[str, object]:
    corners = [(0.0, -1.0), (0.0004, -1.0), (0.0004, 1.0), (0.0, 1.0), (0.0, -1.0)]
    return {"type": "Polygon", "coordinates": [[(west + x, 47.0 + y / 10_000) for x, y in corners]]}


def errors(scenario: Scenario, mission: Mission, ignore: tuple[str, ...] = ()) -> list[str]:
    return [finding.code for finding in check_mission(mission, scenario, ignore) if finding.severity is Severity.ERROR]


@pytest.mark.parametrize(
    ("tags", "refused"),
    [
        ({"building": "yes", "height": "30"}, False),
        ({"building": "yes", "height": "30 cubits"}, True),
        ({"building": "yes", "hoch": "70"}, False),
        ({"building": "yes", "z_max": "570"}, True),
    ],
)
def test_a_height_that_is_not_understood_is_an_error_beside_it(
    tmp_path: Path, tags: dict[str, str], refused: bool
) -> None:
    scenario, mission = flown(tmp_path, tags, box(8.0005))
    assert ("not-read" in errors(scenario, mission)) is refused
    assert "not-read" not in errors(scenario, mission, ("not-read",))


@pytest.mark.parametrize("kind", ["buildings", "no_fly"])
def test_a_feature_without_a_geometry_may_be_anywhere(tmp_path: Path, kind: str) -> None:
    scenario, mission = flown(tmp_path, {"building": "yes"}, None, kind)
    assert "not-read" in errors(scenario, mission)
    assert any("without a geometry" in remark for remark in scenario.remarks)
