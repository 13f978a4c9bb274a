import numpy as np
import pytest

from ipoa_mission.planning.problem import curve_cost, path_cost
from ipoa_mission.planning.spline import Spline
from tests.planning.conftest import Make

BALL = {"kind": "sphere", "name": "ball", "east": 50, "north": 0, "up": 20, "radius": 4}


def test_the_papers_sums_by_hand(scenario: Make) -> None:
    cost = {"form": "nodes", "omega": (0.5, 0.3, 0.2), "a1": 2.0, "a2": 3.0, "lambda_obs": 7.0, "d_safe": 5.0}
    job = scenario(obstacles=[BALL], cost=cost, vehicle={"radius": 1.0})
    nodes = np.array([(30.0, 0, 20), (42, 0, 20), (42, 10, 20), (42, 20, 30)])
    terms = path_cost(nodes, job)
    assert terms.length == pytest.approx(22 + np.hypot(10, 10))
    assert terms.turning_deg == pytest.approx(90)
    assert terms.climbing_deg == pytest.approx(45)
    assert terms.threat == pytest.approx(7 / (8 - 5))  # (42, 0) only: the others are beyond d_safe
    assert terms.total == pytest.approx(0.5 * terms.length + 0.3 * (2 * 90 + 3 * 45) + 0.2 * terms.threat)


def test_a_threat_counts_up_to_d_safe_from_the_hull(scenario: Make) -> None:
    job = scenario(obstacles=[BALL], cost={"form": "nodes"}, vehicle={"radius": 1.0})
    just_in, just_out = (np.array([(50.0, 10.0 + d, 20.0), (50.0, 60.0, 20.0)]) for d in (-1e-6, 1e-6))
    assert path_cost(just_in, job).threat == pytest.approx(10 / 5)
    assert path_cost(just_out, job).threat == 0


def test_the_integral_does_not_depend_on_how_many_nodes_there_are(scenario: Make) -> None:
    job = scenario(obstacles=[BALL])
    curve = Spline(np.array([(0.0, 0, 20), (30, 5, 20), (50, 12, 22), (70, 5, 20), (100, 0, 20)]))
    few, many = path_cost(curve.sample(800), job), path_cost(curve.sample(8000), job)
    assert few.total == pytest.approx(many.total, rel=2e-3)
    assert few.threat == pytest.approx(many.threat, rel=2e-2)
    assert curve_cost(curve, job).total == pytest.approx(many.total, rel=1e-3)


def test_the_threat_along_a_straight_leg_is_its_integral(scenario: Make) -> None:
    """Past a cylinder at 4 m from the hull: the integral of lambda / d over the chord of the d_safe circle."""
    mast = {"kind": "cylinder", "name": "mast", "east": 50, "north": 0, "radius": 2, "height": 90, "base": 0.0}
    job = scenario(obstacles=[mast], vehicle={"radius": 0.5})
    leg = np.linspace((0, 6.5, 20), (100, 6.5, 20), 100_001)
    from scipy.integrate import quad

    half = np.sqrt(7.5**2 - 6.5**2)
    expected = quad(lambda x: 10 / (np.hypot(x, 6.5) - 2.5), -half, half)[0]
    assert path_cost(leg, job).threat == pytest.approx(expected, rel=1e-3)
