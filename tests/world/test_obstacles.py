from collections.abc import Callable

import numpy as np
import pytest
import shapely

from ipoa_mission.errors import BadInput
from ipoa_mission.world.obstacles import Cylinder, Obstacle, Prism, Sphere, Zone
from ipoa_mission.world.obstacles.obstacle import CYLINDER, SPHERE
from ipoa_mission.world.polygon import Polygon
from tests.plain_python import as_plain_python
from tests.refused import refuses

Rng = np.random.Generator


def a_sphere(rng: Rng) -> Obstacle:
    return Sphere("ball", tuple(rng.uniform(-20, 20, 3)), rng.uniform(1, 15))


def a_cylinder(rng: Rng) -> Obstacle:
    east, north, base = rng.uniform(-20, 20, 3)
    return Cylinder("mast", east, north, rng.uniform(1, 15), base, base + rng.uniform(1, 30))


def a_box(rng: Rng) -> Obstacle:
    west, south, base = lower = rng.uniform(-20, 10, 3)
    east, north, top = lower + rng.uniform(2, 30, 3)
    return Prism("box", ((west, south), (east, south), (east, north), (west, north)), (), base, top)


def a_ring(rng: Rng, corners: int, low: float, high: float, center: np.ndarray) -> tuple[tuple[float, float], ...]:
    angle = np.sort(rng.uniform(0, 2 * np.pi, corners))
    while np.diff(np.append(angle, angle[0] + 2 * np.pi)).max() > 2.5 or np.diff(angle).min() < 0.05:
        angle = np.sort(rng.uniform(0, 2 * np.pi, corners))
    ring = center + rng.uniform(low, high, corners)[:, None] * np.column_stack([np.cos(angle), np.sin(angle)])
    return tuple(map(tuple, ring))


def a_building_with_a_courtyard(rng: Rng) -> Obstacle:
    center, base = rng.uniform(-10, 10, 2), rng.uniform(-20, 10)
    outer = a_ring(rng, int(rng.integers(4, 12)), 14, 20, center)
    holes = (a_ring(rng, int(rng.integers(4, 7)), 1, 3.5, center),) if rng.random() < 0.7 else ()
    return Prism("hall", outer, holes, base, base + rng.uniform(1, 30))


KINDS: dict[str, Callable[[Rng], Obstacle]] = {
    "sphere": a_sphere,
    "cylinder": a_cylinder,
    "box": a_box,
    "prism": a_building_with_a_courtyard,
}
every_kind = pytest.mark.parametrize("kind", KINDS)


def a_leg(rng: Rng) -> tuple[np.ndarray, np.ndarray]:
    """Any leg, or one that is level, vertical, along an axis, or a point."""
    a, b = rng.uniform(-35, 35, (2, 3))
    match rng.integers(8):
        case 0:
            b[2] = a[2]
        case 1:
            b[:2] = a[:2]
        case 2:
            b[1:] = a[1:]
        case 3:
            b = a.copy()
        case _:
            pass
    return a, b


@pytest.mark.parametrize("scenes", [300, pytest.param(3000, marks=pytest.mark.long)])
@every_kind
def test_the_least_distance_of_a_leg_is_what_dense_sampling_closes_in_on(kind: str, scenes: int) -> None:
    rng, inside = np.random.default_rng(3), 0
    for _ in range(scenes):
        body, (a, b) = KINDS[kind](rng), a_leg(rng)
        least, where = body.leg_clearance(a, b)
        span = np.linspace(0.0, 1.0, 101)
        for _ in range(4):  # closes in: a 25th of the step each time
            sampled = body.distance(a + span[:, None] * (b - a))
            assert least <= sampled.min() + 1e-9
            center, half = span[np.argmin(sampled)], 2 * (span[1] - span[0])
            span = np.clip(np.linspace(center - half, center + half, 101), 0.0, 1.0)
        assert least >= sampled.min() - 1e-3 or _second_valley(body, a, b, least)
        assert 0 <= where <= 1
        assert body.distance((a + where * (b - a))[None])[0] == pytest.approx(least, abs=1e-9)
        inside += least < 0
    assert 0.025 < inside / scenes < 0.975  # both kinds of scene were met


def test_a_leg_is_deepest_at_a_balance_of_a_polygon_s_sides() -> None:
    """Machine code and plain Python give the same parameters; places between them are not farther inside."""
    from ipoa_mission.world._polygon import balance

    plain, rng = as_plain_python("ipoa_mission.world._polygon"), np.random.default_rng(8)
    for trial in range(60):
        corners = 3 + trial % 14
        angles = 2 * np.pi * (np.arange(corners) + rng.uniform(0, 0.4, corners)) / corners
        ring = rng.uniform(4, 30, corners)[:, None] * np.column_stack([np.cos(angles), np.sin(angles)])
        starts, ends = ring, np.roll(ring, -1, axis=0)
        a, b = rng.uniform(-25, 25, (2, 2)) if trial % 6 else np.zeros((2, 2))
        height, climb = rng.uniform(-6, 6, 2)
        walls = np.array([[height**2, 2 * height * climb, climb**2]] if trial % 3 else np.zeros((0, 3)))
        for inside in (True, False):
            found = balance(starts, ends, walls, a, b, inside)
            np.testing.assert_allclose(plain.balance(starts, ends, walls, a, b, inside), found, rtol=1e-6, atol=1e-9)
            depths = []
            for shares in (found[(found >= 0) & (found <= 1)], np.linspace(0, 1, 2001)):
                spots = a + shares[:, None] * (b - a)
                sides = np.sqrt(np.maximum(np.vander(shares, 3, increasing=True) @ walls.T, 0.0))
                away = Polygon(tuple(map(tuple, ring.tolist()))).distance(spots) * (-1 if inside else 1)
                depths.append(float(np.minimum(away, sides.min(axis=1, initial=np.inf)).max()))
            assert depths[0] >= depths[1] - 1e-6 or depths[1] <= 0.0


def test_a_prism_is_as_far_by_machine_code_as_by_plain_python() -> None:
    plain, rng = as_plain_python("ipoa_mission.world.obstacles._prism"), np.random.default_rng(6)
    for _ in range(60):
        body, (a, b) = a_building_with_a_courtyard(rng), a_leg(rng)
        assert isinstance(body, Prism)
        plan = body.footprint
        expected = plain.nearest(*plan.edges, body.base, body.top, a, b)
        if expected[0] > 0:
            assert body.leg_clearance(a, b) == pytest.approx(expected, abs=1e-9)


def _second_valley(body: Obstacle, a: np.ndarray, b: np.ndarray, least: float) -> bool:
    """Return whether a finer sampling finds a neighboring valley."""
    sampled = body.distance(a + np.linspace(0.0, 1.0, 200_001)[:, None] * (b - a)).min()
    return bool(abs(sampled - least) < 1e-3)


@every_kind
def test_distance_is_to_the_nearest_point_of_the_surface(kind: str) -> None:
    """The ball that just reaches the surface is on one side of it, and touches it."""
    rng = np.random.default_rng(5)
    for _ in range(50):
        body = KINDS[kind](rng)
        points = rng.uniform(-35, 35, (20, 3))
        distance = body.distance(points)
        directions = rng.normal(size=(400, 3))
        directions /= np.linalg.norm(directions, axis=1)[:, None]
        for point, d in zip(points, distance, strict=True):
            around = body.distance(point + directions * abs(d))
            assert (np.sign(around) * np.sign(d) >= 0).all() or np.abs(around[around * d < 0]).max() < 1e-9
            assert np.abs(around).min() < 0.25 * abs(d)  # and somewhere on that ball is the surface


@every_kind
def test_distance_changes_by_a_meter_a_meter_at_most(kind: str) -> None:
    rng = np.random.default_rng(6)
    for _ in range(100):
        body = KINDS[kind](rng)
        a, b = rng.uniform(-35, 35, (2, 200, 3))
        assert (np.abs(body.distance(a) - body.distance(b)) <= np.linalg.norm(a - b, axis=1) + 1e-9).all()


@every_kind
def test_the_box_around_an_obstacle_holds_it_tightly(kind: str) -> None:
    rng = np.random.default_rng(7)
    for _ in range(50):
        body = KINDS[kind](rng)
        lower, upper = body.bounds
        points = rng.uniform(lower - 5, upper + 5, (2000, 3))
        beyond = ((points < lower) | (points > upper)).any(axis=1)
        assert (body.distance(points[beyond]) > 0).all()
        assert (body.distance(points) <= 0).any()


def test_a_footprint_agrees_with_shapely() -> None:
    plain, rng = as_plain_python("ipoa_mission.world._polygon"), np.random.default_rng(8)
    for _ in range(200):
        hall = a_building_with_a_courtyard(rng)
        assert isinstance(hall, Prism)
        spots = rng.uniform(-35, 35, (100, 2))
        shape, points = hall.footprint.shape, shapely.points(spots)
        expected = shapely.distance(shape, points) - np.where(
            shapely.contains_xy(shape, spots), shapely.distance(shape.boundary, points), 0.0
        )
        np.testing.assert_allclose(hall.footprint.distance(spots), expected, atol=1e-9)
        again = plain.distances(*hall.footprint.edges, spots)
        np.testing.assert_array_equal(hall.footprint.distance(spots), again)


def test_a_round_footprint_with_many_corners_is_solved_in_its_middle_too() -> None:
    angle = np.linspace(0, 2 * np.pi, 200, endpoint=False)
    tower = Prism("tower", tuple(zip(10 * np.cos(angle), 10 * np.sin(angle), strict=True)), (), -50.0, 50.0)
    least, where = tower.leg_clearance(np.array([-20.0, 0.0, 0.0]), np.array([20.0, 0.0, 0.0]))
    assert least == pytest.approx(-10 * np.cos(np.pi / 200), abs=1e-9)
    assert where == pytest.approx(0.5)


def test_a_courtyard_is_free_and_its_walls_are_near() -> None:
    ring = ((-10.0, -10.0), (10.0, -10.0), (10.0, 10.0), (-10.0, 10.0))
    yard = ((-4.0, -4.0), (4.0, -4.0), (4.0, 4.0), (-4.0, 4.0))
    hall = Prism("hall", ring, (yard,), 0.0, 20.0)
    down = hall.leg_clearance(np.array([1.0, 0.0, 40.0]), np.array([1.0, 0.0, 5.0]))
    assert down[0] == pytest.approx(3.0)
    assert hall.distance(np.array([[7.0, 0.0, 5.0]]))[0] == pytest.approx(-3.0)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Sphere("s", (0, 0, 0), 0.0), "s.radius: expected a positive number of meters, not 0"),
        (lambda: Cylinder("c", 0, 0, 1, 5, 5), "c.top - base: expected a positive number of meters, not 0"),
        (lambda: Prism("p", ((0, 0), (1, 1)), (), 0, 1), "p: a polygon: expected at least 3 corners, not 2"),
        (lambda: Prism("p", ((0, 0), (1, 1), (1, 0), (0, 1)), (), 0, 1), "p: a polygon: expected rings that do not"),
    ],
)
def test_an_impossible_body_is_refused(make: Callable[[], Obstacle], message: str) -> None:
    with pytest.raises(BadInput) as refusal:
        make()
    assert str(refusal.value).startswith(message)


def test_a_corner_given_twice_is_one_corner() -> None:
    square, twice = ((0, 0), (4, 0), (4, 4), (0, 4)), ((0, 0), (4, 0), (4, 0), (4, 4), (0, 4), (0, 0))
    points = np.random.default_rng(1).uniform(-3, 7, (50, 3))
    plain, doubled = Prism("yard", square, (), 0.0, 5.0), Prism("yard", twice, (), 0.0, 5.0)
    np.testing.assert_array_equal(doubled.distance(points), plain.distance(points))
    assert doubled.convex
    assert doubled.leg_clearance(points[0], points[1]) == plain.leg_clearance(points[0], points[1])


@every_kind
def test_legs_next_to_nothing_off_an_axis_are_as_those_along_it(kind: str) -> None:
    rng = np.random.default_rng(8)
    for _ in range(50):
        body = KINDS[kind](rng)
        for axis in range(3):
            a, b = (x * np.eye(3)[axis] for x in rng.uniform(-40, 40, 2))
            least, _ = body.leg_clearance(a + rng.choice([-1, 1], 3) * 1e-319, b + rng.choice([-1, 1], 3) * 2e-319)
            assert least == pytest.approx(body.leg_clearance(a, b)[0], abs=1e-9)


@pytest.mark.parametrize("kind", KINDS)
def test_arrays_for_compiled_code_describe_the_obstacle(kind: str) -> None:
    parts = KINDS[kind](np.random.default_rng(3)).parts
    assert parts
    for part in parts:
        middle = part.bounds.mean(axis=0)
        outer = np.vstack(part.outline())
        row = part.grid_row()
        assert np.linalg.norm(outer - middle[:2], axis=1).max() <= row.plan_radius + 1e-9
        if row.kind == SPHERE:
            assert row.numbers[:3] == pytest.approx(middle)
            assert row.numbers[3] == row.plan_radius
        else:
            assert row.numbers[3:] == pytest.approx(part.bounds[:, 2])
            assert len(row.edges) == (0 if row.kind == CYLINDER else len(outer))


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("kind", KINDS)
def test_a_shadow_is_as_wide_and_as_high_as_the_body(kind: str, seed: int) -> None:
    body = KINDS[kind](np.random.default_rng(seed))
    assert body.solid
    for axis in (0, 1):
        shadow = body.silhouette(axis)
        np.testing.assert_allclose([shadow.min(axis=0), shadow.max(axis=0)], body.bounds[:, [axis, 2]])


def test_zone_has_no_solid_part() -> None:
    zone = Zone("zone", ((0, 0), (9, 0), (9, 9)), (), 0.0, 5.0)
    assert not zone.solid
    assert zone != Prism("zone", zone.outer, (), 0.0, 5.0)


@pytest.mark.parametrize("number", [np.nan, np.inf])
def test_an_obstacle_has_finite_numbers(number: float) -> None:
    """One at NaN was as far as infinity from each path."""
    for make in (
        lambda: Sphere("body", (number, 0.0, 0.0), 1.0),
        lambda: Cylinder("body", number, 0.0, 1.0, 0.0, 1.0),
        lambda: Cylinder("body", 0.0, 0.0, 1.0, 0.0, number),
        lambda: Prism("body", ((0.0, 0.0), (1.0, 0.0), (0.0, 1.0)), (), -number, 1.0),
    ):
        with refuses("bad-input", "body"):
            make()
