import math

import pytest

from ipoa_mission.survey.survey_area import Area
from tests.refused import refuses

SQUARE = [(0.0, 0.0), (100.0, 0.0), (100.0, 100.0), (0.0, 100.0)]


def square(west: float, south: float, side: float) -> list[tuple[float, float]]:
    return [(west, south), (west + side, south), (west + side, south + side), (west, south + side)]


@pytest.mark.parametrize(
    ("parts", "words"),
    [
        ([], ("invalid-ring", "field")),
        ([[]], ("invalid-ring", "field[0]")),
        ([[[(0.0, 0.0), (1.0, 0.0)]]], ("invalid-ring", "field[0][0]")),
        ([[[(0.0, 0.0), (9.0, 0.0), (0.0, 0.0)]]], ("invalid-ring", "field[0][0]")),
        ([[[(0.0, 0.0), (9.0, math.nan), (9.0, 9.0)]]], ("invalid-ring", "field[0][0][1]")),
        ([[[(0.0, 0.0), (9.0, 0.0), (9.0, 0.0), (9.0, 9.0)]]], ("invalid-ring", "field[0][0][2]")),
        ([[[(0.0, 0.0), (9.0, 9.0), (9.0, 0.0), (0.0, 9.0)]]], ("invalid-ring", "field[0][0]")),
        ([[[(0.0, 0.0), (5.0, 5.0), (9.0, 9.0)]]], ("invalid-ring", "field[0][0]")),
        ([[[(0.0, 0.0), ("a", 5.0), (9.0, 9.0)]]], ("invalid-ring", "field[0][0]")),
        ([[[(0.0, 0.0, 1.0), (9.0, 5.0, 1.0), (9.0, 9.0, 1.0)]]], ("invalid-ring", "field[0][0]")),
        ([[SQUARE, square(-10.0, -10.0, 200.0)]], ("invalid-ring", "field[0]")),
        ([[SQUARE, square(200.0, 0.0, 10.0)]], ("ring-misplaced", "field[0][1]")),
        ([[SQUARE, square(10.0, 10.0, 50.0), square(20.0, 20.0, 10.0)]], ("ring-misplaced", "field[0][2]")),
        ([[SQUARE, square(10.0, 10.0, 50.0)], [square(20.0, 20.0, 10.0)]], ("ring-misplaced", "field[1]")),
        ([[SQUARE, [(40.0, -9.0), (60.0, -9.0), (60.0, 109.0), (40.0, 109.0)]]], ("invalid-ring", "field[0]")),
        ([[SQUARE], [square(50.0, 50.0, 100.0)]], ("ring-misplaced", "field[1]")),
    ],
)
def test_wrong_areas_are_named(parts: list[list[list[tuple[float, float]]]], words: tuple[str, ...]) -> None:
    with refuses(*words):
        Area.of(parts, "field")


def test_rings_may_be_closed_and_turn_either_way() -> None:
    there, back = Area.of([[[*SQUARE, SQUARE[0]]]]), Area.of([[SQUARE[::-1]]])
    assert there.shape.area == back.shape.area == 10_000.0
