import random
from pathlib import Path

import pytest

from tests.maps.map_scenes import Row
from tests.maps.mutated_maps import lost, tries

SQUARE = [[8.0, 47.0], [8.001, 47.0], [8.001, 47.001], [8.0, 47.001], [8.0, 47.0]]


def test_no_change_is_lost_without_a_word() -> None:
    assert [loss for _, loss in tries(60, seed=39) if loss is not None] == []


@pytest.mark.long
def test_no_change_of_many_is_lost_without_a_word() -> None:
    assert [loss for _, loss in tries(400, seed=40) if loss is not None] == []


def test_a_quiet_loss_is_found(tmp_path: Path) -> None:
    house: Row = ({"type": "Polygon", "coordinates": [SQUARE]}, {"building": "yes", "height": "30"})
    lower: Row = (house[0], {"building": "yes", "height": "9"})
    path = tmp_path / "map.geojson"
    assert lost([house], [lower], path, None, random.Random(1)) is not None
    assert lost([lower], [house], path, None, random.Random(1)) is None
