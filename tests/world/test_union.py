from typing import Any

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from ipoa_mission.geometry import union_of
from tests.examples import examples


@settings(max_examples=examples(30))
@given(st.integers(2, 40), st.floats(0.0, 3.1), st.floats(0.5, 30.0))
def test_strips_that_just_meet_are_all_held(count: int, turn: float, width: float) -> None:
    along = np.array([np.cos(turn), np.sin(turn)])
    across = width * np.array([-along[1], along[0]])
    lines = [[n * across, n * across + (100.0 + n) * along] for n in range(count)]
    strips = shapely.buffer(shapely.linestrings(lines), width / 2, cap_style="flat")
    assert union_of(strips).area == pytest.approx(shapely.area(strips).sum(), rel=1e-6)


def test_areas_lost_by_a_union_without_a_grid_are_found(monkeypatch: pytest.MonkeyPatch) -> None:
    """GEOS 3.14 once lost half of forty strips that just met, by the last bits of their corners."""
    union = shapely.union_all

    def losing(areas: Any, grid_size: float | None = None) -> Any:
        return union(areas if grid_size else areas[1:], grid_size=grid_size)

    monkeypatch.setattr(shapely, "union_all", losing)
    assert union_of([shapely.box(0.0, 0.0, 4.0, 1.0), shapely.box(0.0, 1.0, 4.0, 2.0)]).area == pytest.approx(8.0)


def test_empty_union_is_none() -> None:
    assert union_of([]).is_empty
    assert union_of([shapely.Polygon(), shapely.box(0.0, 0.0, 1.0, 1.0)]).area == 1.0
