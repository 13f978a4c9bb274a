from typing import Any

import numpy as np
import pytest

from ipoa_mission.planning.proof import Proof, prove, prove_curve, unproved_legs
from ipoa_mission.planning.spline import Spline
from tests.planning.conftest import Make, Place, Town

BALL = {"kind": "sphere", "name": "the ball", "east": 50, "north": 0, "up": 20, "radius": 4}


def distances_of(proof: Proof, limit: str) -> list[float]:
    return [check.nearest.distance for check in proof.checks if check.limit == limit]


def test_a_curve_has_at_least_what_is_proved_and_hardly_more(town: Town) -> None:
    rng = np.random.default_rng(4)
    for seed in range(4):
        job = town(seed)
        limits = job.limits
        control = np.linspace(job.start_point, job.goal_point, 10) + rng.normal(size=(10, 3)) * (5, 15, 5)
        curve = Spline(np.vstack([job.start_point, control[1:-1], job.goal_point]))
        points = curve.points(np.linspace(0, 1, 40_001))
        missed = np.linalg.norm(np.diff(points, axis=0), axis=1).max() * (1 + job.airspace.terrain.steepness)
        least = job.airspace.obstacle_distance(points).min()
        (proved,) = distances_of(prove_curve(curve, job), "obstacles")
        assert least - 2e-3 <= proved <= least + 1e-9
        height = points[:, 2] - job.airspace.ground(points)
        short = (height - limits.required_height(points)).min()
        ground = [check for check in prove_curve(curve, job).checks if check.limit == "ground"]
        assert short - 2e-3 - missed <= min(check.slack for check in ground) <= short + 1e-9
        (reached,) = distances_of(prove_curve(curve, job), "ceiling")
        assert height.max() - 1e-9 <= reached <= height.max() + 2e-3 + missed
        velocity = curve.points(np.linspace(0, 1, 40_001), order=1)
        angles = np.degrees(np.arctan2(velocity[:, 2], np.hypot(velocity[:, 0], velocity[:, 1])))
        for limit, steepest in (("climb", angles.max()), ("descent", -angles.min())):
            (proved,) = distances_of(prove_curve(curve, job), limit)
            assert steepest - 1e-9 <= proved <= steepest + 0.5


def test_legs_are_proved_exactly(scenario: Make) -> None:
    job = scenario(obstacles=[BALL])
    proof = prove(np.array([(0.0, 0, 20), (50, 9, 20), (100, 0, 20)]), job)
    assert distances_of(proof, "obstacles") == [pytest.approx(9 * 50 / np.hypot(50, 9) - 4)]
    assert proof.is_proved
    assert proof.clearance.what == "the ball"


def test_legs_that_are_not_proved_are_listed(scenario: Make) -> None:
    points = np.array([(0.0, 0, 20), (100, 0, 20), (100, 50, 20), (0, 50, 20), (0, 50, 1)])
    for planning in ({}, {"max_height_above_ground": 80}):  # a ceiling over ground has no quick bound
        assert list(unproved_legs(points, scenario(obstacles=[BALL], planning=planning))) == [0, 3]


def test_whether_limits_hold_is_known_without_by_how_much(town: Town) -> None:
    rng, broken = np.random.default_rng(5), 0
    for seed in range(8):
        job = town(seed % 4)
        legs = np.linspace(job.start_point, job.goal_point, 6) + rng.normal(size=(6, 3)) * (10, 30, 10)
        for exact, quick in zip(prove(legs, job).checks, prove(legs, job, spare=0.0).checks, strict=True):
            assert quick.limit == exact.limit
            assert quick == exact if exact.slack < 0 else quick.slack >= -1e-4
            broken += exact.slack < 0
    assert 8 < broken < 40


def test_a_leg_that_cuts_through_does_not_hold_and_says_so(scenario: Make) -> None:
    proof = prove(np.array([(0.0, 0, 20), (100, 0, 20)]), scenario(obstacles=[BALL]))
    assert not proof.is_proved
    assert proof.words() == "4.00 m inside the ball at east 50.0, north 0.0, up 20.0 m"


@pytest.mark.parametrize(
    ("points", "tables", "words"),
    [
        ([(0, 0, 20), (50, 8, 20)], {}, "0.00 m from the ball"),
        ([(0, 0, 20), (0, 0, 103)], {}, "3.00 m beyond the upper bound at east 0.0, north 0.0, up 103.0 m"),
        ([(0, 50, 20), (0, 50, 1)], {}, "1.00 m above the ground at east 0.0, north 50.0, up 1.0 m, at least 1.50 m"),
        ([(0, 50, 20), (9, 50, -1)], {"bounds": {"up": (-9, 99)}}, "1.00 m under the ground at east 9.0"),
        (
            [(0, 0, 20), (0, 20, 30)],
            {"planning": {"max_height_above_ground": 25}},
            "30.00 m above the ground at east 0.0, north 20.0, up 30.0 m, at most 25.00 m required",
        ),
        (
            [(0, 0, 20), (0, 20, 40)],
            {"planning": {"max_climb_angle_deg": 30}},
            "45.00 deg of climb at east 0.0, north 0.0, up 20.0 m, at most 30.00 deg required",
        ),
        (
            [(0, 0, 40), (0, 20, 20)],
            {"planning": {"max_descent_angle_deg": 30}},
            "45.00 deg of descent at east 0.0, north 0.0, up 40.0 m, at most 30.00 deg required",
        ),
    ],
)
def test_each_limit_has_its_words(scenario: Make, points: list[Place], tables: dict[str, Any], words: str) -> None:
    ball = {"kind": "sphere", "name": "the ball", "east": 54, "north": 8, "up": 20, "radius": 4}
    proof = prove(np.array(points, float), scenario(obstacles=[ball], **tables))
    assert not proof.is_proved
    assert proof.words().startswith(words)
    assert proof.worst.about == {"limit": proof.worst.limit, "near": proof.worst.nearest.what}


def test_a_low_start_may_be_left_but_not_be_hugged(scenario: Make) -> None:
    job = scenario(start=(0, 0, 3), goal=(100, 0, 20), planning={"min_height_above_ground": 15})
    (zone,) = job.limits.low_zones
    assert (zone.east, zone.north, zone.height) == pytest.approx((0, 0, 2.99))
    assert zone.radius == pytest.approx(24.02)
    assert prove(np.array([(0.0, 0, 3), (0, 0, 16), (100, 0, 20)]), job).is_proved  # straight up, as it takes off
    assert prove(np.array([(0.0, 0, 3), (24, 0, 15.1), (100, 0, 20)]), job).is_proved
    low = prove(np.array([(0.0, 0, 3), (40, 0, 15.1), (100, 0, 20)]), job)
    assert not low.is_proved
    assert low.worst.limit == "ground"
    assert low.worst.required == 15
    assert low.worst.nearest.place[0] == pytest.approx(zone.radius)
    under = prove(np.array([(0.0, 0, 3), (10, 0, 2), (10, 0, 20), (100, 0, 20)]), job)
    assert under.worst.required == pytest.approx(2.99)
    assert under.worst.nearest.distance == 2


def test_a_low_zone_is_wider_where_climbs_are_flat(scenario: Make) -> None:
    flat = scenario(start=(0, 0, 5), planning={"min_height_above_ground": 15, "max_climb_angle_deg": 10})
    assert flat.limits.low_zones[0].radius == pytest.approx(10.01 / np.tan(np.radians(10)))


def test_places_at_the_required_height_need_no_zone(scenario: Make) -> None:
    assert scenario().limits.low_zones == ()


def test_proof_without_obstacles_does_not_name_them(scenario: Make) -> None:
    proof = prove(np.array([(0.0, 0, 20), (100, 0, 20)]), scenario())
    assert distances_of(proof, "obstacles") == []
    assert proof.clearance.what == "terrain"
