import numpy as np
import shapely

from ipoa_mission.maps.planar import clean_polygons, polygons_of
from tests.refused import refuses

SQUARE = shapely.Polygon([(0, 0), (9, 0), (9, 9), (0, 9)])
TWICE = shapely.Polygon([(0, 0), (9, 0), (9, 0), (9, 9), (0, 9)])
BOW = shapely.Polygon([(0, 0), (9, 9), (9, 0), (0, 9)])
FLAT = shapely.Polygon([(0, 0), (9, 0), (4, 0)])
OTHERS = [shapely.MultiPolygon([SQUARE]), shapely.LineString(SQUARE.exterior), shapely.Point(0, 0), shapely.Polygon()]


def test_polygons_found_sound_together_are_those_that_each_makes_alone() -> None:
    shapes = np.array([SQUARE, TWICE, BOW, FLAT, *OTHERS], dtype=object)
    clean, sound = clean_polygons(shapes)
    assert sound.tolist() == [True, True, *[False] * 6]
    for shape, alone in zip(clean[:2], shapes[:2], strict=True):
        polygons, wrong = polygons_of(alone, "map")
        assert wrong is None
        assert [polygon.wkb for polygon in polygons] == [shape.wkb]
    assert all(kept is original for kept, original in zip(clean[2:], shapes[2:], strict=True))


def test_a_ring_that_is_all_in_one_place_is_none() -> None:
    """GEOS fails on its repeated corners."""
    spot = [(5.0, 5.0)] * 4
    field, holed = (
        shapely.box(0.0, 0.0, 10.0, 10.0),
        shapely.Polygon(shapely.box(0.0, 0.0, 10.0, 10.0).exterior, [spot]),
    )
    shapes = np.array([field, holed, shapely.Polygon(spot)])
    assert clean_polygons(shapes)[1].tolist() == [True, False, False]
    (part,), _ = polygons_of(holed, "map[1]")
    assert part.equals(field)
    with refuses("invalid-ring", "map[2].geometry"):
        polygons_of(shapes[2], "map[2]")
