import numpy as np
import pytest
import shapely

from ipoa_mission.geometry import Vector
from ipoa_mission.planning.obstruction import NoPath, find_closures, refuse_closed
from ipoa_mission.planning.problem import prepare
from tests.planning.conftest import Make
from tests.refused import refuses


def walls(gaps: Vector, rng: np.random.Generator) -> list[dict[str, object]]:
    """Turned walls across everything, each with a gap [m]."""
    built = []
    for k, gap in enumerate(gaps):
        turn, middle = (
            np.radians(rng.uniform(-15, 15)),
            np.array([100 * (k + 1) / (len(gaps) + 1), rng.uniform(-50, 50)]),
        )
        along = np.array([np.sin(turn), np.cos(turn)])
        for side in (1, -1):
            east, north = middle + side * along * (gap + 300) / 2
            size = {"width": rng.uniform(0.2, 8), "depth": 300, "height": 150, "heading_deg": float(np.degrees(turn))}
            built.append({"kind": "box", "name": f"{k}{side}", "east": east, "north": north, "base": 0.0, **size})
    return built


@pytest.mark.parametrize("seed", range(12))
def test_too_narrow_a_gap_is_closed(scenario: Make, seed: int) -> None:
    rng = np.random.default_rng(seed)
    gaps = 3.0 * rng.choice([0.5, 0.9, 0.99, 1.01, 1.1, 2.0], rng.integers(1, 3))
    job = scenario(obstacles=walls(gaps, rng))
    closed = next(find_closures(prepare(job), np.array([job.start_point, job.goal_point])))
    assert (closed is not None) == (gaps.min() < 3)
    if closed is not None:
        narrowest = int(np.argmin(gaps))
        assert set(closed.names) == {f"{narrowest}1", f"{narrowest}-1"}
        assert closed.width == pytest.approx(gaps.min(), abs=1e-6)
        assert closed.needed == pytest.approx(2 * job.limits.obstacle_distance)
        sides = [o.column.shape for o in job.airspace.obstacles if o.name in closed.names and o.column]
        away = shapely.distance(sides, shapely.Point(closed.place))
        np.testing.assert_allclose(away, gaps.min() / 2, atol=1e-6)


def test_masts_and_the_bounds_leave_gaps_too(scenario: Make) -> None:
    masts = [{"kind": "cylinder", "name": f"{k}", "east": 50, "north": n, "radius": 20, "height": 150, "base": 0.0}
             for k, n in enumerate((-79.0, -36.4, 6.2, 78.9))]  # fmt: skip
    job = scenario(obstacles=masts)
    closed = next(find_closures(prepare(job), np.array([job.start_point, job.goal_point])))
    assert closed is None  # 32.7 m are left between the last two
    job = scenario(obstacles=[*masts, {**masts[0], "name": "last", "north": 42.5, "radius": 14.5}])
    closed = next(find_closures(prepare(job), np.array([job.start_point, job.goal_point])))
    assert closed is not None
    assert closed.names == ("0", "1")
    assert closed.width == pytest.approx(2.6)


def test_obstacles_that_can_be_flown_over_close_nothing(scenario: Make) -> None:
    low = [wall | {"height": 97.0} for wall in walls(np.array([0.1]), np.random.default_rng(0))]
    job = scenario(obstacles=low)  # 1.5 m are required, the bounds leave 3
    refuse_closed(prepare(job))


def test_all_that_stands_round_an_end_is_named(scenario: Make) -> None:
    sides = {"west": (-20, 0, 4, 44), "east": (20, 0, 4, 44), "south": (0, -20, 44, 4), "north": (0, 20, 44, 4)}
    wall = {"kind": "box", "base": 0.0, "height": 150}
    ring = [
        wall | {"name": name, "east": 100 + e, "north": n, "width": width, "depth": depth}
        for name, (e, n, width, depth) in sides.items()
    ]
    with refuses("walled-off", "", "west, east, south", "east 82.0, north 0.0", kind=NoPath):
        refuse_closed(prepare(scenario(obstacles=ring)))
