import numpy as np
import pytest

from ipoa_mission import Airspace, Bounds, Cylinder, Flat, Sphere
from ipoa_mission.world.obstacles.kinds import Prism

BODIES = (
    Sphere("ball", (20.0, 0.0, 25.0), 6.0),
    Cylinder("mast", 50.0, 10.0, 3.0, 0.0, 40.0),
    Prism("hall", ((70.0, -10.0), (95.0, -10.0), (95.0, 20.0), (70.0, 20.0)), (), 0.0, 18.0),
)
AIR = Airspace(Bounds((-50.0, -60.0, -5.0), (150.0, 60.0, 90.0)), Flat(), BODIES)
WITHIN = 12.0


def legs(kind: str) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(3)
    starts, ends = (rng.uniform((-10.0, -30.0, 2.0), (110.0, 40.0, 60.0), (200, 3)) for _ in range(2))
    if kind == "level":
        ends[:, 2] = starts[:, 2]
    elif kind == "upright":
        ends[:, :2] = starts[:, :2]
    return starts, ends


@pytest.mark.parametrize("kind", ["level", "upright", "slanting"])
def test_many_legs_keep_what_each_keeps_alone(kind: str) -> None:
    starts, ends = legs(kind)
    least, which = AIR.legs_clearance(starts, ends, WITHIN)
    for start, end, near, number in zip(starts, ends, least, which, strict=True):
        alone = AIR.obstacle_clearance(np.stack([start, end]))
        if not np.isfinite(near):
            assert number == -1
            assert alone.distance > WITHIN
        else:
            assert near <= alone.distance + 1e-6 or alone.distance <= 0.0
            assert near <= 0.0 or kind == "slanting" or near == pytest.approx(alone.distance, abs=1e-6)


def test_the_nearest_of_many_is_named() -> None:
    least, which = AIR.legs_clearance(np.array([[50.0, 0.0, 20.0]]), np.array([[60.0, 0.0, 20.0]]), WITHIN)
    assert (least[0], BODIES[which[0]].name) == (pytest.approx(7.0), "mast")


def test_empty_world_has_nothing_near() -> None:
    least, which = Airspace(AIR.bounds, Flat()).legs_clearance(np.zeros((2, 3)), np.ones((2, 3)), WITHIN)
    assert np.isinf(least).all()
    assert (which == -1).all()
