import shapely

from ipoa_mission.maps.planar import polygons_of
from tests.refused import refuses

SQUARE = shapely.Polygon([(0, 0), (9, 0), (9, 9), (0, 9)])
TWICE = shapely.Polygon([(0, 0), (9, 0), (9, 0), (9, 9), (0, 9)])
BOW = shapely.Polygon([(0, 0), (9, 9), (9, 0), (0, 9)])
FLAT = shapely.Polygon([(0, 0), (9, 0), (4, 0)])


def test_a_polygon_is_mended_and_the_defect_named() -> None:
    (square,), wrong = polygons_of(TWICE, "map")
    assert (square.wkb, wrong) == (SQUARE.wkb, None)
    halves, wrong = polygons_of(BOW, "map")
    assert (len(halves), wrong) == (2, "a ring with self-intersection")
    with refuses("invalid-ring", "map.geometry"):
        polygons_of(FLAT, "map")


def test_a_ring_that_is_all_in_one_place_is_none() -> None:
    """GEOS fails on its repeated corners."""
    spot = [(5.0, 5.0)] * 4
    field, holed = (
        shapely.box(0.0, 0.0, 10.0, 10.0),
        shapely.Polygon(shapely.box(0.0, 0.0, 10.0, 10.0).exterior, [spot]),
    )
    (part,), _ = polygons_of(holed, "map[1]")
    assert part.equals(field)
    with refuses("invalid-ring", "map[2].geometry"):
        polygons_of(shapely.Polygon(spot), "map[2]")
