"""The ground: heights by hand and by scipy, and the least height of a leg against dense sampling."""

from collections.abc import Callable

import numpy as np
import pytest
from scipy.interpolate import RegularGridInterpolator

from ipoa_mission.errors import BadInput
from ipoa_mission.world.terrain import Analytic, Flat, Grid, Peak, Terrain

Rng = np.random.Generator


def flat(rng: Rng) -> Terrain:
    return Flat(rng.uniform(-10, 10))


def grid(rng: Rng) -> Terrain:
    shape = rng.integers(2, 30, 2)
    return Grid(*rng.uniform(-10, 10, 2), rng.uniform(1, 9), rng.uniform(0, 20, shape))


def analytic(rng: Rng) -> Terrain:
    peaks = tuple(Peak(h, *rng.uniform(0, 100, 2), *rng.uniform(5, 30, 2)) for h in rng.uniform(-20, 80, 6))
    return Analytic(*rng.uniform(-2, 2, 7), peaks, rng.uniform(0, 5))


KINDS: dict[str, Callable[[Rng], Terrain]] = {"flat": flat, "grid": grid, "analytic": analytic}


@pytest.mark.parametrize("kind", KINDS)
def test_the_least_height_of_a_leg_is_what_dense_sampling_closes_in_on(kind: str) -> None:
    rng = np.random.default_rng(11)
    for case in range(500):
        ground = KINDS[kind](rng)
        a, b = rng.uniform(-20, 120, (2, 3))
        if case % 5 == 0:
            b[case % 3] = a[case % 3]
        if case % 17 == 0:
            b[:2] = a[:2]
        least, where = ground.leg_clearance(a, b)

        def above(t: np.ndarray, a: np.ndarray = a, b: np.ndarray = b, ground: Terrain = ground) -> np.ndarray:
            points = a + t[:, None] * (b - a)
            return points[:, 2] - ground.height(points)

        sampled = above(np.linspace(0.0, 1.0, 20_001))
        assert least <= sampled.min() + 1e-9
        near = np.clip(np.argmin(sampled) / 20_000 + np.linspace(-1e-4, 1e-4, 2001), 0, 1)
        assert least >= above(near).min() - 1e-3
        assert above(np.array([where]))[0] == pytest.approx(least, abs=2e-4)


def test_a_grid_is_bilinear_and_goes_on_beyond_its_edge() -> None:
    rng = np.random.default_rng(12)
    heights = rng.uniform(0, 50, (7, 9))
    ground = Grid(100.0, -50.0, 2.5, heights)
    north, east = -50.0 + 2.5 * np.arange(7), 100.0 + 2.5 * np.arange(9)
    inside = rng.uniform((100, -50), (120, -35), (500, 2))
    expected = RegularGridInterpolator((north, east), heights)(inside[:, ::-1])
    np.testing.assert_allclose(ground.height(inside), expected, atol=1e-12)
    assert ground.height(np.array([[500.0, -42.5], [110.0, 900.0]])) == pytest.approx([heights[3, 8], heights[6, 4]])


def test_the_papers_surface_is_the_higher_of_landform_and_mountains() -> None:
    ground = Analytic(1.0, 0.5, 0.3, 0.2, 0.7, 0.4, 0.1, (Peak(40.0, 30.0, 60.0, 10.0, 20.0),), 2.0)
    x, y = 33.0, 50.0
    r = np.sqrt(x**2 + y**2)
    low = np.sin(y + 1) + 0.5 * np.sin(x) + 0.3 * np.cos(0.2 * r) + 0.7 * np.cos(y) + 0.4 * np.sin(0.4 * r)
    low += 0.1 * np.cos(y)
    high = 2 + 40 * np.exp(-((3 / 10) ** 2) - (10 / 20) ** 2)
    here = np.array([[x, y]])
    assert ground.landform(here)[0] == pytest.approx(low)
    assert ground.mountains(here)[0] == pytest.approx(high)
    assert ground.height(here)[0] == pytest.approx(max(low, high))


@pytest.mark.parametrize(
    ("make", "place"),
    [
        (lambda: Grid(0, 0, 0.0, np.zeros((3, 3))), "terrain.spacing: expected a positive"),
        (lambda: Grid(0, 0, 1.0, np.zeros((1, 3))), "terrain.heights: expected at least 2 x 2"),
        (lambda: Grid(0, 0, 1.0, np.full((2, 2), np.nan)), "terrain.heights: expected numbers only"),
    ],
)
def test_an_impossible_grid_is_refused(make: Callable[[], Terrain], place: str) -> None:
    with pytest.raises(BadInput, match=place):
        make()
