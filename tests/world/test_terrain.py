from collections.abc import Callable

import numpy as np
import pytest
import scipy

from ipoa_mission.geodesy import Geodetic, LocalFrame
from ipoa_mission.ground import Ground
from ipoa_mission.world.terrain import Analytic, Flat, Grid, Peak, SeaLevel, Terrain
from tests.plain_python import as_plain_python
from tests.refused import refuses

Rng = np.random.Generator


def flat(rng: Rng) -> Terrain:
    return Flat(rng.uniform(-10, 10))


def grid(rng: Rng) -> Terrain:
    shape = rng.integers(2, 30, 2)
    return Grid(rng.uniform(-10, 10), rng.uniform(-10, 10), rng.uniform(1, 9), rng.uniform(0, 20, shape))


def analytic(rng: Rng) -> Terrain:
    peaks = tuple(Peak(h, *rng.uniform(0, 100, 2), *rng.uniform(5, 30, 2)) for h in rng.uniform(-20, 80, 6))
    a, b, c, d, e, f, g = rng.uniform(-2, 2, 7).tolist()
    return Analytic(a, b, c, d, e, f, g, peaks, rng.uniform(0, 5))


def sea_level(rng: Rng) -> Terrain:
    return SeaLevel(rng.uniform(-10, 10), rng.uniform(0, 0.1), rng.uniform(0, 0.1), 200.0)


KINDS: dict[str, Callable[[Rng], Terrain]] = {"flat": flat, "sea level": sea_level, "grid": grid, "analytic": analytic}


def heights_above(ground: Terrain, a: np.ndarray, b: np.ndarray, t: np.ndarray) -> np.ndarray:
    points = a + t[:, None] * (b - a)
    return points[:, 2] - ground.height(points)


@pytest.mark.parametrize("greatest", [False, True], ids=["least", "greatest"])
@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("legs", [100, pytest.param(600, marks=pytest.mark.long)])
def test_the_extreme_height_of_a_leg_is_what_dense_sampling_closes_in_on(kind: str, greatest: bool, legs: int) -> None:
    rng, sign = np.random.default_rng(11), -1 if greatest else 1
    for case in range(legs):
        ground = KINDS[kind](rng)
        a, b = rng.uniform(-20, 120, (2, 3))
        if case % 5 == 0:
            b[case % 3] = a[case % 3]
        if case % 17 == 0:
            b[:2] = a[:2]
        if case % 19 == 0:
            b[:2] = -a[:2]  # over the kink at the origin
        height, leg, where = (ground.greatest_height if greatest else ground.least_height)(np.array([a, b]))
        sampled = sign * heights_above(ground, a, b, np.linspace(0.0, 1.0, 20_001))
        assert sign * height <= sampled.min() + 1e-9
        near = np.clip(np.argmin(sampled) / 20_000 + np.linspace(-1e-4, 1e-4, 2001), 0, 1)
        assert sign * height >= (sign * heights_above(ground, a, b, near)).min() - 1e-3
        assert leg == 0
        assert heights_above(ground, a, b, np.array([where]))[0] == pytest.approx(height, abs=2e-4)


@pytest.mark.parametrize("kind", KINDS)
def test_the_extreme_heights_of_many_legs_are_those_of_the_extreme_leg(kind: str) -> None:
    rng = np.random.default_rng(13)
    for _ in range(20):
        ground, points = KINDS[kind](rng), rng.uniform(-20, 120, (12, 3))
        points[7] = points[8]
        singly = [ground.least_height(points[i : i + 2])[0] for i in range(11)]
        height, leg, _ = ground.least_height(points)
        assert height == pytest.approx(min(singly), abs=2e-4)
        at_least = ground.legs_height(points[:-1], points[1:])
        assert (at_least <= np.array(singly) + 2e-4).all()
        if kind != "analytic":  # its steepness says less
            np.testing.assert_allclose(at_least, singly, atol=1e-9)
        assert singly[leg] == pytest.approx(min(singly), abs=2e-4)
        singly = [ground.greatest_height(points[i : i + 2])[0] for i in range(11)]
        assert ground.greatest_height(points)[0] == pytest.approx(max(singly), abs=2e-4)


@pytest.mark.parametrize("kind", KINDS)
def test_a_height_that_is_enough_is_not_found_more_exactly_than_that(kind: str) -> None:
    rng = np.random.default_rng(15)
    for _ in range(50):
        ground, points = KINDS[kind](rng), rng.uniform(-20, 120, (4, 3))
        least, leg, where = ground.least_height(points)
        assert ground.least_height(points, enough=least + 1.0) == pytest.approx((least, leg, where), abs=2e-4)
        assert least - 1.0 <= ground.least_height(points, enough=least - 1.0)[0] <= least + 2e-4


def test_leg_height_over_terrain_is_equal_compiled_and_in_python() -> None:
    plain, rng = as_plain_python("ipoa_mission.world._analytic"), np.random.default_rng(16)
    for greatest in (False, True):
        for case in range(20):
            ground, points = analytic(rng), rng.uniform(-20, 120, (4, 3))
            assert isinstance(ground, Analytic)
            peaks = np.array([(p.height, p.east, p.north, p.a, p.b) for p in ground.peaks])
            landform = (ground.a, ground.b, ground.c, ground.d, ground.e, ground.f, ground.g, ground.base)
            if case == 0:
                points[2] = np.nan
            expected = plain.extreme(points, landform, peaks, greatest, np.inf)
            height = (ground.greatest_height if greatest else ground.least_height)(points)
            assert height == pytest.approx(expected, abs=1e-9)
        legs = np.stack([points[:-1], points[1:]], axis=1)
        singly = [plain.extreme(leg, landform, peaks, False, np.inf)[0] for leg in legs]
        assert plain.least_heights(legs, landform, peaks, np.inf).tolist() == singly
        assert (plain.least_heights(legs, landform, peaks, -1e6) <= singly).all()  # by their bounds alone
        assert ground.legs_height(legs[:, 0], legs[:, 1]) == pytest.approx(singly, abs=1e-9)


@pytest.mark.parametrize("axis", range(3))
def test_leg_that_is_no_number_is_not_proved(axis: int) -> None:
    ground, points = analytic(np.random.default_rng(17)), np.full((4, 3), 500.0)
    points[2, axis] = np.nan
    assert ground.least_height(points)[0] == -np.inf
    assert ground.greatest_height(points)[0] == np.inf


@pytest.mark.parametrize("kind", KINDS)
def test_the_ground_is_nowhere_steeper_than_its_steepness(kind: str) -> None:
    rng = np.random.default_rng(14)
    for _ in range(50):
        ground, a = KINDS[kind](rng), rng.uniform(-20, 120, (500, 2))
        b = a + rng.normal(size=a.shape)
        rise = np.abs(ground.height(b) - ground.height(a))
        assert (rise <= ground.steepness * np.linalg.norm(b - a, axis=1) + 1e-9).all()


def test_a_grid_is_bilinear_and_goes_on_beyond_its_edge() -> None:
    rng = np.random.default_rng(12)
    heights = rng.uniform(0, 50, (7, 9))
    ground = Grid(100.0, -50.0, 2.5, heights)
    north, east = -50.0 + 2.5 * np.arange(7), 100.0 + 2.5 * np.arange(9)
    inside = rng.uniform((100, -50), (120, -35), (500, 2))
    expected = scipy.interpolate.RegularGridInterpolator((north, east), heights)(inside[:, ::-1])
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
        (lambda: Grid(0, 0, 0.0, np.zeros((3, 3))), ("bad-input", "terrain.spacing")),
        (lambda: Grid(0, 0, 1.0, np.zeros((1, 3))), ("bad-input", "terrain.heights")),
        (lambda: Grid(0, 0, 1.0, np.full((2, 2), np.nan)), ("bad-input", "terrain.heights")),
    ],
)
def test_an_impossible_grid_is_refused(make: Callable[[], Terrain], place: tuple[str, ...]) -> None:
    with refuses(*place):
        make()


@pytest.mark.parametrize("latitude", [-60.0, 0.0, 47.0])
def test_ground_at_one_height_above_the_sea_is_so_by_proj(latitude: float) -> None:
    """Two kilometers away it is 0.3 m below home's plane."""
    home = Geodetic(latitude, 8.0, 500.0)
    ground = SeaLevel.around(home, 3.0, 20_000.0)
    rng = np.random.default_rng(3)
    spots = rng.uniform(-14_000, 14_000, (500, 2))
    points = np.column_stack([spots, ground.height(spots)])
    np.testing.assert_allclose(LocalFrame(home).to_geodetic(points)[2], 503.0, atol=0.01)
    assert ground.height(np.array([[2000.0, 0.0]]))[0] - 3.0 == pytest.approx(-0.314, abs=0.003)
    slopes = np.abs(np.diff(ground.height(np.column_stack([np.arange(0.0, 20_000.0), np.zeros(20_000)]))))
    assert slopes.max() <= ground.steepness


def test_the_ground_is_told_from_its_datum_on_a_round_earth() -> None:
    ground, places = Ground(Flat(12.0), datum=2.0, earth_radius=6.4e6), np.array([[0.0, 0.0], [3000.0, 4000.0]])
    np.testing.assert_allclose(ground(places), [10.0, 10.0 + 25e6 / 12.8e6])
    np.testing.assert_allclose(Ground(Flat(12.0), datum=2.0)(places), [10.0, 10.0])
    assert Ground(Flat(12.0)).at(3000.0, 4000.0) == 12.0
