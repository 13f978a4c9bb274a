import math
from collections.abc import Mapping
from dataclasses import replace

import numpy as np
import pytest

from ipoa_mission.autopilot.autopilot import Autopilot
from ipoa_mission.autopilot.commands import Command, Frame
from ipoa_mission.errors import BadInput
from ipoa_mission.forecast.forecast import estimate
from ipoa_mission.forecast.timing.estimate import Estimate
from ipoa_mission.mission.items import (
    Item,
    Mission,
    change_speed,
    land,
    return_to_launch,
    spline_waypoint,
    takeoff,
    waypoint,
)
from tests.forecast.test_timing_models import BOTH, HOME, lasted, place
from tests.refused import refuses


def at(command: Command, east: float, north: float, height: float = 30.0, *params: float) -> Item:
    spot, four = place(east, north), (*params, *[0.0] * (4 - len(params)))
    return Item(command, Frame.GLOBAL_RELATIVE_ALT, four, spot.latitude_deg, spot.longitude_deg, height)  # type: ignore[arg-type]


def order(command: Command, *params: float) -> Item:
    return Item(command, Frame.MISSION, (*params, *[0.0] * (4 - len(params))))  # type: ignore[arg-type]


def to(east: float, north: float, height: float = 30.0, hold_s: float = 0.0) -> Item:
    return waypoint(place(east, north), height, hold_s)


def bend(east: float, north: float, height: float = 30.0) -> Item:
    return spline_waypoint(place(east, north), height)


ODD: Mapping[str, tuple[Item, ...]] = {
    "the same place four times": (to(0, 50), to(0, 50), to(0, 50), to(0, 50), to(0, 90)),
    "legs of a hand's breadth": tuple(to(0, 0.05 * n) for n in range(1, 12)),
    "back and forth": (to(0, 60), to(0, 0), to(0, 60)),
    "splines over themselves": (bend(50, 0), bend(50, 0), bend(0, 0), bend(0, 0, 60), bend(0, 0, 30), to(0, 40)),
    "a spline into a straight leg and out of one": (bend(30, 0), bend(60, 20), to(120, 20), bend(120, 80), to(0, 80)),
    "only up and down": (to(0, 0, 60), to(0, 0, 20), to(0, 0, 45)),
    "steep": (to(0, 5, 70), to(0, 10, 15)),
    "into the ground": (to(0, 50, 0.0), to(0, 90, -5.0)),
    "speeds without sense": (change_speed(0.0), order(Command.DO_CHANGE_SPEED, 1, math.nan, -1), to(0, 60)),
    "climb and descent speeds": (
        order(Command.DO_CHANGE_SPEED, 2, 1), to(0, 40, 50), order(Command.DO_CHANGE_SPEED, 3, 9), to(0, 80),
    ),
    "radii larger than legs and smaller than errors": (
        at(Command.NAV_WAYPOINT, 0, 60, 30, 0, 50),
        at(Command.NAV_WAYPOINT, 60, 60, 30, 0, 0.1),
        to(0, 0),
    ),
    "params without numbers": (at(Command.NAV_WAYPOINT, 0, 60, 30, math.nan, math.nan, math.nan, math.nan), to(0, 90)),
    "circles": (
        at(Command.NAV_LOITER_TURNS, 0, 60, 30, 2, 0, 0), at(Command.NAV_LOITER_TO_ALT, 0, 60, 50, 1, 20), to(0, 90),
    ),
    "conditions": (
        order(Command.CONDITION_DELAY, 10), order(Command.CONDITION_YAW, 90, 20, 1), change_speed(3.0), to(0, 60),
    ),
    "jumps in jumps": (to(0, 30), to(30, 30), order(Command.DO_JUMP, 2, 1), order(Command.DO_JUMP, 2, 1), to(0, 0)),
    "down and up again": (to(0, 50), land(place(0, 50)), takeoff(HOME, 20.0), to(0, 90), return_to_launch(), to(0, 40)),
    "nothing it knows": (
        Item(90, Frame.MISSION), Item(999, Frame.MISSION), order(Command.NAV_SCRIPT_TIME, 1, 9), to(0, 30),
    ),
    "nothing else": (),
}  # fmt: skip


def predicted(autopilot: Autopilot, *items: Item, first: tuple[Item, ...] = (takeoff(HOME, 30.0),)) -> Estimate:
    return estimate(Mission(HOME, (*first, *items), autopilot))


@BOTH
@pytest.mark.parametrize(
    "first", [(takeoff(HOME, 30.0),), pytest.param((), marks=pytest.mark.long)], ids=["from the ground", "in the air"]
)
@pytest.mark.parametrize("name", ODD)
def test_odd_missions_have_a_time_like_any_other(autopilot: Autopilot, name: str, first: tuple[Item, ...]) -> None:
    result = predicted(autopilot, *ODD[name], first=first)
    assert all(math.isfinite(item.duration_s) and item.duration_s >= 0 for item in result.items)
    assert all(0 <= item.low_s <= item.done_s <= item.high_s for item in result.items)
    assert np.isfinite(result.track.points).all()
    assert (np.diff(result.track.times) >= 0).all()
    assert result.total_s < 60.0 + 3 * sum(60.0 for _ in result.items)


@pytest.mark.parametrize("frame", [Frame.GLOBAL_RELATIVE_ALT, Frame.GLOBAL_TERRAIN_ALT])
def test_a_loiter_to_a_height_over_terrain_may_be_passed_over(frame: Frame) -> None:
    """ArduCopter, with a range finder and without terrain data: "bad do_loiter_to_alt"."""
    item = replace(at(Command.NAV_LOITER_TO_ALT, 0, 60, 50), frame=frame)
    is_skipped = any("skips it" in remark for remark in predicted(Autopilot.ARDUPILOT, item, to(0, 90)).remarks)
    assert is_skipped == (frame is Frame.GLOBAL_TERRAIN_ALT)


@BOTH
@pytest.mark.parametrize(
    ("odd", "plain"),
    [
        ((to(0, 60), to(0, 60), to(0, 60)), (to(0, 60),)),
        ((change_speed(0.0), to(0, 60)), (to(0, 60),)),
        ((to(0, 60), order(Command.DO_JUMP, 2, 0)), (to(0, 60),)),
        ((to(0, 60, hold_s=-3.0),), (to(0, 60),)),
        ((to(0, 60), to(0, 0), order(Command.DO_JUMP, 2, 1)), (to(0, 60), to(0, 0), to(0, 60), to(0, 0))),
    ],
    ids=["a place twice", "no speed", "no jump", "no hold", "a jump written out"],
)
def test_empty_commands_take_no_time(autopilot: Autopilot, odd: tuple[Item, ...], plain: tuple[Item, ...]) -> None:
    assert predicted(autopilot, *odd).total_s == pytest.approx(predicted(autopilot, *plain).total_s, abs=1.0)


@BOTH
@pytest.mark.parametrize(
    ("leg", "seconds"),
    [
        ((to(0, 0, 130),), {"ardupilot": 100 / 2.5, "px4": 100 / 3.0}),
        ((to(0, 0, 130), to(0, 0, 30)), {"ardupilot": 100 / 1.5, "px4": 100 / 1.5}),
        ((at(Command.NAV_LOITER_TIME, 0, 0, 30, 60),), {"ardupilot": 60.0, "px4": 60.0}),
        ((at(Command.NAV_LOITER_TURNS, 0, 0, 30, 9, 0, 20),), {"ardupilot": 9 * 25.1}),  # at 5 m/s
    ],
    ids=["up", "down", "loiter", "turns"],
)
def test_long_simple_things_take_what_one_reckons_and_a_little_more(
    autopilot: Autopilot, leg: tuple[Item, ...], seconds: Mapping[str, float]
) -> None:
    if autopilot.name in seconds:
        most = 1.1 if autopilot is Autopilot.ARDUPILOT else 1.3
        assert 0.99 < lasted(predicted(autopilot, *leg), 1 + len(leg)) / seconds[autopilot.name] < most


@BOTH
def test_mission_without_a_takeoff_begins_in_flight_with_a_remark(autopilot: Autopilot) -> None:
    there, legs = to(0, 0), (to(0, 90), to(90, 90))
    climbing, flying = predicted(autopilot, there, *legs), predicted(autopilot, there, *legs, first=())
    assert any("no take-off" in remark for remark in flying.remarks)
    assert flying.total_s == pytest.approx(climbing.total_s - climbing.items[1].done_s, abs=2.5)


@BOTH
@pytest.mark.parametrize(
    ("leg", "reason"),
    [
        ((change_speed(15.0), to(0, 900)), "drag at the greatest tilt"),
        ((to(0, 5, 90),), "climb or descent rate"),
        ((change_speed(12.0), to(0, 25)), "leg shorter than its braking distance"),
    ],
)
def test_a_slow_leg_has_its_reason(autopilot: Autopilot, leg: tuple[Item, ...], reason: str) -> None:
    fast = {"MPC_XY_VEL_MAX": 20.0} if autopilot is Autopilot.PX4 else {}
    mission = Mission(HOME, (takeoff(HOME, 30.0), *leg), autopilot)
    assert reason in estimate(mission, fast).items[-1].reason


@BOTH
def test_vehicle_that_must_not_tilt_is_refused_by_its_parameter(autopilot: Autopilot) -> None:
    name = autopilot.parameter_table.by_meaning["tilt"].name
    with refuses("bad-input", name, "0", kind=BadInput):
        estimate(Mission(HOME, (takeoff(HOME, 30.0), to(0, 60)), autopilot), {name: 0.0})
