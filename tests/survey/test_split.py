from itertools import combinations, pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ipoa_mission.geometry import polyline_length
from ipoa_mission.survey.tour import Swath, Tour, fewest_parts, parts_of_equal_length
from tests.refused import refuses


def tour_of(lengths: list[float]) -> Tour:
    """Lines to and fro, 10 m apart, the first of them 50 m from home."""
    swaths = []
    for n, length in enumerate(lengths):
        ends = np.array([[50.0, 10.0 * n], [50.0 + length, 10.0 * n]])[:: 1 if n % 2 == 0 else -1]
        swaths.append(Swath(*ends))
    return Tour.of(swaths, [np.array([a.end, b.begin]) for a, b in pairwise(swaths)])


def path_length(tour: Tour) -> float:
    return float(np.linalg.norm(tour.path[0]) + polyline_length(tour.path) + np.linalg.norm(tour.path[-1]))


def every_split(tour: Tour, count: int) -> list[tuple[Tour, ...]]:
    n = len(tour.swaths)
    borders = [(0, *inner, n) for inner in combinations(range(1, n), count - 1)]
    return [tuple(tour.part(a, b) for a, b in pairwise(border)) for border in borders]


LENGTHS = st.lists(st.floats(20.0, 200.0), min_size=1, max_size=8)


@given(LENGTHS, st.floats(300.0, 1200.0))
def test_no_other_cut_between_lines_makes_fewer_flights(lengths: list[float], most: float) -> None:
    tour = tour_of(lengths)

    def fits(part: Tour) -> bool:
        return path_length(part) <= most

    if not all(fits(tour.part(n, n + 1)) for n in range(len(lengths))):
        return
    parts = [*fewest_parts(tour, fits, 5.0)]
    assert all(fits(part) for part in parts)
    assert sum(len(part.swaths) for part in parts) == len(lengths)
    fewer = every_split(tour, len(parts) - 1) if len(parts) > 1 else []
    assert not any(all(map(fits, split)) for split in fewer)


@given(LENGTHS, st.integers(1, 4))
def test_flights_of_equal_length_have_the_shortest_longest_one(lengths: list[float], count: int) -> None:
    tour = tour_of(lengths)
    if count > len(lengths):
        return
    parts = parts_of_equal_length(tour, count)
    assert len(parts) == count
    assert np.concatenate([part.lines for part in parts]).tolist() == tour.lines.tolist()
    best = min(max(map(path_length, split)) for split in every_split(tour, count))
    assert max(map(path_length, parts)) == pytest.approx(best)


def test_a_line_too_long_for_one_flight_is_cut_and_seen_again_at_the_cut() -> None:
    swaths = Swath(np.array([-200.0, 0.0]), np.array([200.0, 0.0])), Swath(np.array([60.0, 9.0]), np.array([20.0, 9.0]))
    tour = Tour.of(swaths, [np.array([swaths[0].end, swaths[1].begin])])
    parts = fewest_parts(tour, lambda part: path_length(part) <= 500.0, 8.0)
    *pieces, last = [swath for part in parts for swath in part.swaths]
    assert last.ends.tolist() == swaths[1].ends.tolist()
    assert (pieces[0].begin[0], pieces[-1].end[0]) == pytest.approx((-200.0, 200.0))
    assert all(after.begin[0] == pytest.approx(before.end[0] - 8.0) for before, after in pairwise(pieces))
    assert len(pieces) > 1


def test_unreachable_parts_are_named() -> None:
    tour = tour_of([60.0])
    with refuses("not-enough-battery", "battery", "50", "0"):
        list(fewest_parts(tour, lambda part: path_length(part) < 50.0, 5.0))
