from dataclasses import replace
from pathlib import Path

import pytest

from ipoa_mission.autopilot.autopilot import Autopilot
from ipoa_mission.autopilot.commands import FLOWN_TO, Command, Frame
from ipoa_mission.autopilot.failsafe import FlightStage
from ipoa_mission.autopilot.version import Version
from ipoa_mission.checks.check import check, check_mission
from ipoa_mission.checks.unsafe import begun_at
from ipoa_mission.forecast.forecast import Forecast
from ipoa_mission.forecast.itinerary.itinerary import itinerary
from ipoa_mission.geodesy import Geodetic
from ipoa_mission.mission.item_edits import without_item
from ipoa_mission.mission.items import Item, Mission, change_speed, return_to_launch, takeoff, waypoint
from ipoa_mission.report.exports import lines_of
from ipoa_mission.report.table import mission_table
from ipoa_mission.scenario import parse_scenario
from ipoa_mission.simulator.simulated_flight import SimulatedFlight
from tests.finding_codes import codes_of
from tests.refused import refuses

ARDUPILOT, PX4 = Autopilot.ARDUPILOT, Autopilot.PX4
HOME = Geodetic(47.3977, 8.5456, 488.0)
UP, BACK = takeoff(HOME, 20.0), return_to_launch()
PHOTOS = Item(Command.DO_SET_CAM_TRIGG_DIST, Frame.MISSION, (20.0, 0.0, 0.0, 0.0))


def at(north: float, east: float) -> Item:
    """A waypoint thousandths of a degree from home."""
    return waypoint(Geodetic(HOME.latitude_deg + north / 1000, HOME.longitude_deg + east / 1000), 20.0)


def order(command: Command, first: float = 0.0, second: float = 0.0, third: float = 0.0, fourth: float = 0.0) -> Item:
    return Item(command, Frame.MISSION, (first, second, third, fourth))


def jump(to: float, times: float) -> Item:
    return order(Command.DO_JUMP, to, times)


def to_tag(tag: float, times: float) -> Item:
    return order(Command.DO_JUMP_TAG, tag, times)


def tag(number: float) -> Item:
    return order(Command.JUMP_TAG, number)


def mission(*items: Item, autopilot: Autopilot = ARDUPILOT) -> Mission:
    return Mission(HOME, items, autopilot)


def seconds(*items: Item) -> float:
    return Forecast(mission(*items)).estimate.total_s


A, B, C, D = at(1, 0), at(1, 2), at(0, 2), at(0, 1)
LOOP = (UP, tag(1), A, B, C, to_tag(1, 2), D, BACK)
NESTED = (UP, A, B, jump(2, 1), C, jump(2, 1), BACK)
FAR, EAST, SOUTH = at(2, 0), at(2, 4), at(-1, 4)
ACTION = (UP, FAR, EAST, PHOTOS, jump(2, 2), change_speed(2.0), SOUTH, BACK)
TOWER = """
home = { latitude_deg = 47.3977, longitude_deg = 8.5456, altitude_amsl = 488 }
start = { east = 0, north = 0, up = 20 }
goal = { east = 75, north = 0, up = 20 }
vehicle = { autopilot = "ardupilot" }
bounds = { east = [-100, 300], north = [-100, 300], up = [0, 120] }
obstacles = [{ kind = "box", name = "tower", east = 75, north = 55, width = 20, depth = 20, height = 40 }]
"""


def test_jumps_to_a_tag_take_as_long_as_their_passes_written_out() -> None:
    holds = replace(C, params=(1.0, 0.0, 0.0, 0.0))  # else it flies on past the jump
    assert seconds(UP, tag(1), A, B, holds, to_tag(1, 2), D, BACK) == seconds(UP, *(A, B, holds) * 3, D, BACK)
    written_out = seconds(UP, *(A, B, C) * 3, D, BACK)
    assert seconds(UP, A, B, C, jump(2, 2), D, BACK) == written_out == pytest.approx(234.3, abs=3.0)


@pytest.mark.parametrize("items", [LOOP, (UP, A, B, C, jump(2, 2), D, BACK)], ids=["tag", "number"])
def test_the_leg_back_is_held_against_the_world_and_named_by_both_ends(items: tuple[Item, ...]) -> None:
    findings = check(Forecast(mission(*items), parse_scenario(TOWER, Path("tower.toml"))))
    begins, ends = [n for n, item in enumerate(items, 1) if item in (A, C)][::-1]
    assert f"error leg-too-near {ends}" in codes_of(findings)
    assert any(f"the leg to it from item {begins}, after a jump: " in finding.message for finding in findings)


def test_arducopter_flies_on_past_a_jump_to_what_is_no_place() -> None:
    """ArduPilot #31021: 4.8.0-dev (531699d652) flew from C to D, called it A, and went on from there."""
    assert codes_of(check_mission(mission(*LOOP))) == ["error jump-flown-elsewhere 5"]
    known = Forecast(mission(*LOOP), parse_scenario(TOWER, Path("tower.toml")))
    assert known.guarantee_if_known is known.proof_if_known is None
    with refuses("jump-flown-elsewhere", "item 5"):
        known.guarantee  # noqa: B018
    with refuses("jump-flown-elsewhere", "item 5"):
        known.estimate  # noqa: B018
    to_an_action = mission(UP, change_speed(5.0), A, B, jump(2, 1), D, BACK)
    assert codes_of(check_mission(to_an_action)) == ["error jump-flown-elsewhere 4"]
    holds = replace(C, params=(1.0, 0.0, 0.0, 0.0))
    for clear in (
        mission(UP, tag(1), A, B, holds, to_tag(1, 2), D, BACK),
        mission(UP, tag(1), A, B, C, to_tag(1, 2), BACK),
        mission(UP, A, B, C, jump(2, 2), D, BACK),
        replace(to_an_action, autopilot=PX4, firmware_version=Version(1, 17)),
    ):
        assert not check_mission(clear)


def test_the_leg_back_is_a_line_of_the_exports() -> None:
    line = lines_of(Forecast(mission(*LOOP)))[1].points
    assert line[0][:2] == pytest.approx((C.longitude_deg, C.latitude_deg))
    assert line[-1][:2] == pytest.approx((A.longitude_deg, A.latitude_deg))


@pytest.mark.parametrize("again", [jump(4, -1), to_tag(1, -1)], ids=["number", "tag"])
def test_a_loop_without_end_is_found_and_has_no_time(again: Item) -> None:
    items = mission(UP, A, tag(1), B, C, again, at(-1, 2), at(-1, 0), BACK)
    elsewhere = ["error jump-flown-elsewhere 5"] if again.command == Command.DO_JUMP_TAG else []
    assert codes_of(check_mission(items)) == [*elsewhere, "warning jump-without-end 6"]
    with refuses("endless-flight", "item 6: param2"):
        itinerary(items)


def visits(flown: Mission) -> list[int]:
    return [v.seq for v in itinerary(flown).visits if v.item.command in FLOWN_TO - {Command.NAV_TAKEOFF}]


ONCE_MORE = [2, 3, 2, 3, 5, 2, 3, 5]


def test_arducopter_counts_a_finished_jump_anew_since_4_7() -> None:
    nested = mission(*NESTED)
    assert visits(nested) == [2, 3, 2, 3, 5, 2, 3, 2, 3, 5]
    assert visits(replace(nested, firmware_version=Version(4, 6))) == ONCE_MORE
    assert visits(nested.with_parameters({"MIS_OPTIONS": 8})) == ONCE_MORE
    assert visits(replace(nested, autopilot=PX4)) == ONCE_MORE
    assert seconds(*NESTED) == seconds(UP, *(A, B, A, B, C) * 2, BACK) == pytest.approx(253.2, abs=3.0)


def test_arducopter_runs_an_action_behind_a_jump_as_its_last_pass_begins() -> None:
    written_out = (UP, FAR, EAST, FAR, EAST, change_speed(2.0), FAR, EAST, SOUTH, BACK)
    assert seconds(*ACTION) == seconds(*written_out) == pytest.approx(666.4, abs=7.0)
    assert codes_of(check_mission(mission(*ACTION))) == ["warning action-at-other-time 6"]
    once = (UP, A, B, change_speed(3.0), jump(2, 0), jump(4, 2), C, BACK)
    (finding,) = (each for each in check_mission(mission(*once)) if each.code == "action-at-other-time")
    assert finding.message.endswith("ArduCopter runs it 1 time, and the list has it 3 times")
    assert not check_mission(replace(mission(*ACTION, autopilot=PX4), firmware_version=Version(1, 17)))
    order = [visit.seq for visit in itinerary(mission(*ACTION, autopilot=PX4)).visits]
    assert order == [1, 2, 3, 4, 2, 3, 4, 2, 3, 4, 6, 7, 8]


@pytest.mark.parametrize("autopilot", [ARDUPILOT, PX4])
def test_the_built_in_autopilot_flies_the_passes_of_the_forecast(autopilot: Autopilot) -> None:
    near = [at(0.1, 0), at(0.1, 0.2), at(0, 0.2)]
    first = 0 if autopilot is PX4 else 1
    stored = (UP, near[0], near[1], jump(1 + first, 1), near[2], jump(1 + first, 1), BACK)
    flight = SimulatedFlight(autopilot, HOME, {})
    flight.load(stored)
    flight.arm()
    flight.start()
    while flight.armed and flight.time_s < 300.0:
        flight.advance(flight.time_s + 1.0)
    flown = [done.index + 1 for done in flight.reached if stored[done.index].command == Command.NAV_WAYPOINT]
    assert flown == visits(mission(*NESTED, autopilot=autopilot))


CHAIN = (UP, A, *(jump(n, 1) for n in range(4, 14)), B, BACK)
FOUND = {
    "no such tag": ((UP, A, B, to_tag(7, 1), BACK), ["error jump-target 4"]),
    "a tag twice": ((UP, tag(1), A, tag(1), B, to_tag(1, 1), BACK), ["warning jump-tag-twice 4"]),
    "nothing but jumps": ((UP, A, jump(4, 200), jump(3, 200), BACK), ["error jump-no-way-on 3"]),
    "no place": ((UP, A, PHOTOS, jump(3, -1), BACK), ["error jump-no-way-on 3", "warning jump-without-end 4"]),
    "half a time": ((UP, A, B, jump(2, 0.5), BACK), ["error jump-repeats 4"]),
    "fewer than for ever": ((UP, A, B, jump(2, -2), BACK), ["error jump-repeats 4"]),
    "more than sixteen bits": ((UP, A, B, jump(2, 40_000), BACK), ["error jump-repeats 4"]),
    "sixteen jumps": ((UP, A, *(jump(2, 0),) * 16, B, BACK), ["warning too-many-jumps"]),
    "ten jumps at once": (CHAIN, []),
}  # fmt: skip


@pytest.mark.parametrize(("items", "wanted"), FOUND.values(), ids=FOUND)
def test_faults_of_jumps_are_found(items: tuple[Item, ...], wanted: list[str]) -> None:
    assert codes_of(check_mission(mission(*items))) == wanted


def test_jumps_beyond_the_counters_of_the_firmware_are_not_taken() -> None:
    loops = [item for n in range(101) for item in (A, jump(2 + 2 * n, 1))]
    items = mission(UP, *loops, BACK)
    assert codes_of(check_mission(items)) == ["error too-many-jumps"]
    assert len(visits(items)) == 201


def test_px4_ends_a_mission_at_the_tenth_jump_in_a_row() -> None:
    assert codes_of(check_mission(mission(*CHAIN, autopilot=PX4))) == ["error jump-no-way-on 12"]
    assert visits(mission(*CHAIN[:3], *CHAIN[4:], autopilot=PX4)) == [2, 12]


def test_the_table_says_how_often_a_leg_is_flown() -> None:
    assert [row.passes for row in mission_table(mission(*NESTED))] == [1, 1, 4, 4, 1, 2, 1, 1]


def test_a_wait_for_a_time_of_day_is_found_and_said_beside_the_time() -> None:
    delay = order(Command.NAV_DELAY, -1, 18, 30, 0)
    items = mission(UP, A, delay, B, BACK)
    assert codes_of(check_mission(items)) == ["warning waits-until-clock 3"]
    estimate = Forecast(items).estimate
    assert estimate.waits == ("of item 3 until 18:30:00 UTC",)
    assert estimate.besides == " and the wait of item 3 until 18:30:00 UTC"
    assert estimate.remarks == ("item 3: the wait until 18:30:00 UTC is not in the times",)
    assert not Forecast(replace(items, autopilot=PX4)).estimate.waits
    midnight = mission(UP, A, order(Command.NAV_DELAY), B, BACK)
    assert codes_of(check_mission(midnight)) == ["warning waits-until-clock 3"]


@pytest.mark.parametrize("autopilot", [ARDUPILOT, PX4])
def test_an_endless_loiter_before_other_items_is_found(autopilot: Autopilot) -> None:
    stays = replace(A, command=Command.NAV_LOITER_UNLIM)
    items = (replace(item, params=(0.1, 2.0, 0.0, 0.0)) for item in (A, B))
    first, last = items if autopilot is PX4 else (A, B)
    flown = mission(UP, first, stays, last, BACK, autopilot=autopilot)
    assert codes_of(check_mission(flown)) == ["warning waits-for-someone 3"]
    assert not check_mission(mission(UP, first, stays, autopilot=autopilot))


def test_a_flight_does_not_begin_inside_a_loop() -> None:
    with refuses("bad-input", "--from", "item 6", "item 2", "item 4"):
        begun_at(mission(*LOOP), 3)
    assert begun_at(mission(*LOOP), 6).items[6:] == LOOP[6:]


@pytest.mark.parametrize("autopilot", [ARDUPILOT, PX4])
def test_items_before_the_first_one_flown_leave_the_flight_known(autopilot: Autopilot) -> None:
    for version in (None, *map(Version, *zip(*autopilot.tables.series, strict=True))):
        whole = replace(mission(UP, A, B, C, D, BACK, autopilot=autopilot), firmware_version=version)
        begun = Forecast(begun_at(whole, 4))
        assert (begun.unknown, begun.estimate.remarks) == ((), Forecast(whole).estimate.remarks)
        waits = replace(whole, items=(UP, order(Command.CONDITION_DELAY), D, BACK))
        assert [unknown.seq for unknown in Forecast(waits).unknown] == ([2] if autopilot is PX4 else [])


@pytest.mark.parametrize(("autopilot", "speed"), [(ARDUPILOT, 10.0), (PX4, 3.0)])
def test_px4_repeats_the_last_change_of_speed_before_the_first_item(autopilot: Autopilot, speed: float) -> None:
    change = order(Command.DO_CHANGE_SPEED, 1.0, 3.0, -1.0)
    far = replace(B, latitude_deg=B.latitude_deg + 0.002)
    whole = mission(UP, change, A, far, BACK, autopilot=autopilot)
    for first in (2, 3):
        begun = begun_at(whole, first)
        assert begun.items[first - 1].is_takeoff
        assert Forecast(begun).estimate.items[3].peak_speed == pytest.approx(speed, rel=0.02)


def test_the_tag_of_a_jump_is_not_taken_out() -> None:
    with refuses("bad-input", "item 2", "item 6"):
        without_item(mission(*LOOP), 2)
    assert len(without_item(mission(UP, tag(2), *LOOP[1:]), 2).items) == len(LOOP)


def test_waypoint_that_may_be_passed_is_named_by_item_after_jumps() -> None:
    higher = replace(B, altitude=30.0)
    flown = replace(mission(UP, A, higher, C, jump(2, 2), D, BACK, autopilot=PX4), firmware_version=Version(1, 18))
    errors = [finding for finding in check_mission(flown) if finding.code == "waypoint-passed"]
    assert [finding.message.partition(":")[0] for finding in errors] == ["items 2 to 3"]
    endless = replace(flown, items=(*flown.items[:4], jump(2, -1), *flown.items[5:]))
    assert "error waypoint-passed 2" in codes_of(check_mission(endless))


def test_a_payload_place_after_a_jump_descends_to_the_ground() -> None:
    delivery = replace(B, command=Command.NAV_PAYLOAD_PLACE, params=(0.0, 0.0, 0.0, 0.0))
    legs = Forecast(mission(UP, A, delivery, C, jump(3, 1), BACK)).legs
    after_jump = [leg for leg in legs if leg.jumped_from == 4]
    assert [leg.stage for leg in after_jump] == [FlightStage.ROUTE, FlightStage.LANDING, FlightStage.LANDING]
    assert all(leg.alternative and leg.seq == 3 for leg in after_jump)
    assert after_jump[1].points[-1, 2] == pytest.approx(0.0, abs=0.1)
