"""Items that PX4 1.18 and ArduCopter 4.8 fly otherwise than they are listed, as read in their sources."""

from collections.abc import Sequence
from dataclasses import replace

import pytest

from ipoa_mission import check_mission, estimate
from ipoa_mission.autopilot.autopilot import autopilot_named
from ipoa_mission.autopilot.commands import Command, Frame
from ipoa_mission.geodesy import Geodetic
from ipoa_mission.mission.items import FenceCircle, Item, Mission
from tests.finding_codes import codes_of

HOME = Geodetic(47.0, 8.0, 500.0)
PLACE = (47.0009, 8.0, 20.0)
UP = Item(Command.NAV_TAKEOFF, Frame.GLOBAL_RELATIVE_ALT, (0.0,) * 4, 47.0, 8.0, 20.0)
THERE = Item(Command.NAV_WAYPOINT, Frame.GLOBAL_RELATIVE_ALT, (1.0, 0.0, 0.0, 0.0), *PLACE)
LAND = Item(Command.NAV_LAND, Frame.GLOBAL_RELATIVE_ALT, (0.0,) * 4, *PLACE[:2], 0.0)
RTL = Item(Command.NAV_RETURN_TO_LAUNCH, Frame.MISSION)
AGAIN = replace(UP, latitude_deg=PLACE[0], longitude_deg=PLACE[1])


def act(command: int, *params: float) -> Item:
    return Item(command, Frame.MISSION, (*params, 0.0, 0.0, 0.0, 0.0)[:4])  # type: ignore[arg-type]


def codes(autopilot: str, items: Sequence[Item], **parameters: float) -> list[str]:
    mission = Mission(HOME, tuple(items), autopilot_named(autopilot)).with_parameters(parameters)
    return codes_of(check_mission(mission))


@pytest.mark.parametrize(
    ("autopilot", "items", "parameters", "expected"),
    [
        ("ardupilot", (UP, THERE, LAND, AGAIN, RTL), {}, ["warning behind-landing 4"]),
        ("ardupilot", (UP, THERE, LAND, AGAIN, RTL), {"MIS_OPTIONS": 4.0}, []),
        ("ardupilot", (UP, THERE, LAND, act(Command.NAV_DELAY, 5), AGAIN, RTL), {"MIS_OPTIONS": 4.0}, []),
        ("ardupilot", (UP, THERE, LAND, THERE, RTL), {"MIS_OPTIONS": 4.0}, ["warning behind-landing 4"]),
        ("ardupilot", (UP, THERE, RTL, THERE, LAND), {}, ["warning behind-landing 4"]),
        ("ardupilot", (UP, THERE, RTL, AGAIN, LAND), {}, []),
        ("ardupilot", (UP, THERE, RTL, act(Command.DO_SET_RELAY, 0, 1)), {}, []),
        ("px4", (UP, THERE, LAND, AGAIN, RTL), {}, []),
        ("px4", (UP, THERE, RTL, AGAIN, LAND), {}, ["warning behind-landing 4"]),
        ("ardupilot", (UP, THERE, LAND, act(Command.DO_JUMP, 1, 1)), {}, ["warning behind-landing 1"]),
        ("ardupilot", (UP, THERE, LAND, act(Command.DO_JUMP, 1, 1)), {"MIS_OPTIONS": 4.0}, []),
        ("ardupilot", (UP, THERE, act(Command.DO_JUMP, 2, 1), LAND, RTL), {}, ["warning behind-landing 5"]),
        ("px4", (UP, THERE, RTL, act(Command.DO_JUMP, 1, 1)), {}, ["warning behind-landing 1"]),
    ],
)
def test_items_behind_a_landing_that_ends_the_mission_are_reported(
    autopilot: str, items: Sequence[Item], parameters: dict[str, float], expected: list[str]
) -> None:
    assert codes(autopilot, items, **parameters) == expected


def test_the_estimate_says_what_is_not_flown_or_waits() -> None:
    px4 = autopilot_named("px4")
    held = replace(THERE, autocontinue=False)
    (remark,) = estimate(Mission(HOME, (UP, held, THERE, RTL), px4)).remarks
    assert remark == "item 2: the time until an operator goes on is not in the times"
    (remark,) = estimate(Mission(HOME, (UP, THERE, RTL, AGAIN, LAND), px4)).remarks
    assert remark == "item 4: the mission ends at item 3; the times go on"


@pytest.mark.parametrize(("autopilot", "expected"), [("px4", ["warning waits-for-someone 2"]), ("ardupilot", [])])
def test_px4_stays_at_an_item_without_autocontinue(autopilot: str, expected: list[str]) -> None:
    assert codes(autopilot, (UP, replace(THERE, autocontinue=False), THERE, RTL)) == expected


@pytest.mark.parametrize(
    ("autopilot", "item", "expected"),
    [
        ("px4", act(Command.DO_CHANGE_SPEED, 2, 0.5), ["error way-unknown 2"]),
        ("px4", act(Command.DO_CHANGE_SPEED, 3, 8), ["error way-unknown 2"]),
        ("px4", act(Command.DO_CHANGE_SPEED, 0, 5), []),
        ("ardupilot", act(Command.DO_CHANGE_SPEED, 2, 0.5), []),
    ],
)
def test_px4_flies_along_at_a_speed_of_any_kind(autopilot: str, item: Item, expected: list[str]) -> None:
    assert codes(autopilot, (UP, item, THERE, RTL)) == expected


@pytest.mark.parametrize(("precision", "expected"), [(0.0, []), (1.0, []), (2.0, ["error way-unknown 3"])])
def test_px4_searches_the_target_of_a_precision_landing(precision: float, expected: list[str]) -> None:
    assert codes("px4", (UP, THERE, replace(LAND, params=(0.0, precision, 0.0, 0.0)))) == expected


@pytest.mark.parametrize(
    ("condition", "action", "expected"),
    [
        (act(Command.CONDITION_DELAY, 30), act(Command.DO_CHANGE_SPEED, 1, 2), ["error way-unknown 3"]),
        (act(Command.CONDITION_DISTANCE, 30), act(Command.DO_CHANGE_SPEED, 1, 2), ["error way-unknown 3"]),
        (act(Command.CONDITION_DELAY, 30), act(Command.DO_SET_RELAY, 0, 1), []),
    ],
)
def test_a_delayed_change_of_speed_makes_the_way_unknown(condition: Item, action: Item, expected: list[str]) -> None:
    assert codes("ardupilot", (UP, THERE, condition, action, THERE, RTL)) == expected


def test_px4_refuses_a_mission_that_begins_with_a_landing() -> None:
    assert "error takeoff-not-first 1" in codes("px4", (LAND, THERE, RTL))


@pytest.mark.parametrize(
    ("items", "refusing"),
    [
        ((UP, THERE, RTL), {2, 3, 4, 5}),
        ((UP, THERE, LAND), set()),
        ((THERE, LAND), {1, 3, 4}),
        ((THERE,), {1, 2, 3, 5}),
    ],
)
def test_px4_refuses_a_mission_without_the_required_ends(items: Sequence[Item], refusing: set[int]) -> None:
    """As in PX4 1.17 and 1.18, of a vehicle on the ground, without a take-off of one in the air."""
    for required in range(7):
        found = "error ends-refused" in codes("px4", items, MIS_TKO_LAND_REQ=float(required))
        assert found == (required in refusing)
    assert "error ends-refused" not in codes("ardupilot", items)


@pytest.mark.parametrize(("value", "expected"), [(0.0, ["warning fence-off 2"]), (1.0, []), (2.0, [])])
def test_an_item_that_switches_the_fence_off_is_reported(value: float, expected: list[str]) -> None:
    items = (UP, act(Command.DO_FENCE_ENABLE, value), THERE, RTL)
    mission = Mission(HOME, items, autopilot_named("ardupilot"), fence=(FenceCircle((47.0, 8.0), 900.0),))
    assert codes_of(check_mission(mission)) == expected
    assert codes("ardupilot", items) == []
