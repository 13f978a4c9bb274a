import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ipoa_mission.paper.statistics import compare_pairs, holm, places, post_hoc, rank_sum


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


def test_control_is_compared_after_friedman_as_in_demsar_s_example() -> None:
    """Table 6 and section 3.2.2: C4.5 against its three variants over 14 data sets, z of 2.416, 2.342, 0.512."""
    itself, m, cf, both = post_hoc(np.array([3.143, 2.000, 2.893, 1.964]), 14, 0)
    assert itself == 1
    assert both == pytest.approx(3 * 0.0157, abs=2e-4)
    assert m == pytest.approx(both, abs=1e-12)  # Holm's p never fall, as twice 0.0192 would
    assert cf == pytest.approx(0.609, abs=2e-3)


def test_the_sign_says_who_is_lower_and_only_where_it_is_told() -> None:
    low, high, alike = np.arange(30.0), np.arange(40.0, 70.0), np.arange(0.5, 30.5)
    assert compare_pairs([(low, high), (high, low), (low, alike)]) == ["+", "-", "="]


def test_places_share_the_better_one() -> None:
    assert places([3.0, 1.0, 1.0, 2.0]) == [4, 1, 1, 3]
