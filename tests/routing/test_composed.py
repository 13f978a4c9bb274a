"""Routes of many passings are composed of wide and tight legs."""

from pathlib import Path

import numpy as np

from ipoa_mission.autopilot.autopilot import Autopilot
from ipoa_mission.forecast.deviation.kept_limits import clearance_task
from ipoa_mission.forecast.deviation.proximity import proximity_risks
from ipoa_mission.forecast.timing.track import pieces_of
from ipoa_mission.planning.planner import plan_path
from ipoa_mission.routing.assemble import narrowed_route
from ipoa_mission.routing.fastest import composed_route
from ipoa_mission.routing.resample import push_clear
from ipoa_mission.scenario import Scenario, parse_scenario
from tests.quick_search import QUICK


def orchard(autopilot: Autopilot, rows: int, trees: int) -> Scenario:
    """Rows of 100 m, 15 m apart, among trees at random places 6.5 m or farther from the via points."""
    chance = np.random.default_rng(2)
    via = [(30.0 + 15 * row, 20.0 + 100 * (end ^ row & 1)) for row in range(rows) for end in (0, 1)]
    given = np.array([(0, 0), *via, (10, -12)])
    places = chance.uniform((20, 10), (30 + 15 * rows, 130), (20 * trees, 2))
    away = np.linalg.norm(places[:, None] - given, axis=2).min(axis=1)
    bodies = [
        f'{{ kind = "cylinder", name = "tree {n}", east = {e:.2f}, north = {north:.2f}, radius = 1.5, height = 12.0 }}'
        for n, (e, north) in enumerate(places[away > 6.5][:trees])
    ]
    text = f"""
    safety_distance = 1.5
    home = {{ latitude_deg = 47.4, longitude_deg = 8.5, altitude_amsl = 400.0 }}
    start = {{ east = 0.0, north = 0.0, up = 6.0 }}
    via = [{", ".join(f"{{ east = {e}, north = {north}, up = 6.0 }}" for e, north in via)}]
    goal = {{ east = 10.0, north = -12.0, up = 6.0 }}
    bounds = {{ east = [-60, {90 + 15 * rows}], north = [-60, 190], up = [0, 60] }}
    vehicle = {{ autopilot = "{autopilot}", radius = 0.4, cruise_speed = 5.0 }}
    obstacles = [{", ".join(bodies)}]
    """
    return parse_scenario(text, Path("orchard.toml"))


def test_a_composed_route_keeps_its_limits_and_is_quicker_than_one_width() -> None:
    scenario = orchard(Autopilot.PX4, rows=4, trees=45)
    plan = plan_path(scenario, strategy=QUICK)
    composed, even = composed_route(plan, scenario), narrowed_route(plan, scenario, "corridor")
    assert composed.is_fit
    assert composed.is_guaranteed
    assert composed.quick_prediction.seconds < 0.95 * even.quick_prediction.seconds
    for via in scenario.via_points:
        assert np.linalg.norm(composed.route.points - via, axis=1).min() < 1e-9


def test_passings_that_are_not_likeliest_sum_up_to_the_given_chance() -> None:
    scenario = orchard(Autopilot.PX4, rows=6, trees=70)
    attempt = narrowed_route(plan_path(scenario, strategy=QUICK), scenario, "corridor")
    task, required = clearance_task(scenario), scenario.limits.obstacle_distance
    risks = proximity_risks(pieces_of(attempt.quick_prediction.track), scenario.airspace, task.law, required)
    likeliest = risks.likeliest_passings(required, 0.002)
    window = risks.seconds // task.law.decorrelation_s
    passings = {(window[n], int(risks.obstacle[n])) for n in likeliest}
    others = [(window[n], int(body)) not in passings for n, body in enumerate(risks.obstacle)]
    assert 0 < len(passings) == len(likeliest)
    assert risks.subset(np.array(others)).chance(required) <= 2 * 0.002  # lateral and high ones are each bounded


def test_via_points_stay_where_legs_beside_them_are_pushed_clear() -> None:
    scenario = orchard(Autopilot.ARDUPILOT, rows=2, trees=0)
    via = scenario.via_points[0]
    beside = {
        "kind": "cylinder",
        "name": "post",
        "east": float(via[0]) - 2.0,
        "north": float(via[1]) + 1.0,
        "radius": 0.1,
    }
    table = scenario.model_dump(exclude_unset=True) | {"obstacles": (beside | {"height": 20.0},)}
    scenario = Scenario.model_validate(table)
    waypoints = np.array([(0, 0, 6), (25, 20, 6), via, (30, 60, 6), (10, -12, 6)], dtype=float)
    pushed = push_clear(waypoints, scenario)
    assert (pushed[2] == via).all()
    assert (pushed[1] != waypoints[1]).any()
