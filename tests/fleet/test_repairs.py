"""Changes of a mission: heights and holds."""

import math
from dataclasses import replace

import pytest

from ipoa_mission import Command, Mission
from ipoa_mission.fleet.repairs import RepairLimits, held, raised
from tests.fleet.crossings import eastward, northward, route


@pytest.mark.parametrize(
    "mission", [eastward("px4"), northward("ardupilot"), route("px4", (0, 0), (60, 0), returns=True)]
)
def test_whole_route_is_raised_but_for_its_landing(mission: Mission) -> None:
    higher = raised(mission, 10.0, 120.0)
    assert higher is not None
    for before, after in zip(mission.items, higher.items, strict=True):
        lands = before.command in (Command.NAV_LAND, Command.NAV_RETURN_TO_LAUNCH)
        is_raised = before.moves and not lands
        assert after == replace(before, altitude=before.altitude + (10.0 if is_raised else 0.0))


def test_no_route_is_raised_above_the_greatest_height() -> None:
    assert raised(eastward(), 100.0, 120.0) is not None
    assert raised(eastward(), 100.5, 120.0) is None


def test_an_item_at_the_present_height_forbids_to_raise() -> None:
    """ArduPilot flies an item of altitude 0 at the height at which it is."""
    mission = northward("ardupilot")
    items = [replace(item, altitude=0.0) if item.is_waypoint else item for item in mission.items]
    assert raised(replace(mission, items=tuple(items)), 10.0, 120.0) is None


def test_an_item_without_a_place_forbids_to_raise() -> None:
    mission = eastward()
    climb = replace(mission.items[2], command=Command.NAV_CONTINUE_AND_CHANGE_ALT, latitude_deg=0.0, longitude_deg=0.0)
    assert raised(replace(mission, items=(*mission.items[:3], climb, *mission.items[3:])), 10.0, 120.0) is None


@pytest.mark.parametrize(("most_delay_s", "delays"), [(0.0, [0.0]), (0.2, [0.0]), (2.0, [0.0, 1.0, 2.0])])
def test_no_departure_is_delayed_by_more_than_the_longest_delay(most_delay_s: float, delays: list[float]) -> None:
    assert RepairLimits(0.001, most_delay_s).delays.tolist() == delays


def test_hold_lengthens_that_of_its_item_only() -> None:
    mission = eastward()
    longer = held(mission, 3, 7.0)
    assert longer.items[2].params[0] == pytest.approx(mission.items[2].params[0] + 7.0)
    assert longer.items[:2] + longer.items[3:] == mission.items[:2] + mission.items[3:]


def test_hold_of_an_item_without_one_is_as_long_as_the_repair() -> None:
    mission = eastward()
    without = replace(mission.items[2], params=(math.nan, *mission.items[2].params[1:]))
    mission = replace(mission, items=(*mission.items[:2], without, *mission.items[3:]))
    assert held(mission, 3, 7.0).items[2].params[0] == 7.0
