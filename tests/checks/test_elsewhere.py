from dataclasses import replace
from pathlib import Path

from ipoa_mission.autopilot.autopilot import Autopilot
from ipoa_mission.checks.check import check_mission
from ipoa_mission.flight.preflight import expect_fit
from ipoa_mission.geodesy import Geodetic
from ipoa_mission.mission.items import Item, Mission, return_to_launch, takeoff, waypoint
from ipoa_mission.mission.positions import home_elsewhere, refusals
from ipoa_mission.report.exports import write_export
from ipoa_mission.simulator.fly import board
from tests.refused import refuses

AUSTRALIA, JAPAN = Geodetic(-35.363, 149.165, 584.0), Geodetic(36.319, 138.650, 900.0)
HERE = Item(22, 3, altitude=25.0)  # a take-off names no place
IN_JAPAN = Mission(AUSTRALIA, (HERE, waypoint(JAPAN, 25.0), return_to_launch()), Autopilot.ARDUPILOT)


def test_a_home_far_from_all_items_is_a_warning_and_stops_an_export(tmp_path: Path) -> None:
    (finding,) = check_mission(IN_JAPAN)
    assert "it lies 8010 km from all places" in finding.message
    assert refusals(IN_JAPAN) == (finding.message,)
    with refuses("home-elsewhere", "", "8010 km"):
        write_export(IN_JAPAN, tmp_path / "japan.kml")


def test_places_far_from_each_other_are_errors() -> None:
    apart = replace(IN_JAPAN, items=(HERE, waypoint(JAPAN, 25.0), waypoint(AUSTRALIA, 25.0), return_to_launch()))
    assert home_elsewhere(apart) is None
    assert "expected a position within 100 km of home, not 8010 km" in refusals(apart)[0]
    assert home_elsewhere(replace(IN_JAPAN, items=(HERE, return_to_launch()))) is None
    assert home_elsewhere(replace(IN_JAPAN, autopilot=Autopilot.PX4)) is None
    assert home_elsewhere(replace(IN_JAPAN, items=(takeoff(AUSTRALIA, 9.0), *IN_JAPAN.items[1:]))) is not None


def test_a_vehicle_that_stands_far_from_all_places_is_refused() -> None:
    over_terrain = replace(IN_JAPAN, items=(HERE, replace(waypoint(JAPAN, 25.0), frame=10), return_to_launch()))
    with board(over_terrain) as vehicle:  # in Australia
        with refuses("unsafe", "", "8010"):
            expect_fit(vehicle, over_terrain)
        assert any("8010 km" in words for words in expect_fit(vehicle, over_terrain, anyway=True))
