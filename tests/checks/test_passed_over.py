import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from ipoa_mission.checks.check import check_mission
from ipoa_mission.finding import Finding, Severity
from ipoa_mission.flight.flight import plan_flight
from ipoa_mission.geodesy import Geodetic, LocalFrame
from ipoa_mission.mission.items import Mission, land, takeoff
from ipoa_mission.scenario import Scenario, read_scenario
from tests.px4_waypoints import waypoint
from tests.quick_search import search_quickly
from tests.refused import refuses

HOME = Geodetic(47.4, 8.5, 400.0)
#: Required: 0.5 m of radius, 2 m of distance, 4 m of lateral deviation: 6.5 m.
WORLD = """
home = { latitude_deg = 47.4, longitude_deg = 8.5, altitude_amsl = 400.0 }
start = { east = 0.0, north = 0.0, up = 20.0 }
goal = { east = 100.0, north = 0.0, up = 20.0 }
safety_distance = 2.0
route.ending = "land"
"""
Read = Callable[..., Scenario]


@pytest.fixture
def read(tmp_path: Path) -> Read:
    """Return a flight near a polygon, 20 m square, whose near side is at `north`."""

    def make(north: float, keys: str = "", kind: str = "buildings", geometry: str = "Polygon") -> Scenario:
        features = [feature(40, 300, {"building": "yes"}), feature(40, north, {"name": "thing"}, geometry)]
        (tmp_path / "m.geojson").write_text(json.dumps({"type": "FeatureCollection", "features": features}))
        (tmp_path / "w.toml").write_text(f"{WORLD}\nmaps = [{{ file = 'm.geojson', kind = '{kind}'{keys} }}]")
        return read_scenario(tmp_path / "w.toml")

    return make


def feature(east: float, north: float, tags: dict[str, str], kind: str = "Polygon") -> dict[str, object]:
    corners = np.add([(0, 0, 0), (20, 0, 0), (20, 20, 0), (0, 20, 0), (0, 0, 0)], (east, north, 0.0))
    latitude, longitude, _ = LocalFrame(HOME).to_geodetic(corners)
    ring = np.column_stack([longitude, latitude]).tolist()
    coordinates = [ring] if kind == "Polygon" else ring[:3]
    return {"type": "Feature", "properties": tags, "geometry": {"type": kind, "coordinates": coordinates}}


def straight(scenario: Scenario) -> Mission:
    goal = scenario.frame.geodetic(np.array([100.0, 0.0, 0.0]))
    return Mission(HOME, (takeoff(HOME, 20.0), waypoint(goal, 20.0), land(goal)), scenario.vehicle.autopilot)


def errors(scenario: Scenario) -> list[Finding]:
    findings = check_mission(straight(scenario), scenario)
    return [finding for finding in findings if finding.severity is Severity.ERROR]


@pytest.mark.parametrize(("north", "refused"), [(6.4, True), (6.6, False)])
def test_within_reach_of_the_path_a_thing_passed_over_is_an_error(read: Read, north: float, refused: bool) -> None:
    findings = errors(read(north))
    assert [finding.code for finding in findings] == ["map-not-understood"] * refused
    assert all(f"{north:.1f} m from thing" in finding.message for finding in findings)


def test_the_scenario_may_say_itself_that_it_is_nothing_or_an_obstacle(read: Read) -> None:
    assert errors(read(3.0, ", take = 'tagged'")) == []
    assert errors(read(3.0, ", take = 'all', default_height = 8")) == []  # 8 m high, far below
    (through,) = errors(read(-5.0, ", take = 'all', default_height = 30"))
    assert through.code == "leg-too-near"


def test_an_open_line_among_no_fly_zones_is_an_error_too(read: Read) -> None:
    (finding,) = errors(read(3.0, kind="no_fly", geometry="LineString"))
    assert finding.code == "map-not-understood"


def test_plan_refuses_it(read: Read, monkeypatch: pytest.MonkeyPatch) -> None:
    search_quickly(monkeypatch.setattr)
    with refuses("unsafe", "", "thing on m.geojson") as caught:
        plan_flight(read(-5.0), seed=0)
    assert caught.value.hint
    assert 'take = "tagged" excludes it' in caught.value.hint


def test_features_passed_over_are_a_remark_of_every_plan(read: Read, monkeypatch: pytest.MonkeyPatch) -> None:
    search_quickly(monkeypatch.setattr)
    flight = plan_flight(read(20.0), seed=0)
    assert "m.geojson: 1 passed over, an area untagged: thing" in flight.remarks
