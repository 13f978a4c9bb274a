import numpy as np
import pytest

from ipoa_mission.planning.polish import polish, polish_until_proved
from ipoa_mission.planning.problem import Candidate, curve_cost, follow, prepare, refine
from ipoa_mission.planning.spline import Spline
from ipoa_mission.scenario import Scenario
from tests.planning.conftest import Make, Town

LENGTH_ONLY = {"omega": (1.0, 0.0, 0.0)}
VEHICLE = {"radius": 0.5}


def bulging(job: Scenario, aside: float, up: float) -> Candidate:
    straight = follow(job.places, 8, job)
    bulge = np.sin(np.linspace(0, np.pi, 10))[:, None] * (0.0, aside, up)
    return Candidate(Spline(straight.curve.control + bulge), straight.via_at)


def round_a_cylinder(distance: float, radius: float) -> float:
    """Two tangents and an arc between points `distance` away on opposite sides of a circle."""
    return float(2 * np.sqrt(distance**2 - radius**2) + 2 * radius * np.arcsin(radius / distance))


@pytest.mark.parametrize("side", [-1, 1])
def test_round_a_mast_it_finds_two_tangents_and_an_arc(scenario: Make, side: int) -> None:
    mast = {"kind": "cylinder", "name": "mast", "east": 50, "north": 0, "radius": 10, "height": 95, "base": 0.0}
    job = scenario(obstacles=[mast], cost=LENGTH_ONLY, vehicle=VEHICLE, safety_distance=1.0)
    rough = polish(bulging(job, 18.0 * side, 0.0), prepare(job))
    candidate, proof = polish_until_proved(refine(rough), prepare(job))
    assert proof.worst.slack >= 0
    assert candidate.curve.length == pytest.approx(round_a_cylinder(50, 11.5), rel=2e-3)
    assert side * candidate.curve.points(np.array([0.5]))[0, 1] > 11.5


def test_over_a_ball_the_way_is_the_same_turned_upright(scenario: Make) -> None:
    ball = {"kind": "sphere", "name": "ball", "east": 50, "north": 0, "up": 20, "radius": 10}
    job = scenario(obstacles=[ball], cost=LENGTH_ONLY, vehicle=VEHICLE, safety_distance=1.0)
    candidate, proof = polish_until_proved(refine(polish(bulging(job, 0.0, 18.0), prepare(job))), prepare(job))
    assert proof.worst.slack >= 0
    assert candidate.curve.length == pytest.approx(round_a_cylinder(50, 11.5), rel=2e-3)


def test_over_a_wall_the_way_is_straight_to_its_rim_and_down(scenario: Make) -> None:
    """Over a thin wall of 40 m: two straight legs and an arc of the clearance."""
    wall = {
        "kind": "box",
        "name": "wall",
        "east": 50,
        "north": 0,
        "width": 0.2,
        "depth": 190,
        "height": 40,
        "base": 0.0,
    }
    job = scenario(obstacles=[wall], cost=LENGTH_ONLY, vehicle=VEHICLE, safety_distance=1.5)
    candidate, proof = polish_until_proved(refine(polish(bulging(job, 0.0, 40.0), prepare(job))), prepare(job))
    reach = np.hypot(49.9, 20)  # to an edge, with an arc of 2 m
    tangent, angle = np.sqrt(reach**2 - 2**2), np.arctan2(20, 49.9) + np.arcsin(2 / reach)
    assert proof.worst.slack >= 0
    assert candidate.curve.length == pytest.approx(2 * tangent + 2 * 2 * angle + 0.2, rel=3e-3)


def test_ends_and_via_points_stay(scenario: Make) -> None:
    ball = {"kind": "sphere", "name": "ball", "east": 50, "north": 5, "up": 20, "radius": 10}
    job = scenario(via=[(30, 30, 25), (70, -20, 22)], obstacles=[ball])
    candidate = polish(follow(job.places, 15, job), prepare(job))
    np.testing.assert_allclose(candidate.curve.points(candidate.via_at), job.via_points, atol=1e-6)
    np.testing.assert_array_equal(candidate.curve.control[[0, -1]], [job.start_point, job.goal_point])


def test_a_part_is_polished_and_the_rest_stays(scenario: Make) -> None:
    ball = {"kind": "sphere", "name": "ball", "east": 50, "north": 5, "up": 20, "radius": 10}
    job = scenario(obstacles=[ball])
    rough = refine(bulging(job, 30.0, 0.0))
    candidate = polish(rough, prepare(job), part=slice(5, 9))
    change = np.abs(candidate.curve.control - rough.curve.control).max(axis=1)
    assert (change[6:10] > 0).all()
    np.testing.assert_array_equal(np.delete(change, range(6, 10)), 0.0)
    assert prepare(job).cost(candidate) < prepare(job).cost(rough)


def test_polish_never_raises_the_cost(town: Town) -> None:
    for seed in range(4):
        job = town(seed)
        problem, rng = prepare(job), np.random.default_rng(seed)
        rough = follow(job.places, 8, job)
        rough = Candidate(
            Spline(rough.curve.control + 10 * np.eye(10)[:, 1:-1] @ rng.normal(size=(8, 3))), rough.via_at
        )
        assert problem.cost(polish(rough, problem)) <= problem.cost(rough)


def test_the_threat_is_kept_out_of_where_that_is_cheap(scenario: Make) -> None:
    ball = {"kind": "sphere", "name": "ball", "east": 50, "north": 3, "up": 20, "radius": 5}
    job = scenario(obstacles=[ball], vehicle=VEHICLE)
    candidate, _ = polish_until_proved(refine(polish(bulging(job, -8.0, 0.0), prepare(job))), prepare(job))
    assert curve_cost(candidate.curve, job).threat == 0
    assert job.airspace.obstacle_clearance(candidate.curve.sample(1000)).distance == pytest.approx(5.5, abs=0.1)
