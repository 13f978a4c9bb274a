from typing import Any

import numpy as np
import pytest

from ipoa_mission.autopilot.autopilot import Autopilot, registered
from ipoa_mission.autopilot.commands import Command
from ipoa_mission.checks.check import check_mission
from ipoa_mission.finding import Severity
from ipoa_mission.flight.flight import plan_flight
from ipoa_mission.mission.plan_file import plan_text
from ipoa_mission.planning.planner import Plan
from ipoa_mission.planning.problem import curve_cost
from ipoa_mission.planning.proof import prove_curve
from ipoa_mission.planning.spline import Spline, basis
from ipoa_mission.routing.attempt import Attempt
from ipoa_mission.routing.resample import Route
from ipoa_mission.scenario import Scenario
from tests.examples import vehicles
from tests.quick_search import search_quickly
from tests.refused import refuses
from tests.routing.test_guarantee_kept import flown_path, nearest

CRUISE = 15.0
#: A bent way, and a post outside of the bend.
BENDS = {
    Autopilot.PX4: ([(0, 0), (60, 0), (100, 0), (100, 40), (100, 100)], (102.2, -2.2), False),
    Autopilot.ARDUPILOT: ([(0, 0), (50, 0), (90, 10), (100, 50), (100, 100)], (91.6, 8.4), True),
}


def bend(autopilot: Autopilot) -> tuple[dict[str, Any], Route]:
    places, post, spline = BENDS[autopilot]
    body = {"kind": "cylinder", "name": "post", "east": post[0], "north": post[1], "radius": 0.3, "height": 50.0}
    scene = {
        "home": {"latitude_deg": 47.397742, "longitude_deg": 8.545594, "altitude_amsl": 488.0},
        "start": {"east": 0.0, "north": 0.0, "up": 10.0},
        "goal": {"east": 100.0, "north": 100.0, "up": 10.0},
        "bounds": {"east": (-50, 200), "north": (-50, 200), "up": (0, 60)},
        "safety_distance": 1.0,
        "vehicle": {"autopilot": str(autopilot), "radius": 0.5, "cruise_speed": CRUISE},
        "route": {"ending": "land", "mode": "spline" if spline else "corridor"},
        "obstacles": [body],
    }
    if autopilot is Autopilot.PX4:
        scene["vehicle"]["firmware_version"] = "1.17"  # type: ignore[index]
    return scene, Route(np.array([(*place, 10.0) for place in places]), spline=spline)


def along(route: Route, scenario: Scenario) -> Attempt:
    """Return the only attempt of a search: this route, and a curve along it."""
    at = np.linspace(0.0, 1.0, 400)
    points = np.column_stack([np.interp(at, np.linspace(0.0, 1.0, len(route.points)), axis) for axis in route.points.T])
    curve = Spline(np.asarray(np.linalg.lstsq(basis(24, at), points, rcond=None)[0], float))
    none = np.zeros(1)
    cost, proof = curve_cost(curve, scenario), prove_curve(curve, scenario)
    return Attempt(Plan(curve, cost, proof, "none", 0, none.astype(int), none), route, scenario)


def found_only(route: Route, patch: pytest.MonkeyPatch) -> None:
    search_quickly(patch.setattr)

    def seek(scenario: Scenario, *_: object, **__: object) -> Attempt:
        return along(route, scenario)

    patch.setattr("ipoa_mission.routing.seek.seek", seek)


@pytest.mark.parametrize("autopilot", vehicles(Autopilot.ARDUPILOT))
def test_a_bend_too_near_at_cruise_speed_is_planned_with_a_slower_stretch(
    autopilot: Autopilot, monkeypatch: pytest.MonkeyPatch
) -> None:
    scene, route = bend(autopilot)
    scenario = Scenario.model_validate(scene)
    assert not along(route, scenario).is_acceptable
    found_only(route, monkeypatch)
    flight = plan_flight(scenario)
    speeds = [item.params[1] for item in flight.mission.items if item.command == Command.DO_CHANGE_SPEED]
    assert speeds[0] == speeds[-1] == CRUISE
    assert min(speeds) in (7.5, 3.8)
    assert nearest(flown_path(flight), scene["obstacles"]).min() >= scenario.limits.obstacle_distance
    assert flight.guarantee.clearance is not None
    assert flight.guarantee.clearance.slack >= 0
    assert not any(finding.severity is Severity.ERROR for finding in check_mission(flight.mission, scenario))
    scene["vehicle"]["cruise_speed"] = min(speeds)
    assert flight.estimate.total_s < along(route, Scenario.model_validate(scene)).forecast.estimate.total_s
    (note,) = (remark for remark in flight.remarks if "flown at" in remark)
    assert f"flown at {min(speeds):g} m/s: at 15 m/s, post: 99 % of flights keep" in note
    assert plan_text(plan_flight(scenario).mission) == plan_text(flight.mission)


@pytest.mark.parametrize("autopilot", registered())
def test_gaps_too_narrow_at_any_speed_are_refused(autopilot: Autopilot, monkeypatch: pytest.MonkeyPatch) -> None:
    scene, route = bend(autopilot)
    scene["obstacles"][0]["radius"] = 2.0
    found_only(route, monkeypatch)
    with refuses("no-path", "", "vehicle.cruise_speed = 7.5", "vehicle.cruise_speed = 3.8"):
        plan_flight(Scenario.model_validate(scene))
