from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

import ipoa_mission as api
from ipoa_mission.flight.flight import plan_flight
from ipoa_mission.forecast.forecast import Forecast
from ipoa_mission.geometry import Points, Vector
from ipoa_mission.planning.planner import plan_path
from ipoa_mission.scenario import Scenario, read_scenario
from ipoa_mission.world.obstacles import Obstacle, Sphere

Place = tuple[float, float, float]


@dataclass(frozen=True)
class Cable(Obstacle):
    """A straight tube with round ends between two places."""

    name: str
    start: Place
    end: Place
    radius: float

    @property
    def bounds(self) -> NDArray[np.float64]:
        ends = np.array([self.start, self.end])
        return np.array([ends.min(axis=0) - self.radius, ends.max(axis=0) + self.radius])

    @property
    def parts(self) -> tuple[Sphere, ...]:
        """Balls half as far apart as the tube is thick, and larger to cover it."""
        start, step = np.array(self.start), np.subtract(self.end, self.start)
        count = int(np.ceil(np.linalg.norm(step) / self.radius)) + 1
        places = start + np.linspace(0, 1, count)[:, None] * step
        return tuple(Sphere(self.name, (e, n, u), 1.16 * self.radius) for e, n, u in places.tolist())

    def distance(self, points: Points) -> Vector:
        start, step = np.array(self.start), np.subtract(self.end, self.start)
        share = np.clip((points - start) @ step / (step @ step), 0, 1)
        return np.asarray(np.linalg.norm(points - start - share[:, None] * step, axis=1) - self.radius)

    def leg_clearance(self, a: Vector, b: Vector) -> tuple[float, float]:
        """The distance along a leg is convex."""
        low, high = 0.0, 1.0
        for _ in range(80):
            third = (high - low) / 3
            near, far = self.distance(a + np.array([[low + third], [high - third]]) * (b - a))
            low, high = (low, high - third) if near < far else (low + third, high)
        return float(self.distance((a + low * (b - a))[None])[0]), low

    def grown(self, aside: float, below: float, above: float) -> "Cable":
        return replace(self, radius=self.radius + max(aside, below, above))


CABLE = Cable("cable", (0.0, 60.0, 25.0), (160.0, 60.0, 35.0), 2.0)


@pytest.fixture
def strung(missions: Path) -> Scenario:
    scenario = read_scenario(missions / "sitl.toml")
    middle = (scenario.start_point + scenario.goal_point) / 2
    leg = scenario.goal_point - scenario.start_point
    across = np.array([-leg[1], leg[0], 0.0]) / np.hypot(leg[0], leg[1]) * 25.0
    cable = Cable("cable", tuple((middle - across).tolist()), tuple((middle + across).tolist()), 2.0)
    strung = replace(scenario.airspace, obstacles=(*scenario.airspace.obstacles, cable))
    return scenario.with_airspace(strung)


def test_its_parts_cover_it() -> None:
    rng = np.random.default_rng(5)
    points = rng.uniform(CABLE.bounds[0], CABLE.bounds[1], (20_000, 3))
    inside = points[CABLE.distance(points) <= 0]
    assert len(inside) > 20
    assert np.min([part.distance(inside) for part in CABLE.parts], axis=0).max() <= 0


def test_cable_is_planned_round_and_kept_away_from(strung: Scenario) -> None:
    cable: Obstacle = strung.airspace.obstacles[-1]
    assert cable.leg_clearance(strung.start_point, strung.goal_point) == pytest.approx((-2.0, 0.5), abs=1e-6)
    plan = plan_path(strung, seed=1)
    required = strung.vehicle.radius + strung.safety_distance
    assert cable.distance(plan.curve.sample(4000)).min() >= required


def test_its_clearance_as_flown_is_not_that_of_its_box(strung: Scenario) -> None:
    """A leg beside a slanted cable, inside its box."""
    slanted = Cable("cable", (0.0, 0.0, 20.0), (100.0, 100.0, 60.0), 2.0)
    a, b = np.array([[60.0, 20.0, 40.0]]), np.array([[90.0, 50.0, 40.0]])
    exact, _ = slanted.leg_clearance(a[0], b[0])
    air = replace(strung.airspace, obstacles=(slanted,))
    quick, _ = air.legs_clearance(a, b, 60.0)
    assert exact - 0.5 < quick[0] <= exact
    kept = min(np.hypot(*np.maximum(passing[:2], 0.0)).min() for passing in slanted.passings(a, b))
    assert exact - 0.5 < kept <= exact


def test_a_mission_beside_it_is_promised_its_distance(strung: Scenario) -> None:
    guarantee = Forecast(plan_flight(strung, seed=1).mission, strung).guarantee
    assert not guarantee.forbidding
    kept = next(limit for limit in guarantee.limits if limit.in_cruise and limit.limit == "obstacles")
    points = guarantee.flight.pieces.points
    exact = strung.airspace.obstacle_clearance(points).distance
    assert strung.limits.obstacle_distance <= kept.guaranteed <= exact


def test_cable_is_drawn(strung: Scenario, missions: Path, tmp_path: Path) -> None:
    path = np.array([strung.start_point, strung.goal_point])
    for name, scenario in (("with", strung), ("without", read_scenario(missions / "sitl.toml"))):
        api.write_picture(api.draw_views(scenario, {"way": path}), tmp_path / f"{name}.svg")
    assert (tmp_path / "with.svg").read_bytes() != (tmp_path / "without.svg").read_bytes()
