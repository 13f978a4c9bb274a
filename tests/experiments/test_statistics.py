"""The statistics, held against published numbers and textbook cases."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ipoa_mission.experiments.statistics import friedman, holm, places, rank_sum


def test_thirty_against_thirty_without_overlap_is_the_number_of_table_4() -> None:
    assert rank_sum(range(30), range(30, 60)) == pytest.approx(3.0198e-11, rel=1e-4)


def test_equal_samples_are_not_told_apart() -> None:
    assert rank_sum([1.0] * 5, [1.0] * 5) == 1
    assert rank_sum([1, 2, 3, 4], [1, 2, 3, 4]) == 1


def test_holm_is_the_textbook_case() -> None:
    """Holm 1979's steps: the smallest times m, the next times m - 1, never falling."""
    assert holm([0.01, 0.04, 0.03, 0.005]) == pytest.approx([0.03, 0.06, 0.06, 0.02])


@given(st.lists(st.floats(0, 1), min_size=1, max_size=20))
def test_holm_lies_between_no_correction_and_bonferronis(p: list[float]) -> None:
    for raw, corrected in zip(p, holm(p), strict=True):
        assert raw - 1e-12 <= corrected <= min(1, len(p) * raw) + 1e-12


def test_friedman_is_the_textbook_case() -> None:
    """Hollander and Wolfe's rounding-first-base times: 22 runners, three ways, statistic 11.14."""
    times = np.array(
        [
            [5.40, 5.50, 5.55],
            [5.85, 5.70, 5.75],
            [5.20, 5.60, 5.50],
            [5.55, 5.50, 5.40],
            [5.90, 5.85, 5.70],
            [5.45, 5.55, 5.60],
            [5.40, 5.40, 5.35],
            [5.45, 5.50, 5.35],
            [5.25, 5.15, 5.00],
            [5.85, 5.80, 5.70],
            [5.25, 5.20, 5.10],
            [5.65, 5.55, 5.45],
            [5.60, 5.35, 5.45],
            [5.05, 5.00, 4.95],
            [5.50, 5.50, 5.40],
            [5.45, 5.55, 5.50],
            [5.55, 5.55, 5.35],
            [5.45, 5.50, 5.55],
            [5.50, 5.45, 5.25],
            [5.65, 5.60, 5.40],
            [5.70, 5.65, 5.55],
            [6.30, 6.30, 6.25],
        ]
    )
    result = friedman(times)
    assert result.statistic == pytest.approx(11.1429, abs=1e-4)
    assert result.p == pytest.approx(0.003805, abs=1e-6)
    assert result.mean_ranks.sum() == pytest.approx(6)


def test_places_share_the_better_one() -> None:
    assert places([3.0, 1.0, 1.0, 2.0]) == [4, 1, 1, 3]
