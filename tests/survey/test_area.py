"""What is refused as an area, and by which place the message names it."""

import math

import pytest

from ipoa_mission.errors import BadInput
from ipoa_mission.survey.area import Area

SQUARE = [(0.0, 0.0), (100.0, 0.0), (100.0, 100.0), (0.0, 100.0)]


def square(west: float, south: float, side: float) -> list[tuple[float, float]]:
    return [(west, south), (west + side, south), (west + side, south + side), (west, south + side)]


@pytest.mark.parametrize(
    ("parts", "words"),
    [
        ([], "field: expected one polygon"),
        ([[]], r"field\[0\]: expected a ring"),
        ([[[(0.0, 0.0), (1.0, 0.0)]]], r"field\[0\]\[0\]: expected three corners or more, not 2"),
        ([[[(0.0, 0.0), (9.0, 0.0), (0.0, 0.0)]]], r"field\[0\]\[0\]: expected three corners or more, not 2"),
        ([[[(0.0, 0.0), (9.0, math.nan), (9.0, 9.0)]]], r"field\[0\]\[0\]\[1\]: expected finite"),
        ([[[(0.0, 0.0), (9.0, 0.0), (9.0, 0.0), (9.0, 9.0)]]], r"field\[0\]\[0\]\[2\]: expected another corner"),
        ([[[(0.0, 0.0), (9.0, 9.0), (9.0, 0.0), (0.0, 9.0)]]], r"field\[0\]\[0\]: .*cross.*\[4.5 4.5\]"),
        ([[[(0.0, 0.0), (5.0, 5.0), (9.0, 9.0)]]], r"field\[0\]\[0\]: .*one line"),
        ([[[(0.0, 0.0), ("a", 5.0), (9.0, 9.0)]]], r"field\[0\]\[0\]: expected corners as pairs"),
        ([[[(0.0, 0.0, 1.0), (9.0, 5.0, 1.0), (9.0, 9.0, 1.0)]]], r"field\[0\]\[0\]: expected corners as pairs"),
        ([[SQUARE, square(-10.0, -10.0, 200.0)]], r"field\[0\]: .*cover all"),
        ([[SQUARE, square(200.0, 0.0, 10.0)]], r"field\[0\]\[1\]: .*lies outside"),
        ([[SQUARE, square(10.0, 10.0, 50.0), square(20.0, 20.0, 10.0)]], r"field\[0\]\[2\]: .*islands"),
        ([[SQUARE, square(10.0, 10.0, 50.0)], [square(20.0, 20.0, 10.0)]], r"field\[1\]: .*islands"),
        ([[SQUARE, [(40.0, -9.0), (60.0, -9.0), (60.0, 109.0), (40.0, 109.0)]]], r"field\[0\]: .*holes cut it"),
        ([[SQUARE], [square(50.0, 50.0, 100.0)]], r"field\[1\]: .*overlaps field\[0\]"),
    ],
)
def test_what_is_no_area_is_named(parts: list[list[list[tuple[float, float]]]], words: str) -> None:
    with pytest.raises(BadInput, match=words):
        Area.of(parts, "field")


def test_rings_may_be_closed_and_turn_either_way() -> None:
    there, back = Area.of([[[*SQUARE, SQUARE[0]]]]), Area.of([[SQUARE[::-1]]])
    assert there.shape.area == back.shape.area == 10_000.0
