"""Measured by others on real PX4 and ArduCopter (hamishwillee/mavsdk_mavlink_tests, 2026).

PX4 main and 1.18.0-beta (SIH), PX4 1.17.0, ArduCopter 4.8.0-dev: one item of each frame in each of the three lists, and
take-offs, gates and waypoints with odd values.
"""

import math

import pytest

from ipoa_mission.autopilot.autopilot import Autopilot, registered
from ipoa_mission.autopilot.commands import Command
from ipoa_mission.autopilot.version import Version
from ipoa_mission.checks.check import check_mission
from ipoa_mission.geodesy import Geodetic
from ipoa_mission.link.messages import MissionType, Result
from ipoa_mission.link.vehicle_words import event, words_in
from ipoa_mission.mission.items import Item, Mission
from ipoa_mission.simulator.mission_service import infeasibility, judge

PX4, ARDUPILOT = Autopilot.PX4, Autopilot.ARDUPILOT
PLACE = (37.6234, -122.0811, 20.0)
ONE = {
    MissionType.MISSION: (Command.NAV_WAYPOINT, 0.0),
    MissionType.FENCE: (Command.NAV_FENCE_RETURN_POINT, 0.0),
    MissionType.RALLY: (Command.NAV_RALLY_POINT, 0.0),
}
TAKEN_FRAMES = {PX4: {0, 3, 5, 6}, ARDUPILOT: {0, 3, 5, 6, 10, 11}}
FRAMES = (0, 1, *range(3, 22))  # all but MAV_FRAME_MISSION
LATER = Version(4, 8, 0, "dev")


def verdict(autopilot: Autopilot, version: Version | None, item: Item, kind: int = MissionType.MISSION) -> Result:
    return judge(autopilot, autopilot.firmware(version), item, kind, 2)


@pytest.mark.parametrize("autopilot", registered())
@pytest.mark.parametrize("kind", ONE)
def test_frames_are_taken_as_they_took_them(autopilot: Autopilot, kind: MissionType) -> None:
    command, first = ONE[kind]
    taken = {
        frame
        for frame in FRAMES
        if verdict(autopilot, None, Item(command, frame, (first, 0.0, 0.0, 0.0), *PLACE), kind) is Result.ACCEPTED
    }
    assert taken == TAKEN_FRAMES[autopilot]


def item_of(command: Command, *params: float, place: tuple[float, float, float] = PLACE, frame: int = 6) -> Item:
    first, second, third, fourth = (*params, *[0.0] * (4 - len(params)))
    return Item(command, frame, (first, second, third, fourth), *place)


TAKEOFF, GATE, NAN = Command.NAV_TAKEOFF, Command.CONDITION_GATE, math.nan
BETA, RELEASED = Version(1, 18, 0, "beta"), Version(1, 17)
ROWS = [
    (PX4, BETA, item_of(TAKEOFF, 15.0, 0, 0, NAN), Result.ACCEPTED),
    (PX4, BETA, item_of(TAKEOFF, 0, NAN, 0, NAN), Result.ACCEPTED),
    (PX4, BETA, item_of(TAKEOFF, 0, 1.0, 0, NAN), Result.INVALID_PARAM2),
    (PX4, BETA, item_of(TAKEOFF, 0, 0, 1.0, NAN), Result.INVALID_PARAM3),
    (PX4, BETA, item_of(TAKEOFF, 0, 0, 2.0, NAN), Result.INVALID_PARAM3),
    (PX4, BETA, item_of(TAKEOFF, 0, 0, 0, 450.0), Result.ACCEPTED),
    (PX4, BETA, item_of(TAKEOFF, place=(NAN, NAN, 20.0)), Result.ACCEPTED),
    (PX4, BETA, item_of(TAKEOFF, place=(*PLACE[:2], NAN)), Result.ACCEPTED),
    (PX4, BETA, item_of(GATE), Result.INVALID_PARAM5_X),  # as released; they mended that in theirs
    (PX4, RELEASED, item_of(TAKEOFF, 15.0, 1.0, 1.0, 137.0), Result.ACCEPTED),
    (PX4, RELEASED, item_of(GATE, 7.0, 1.0), Result.ACCEPTED),
    (PX4, RELEASED, item_of(Command.NAV_WAYPOINT, frame=2), Result.UNSUPPORTED),
    (ARDUPILOT, LATER, item_of(TAKEOFF, 15.0), Result.ACCEPTED),
    (ARDUPILOT, LATER, item_of(TAKEOFF, 0, NAN), Result.INVALID_PARAM2),
    (ARDUPILOT, LATER, item_of(TAKEOFF, 0, 1.0), Result.ACCEPTED),
    (ARDUPILOT, LATER, item_of(TAKEOFF, 0, 0, 2.0), Result.ACCEPTED),
    (ARDUPILOT, LATER, item_of(TAKEOFF, 0, 0, 0, NAN), Result.ACCEPTED),
    (ARDUPILOT, LATER, item_of(TAKEOFF, place=(NAN, NAN, 20.0)), Result.INVALID_PARAM5_X),
    (ARDUPILOT, LATER, item_of(TAKEOFF, place=(*PLACE[:2], NAN)), Result.INVALID_PARAM7),
    (ARDUPILOT, LATER, item_of(GATE), Result.UNSUPPORTED),
    (ARDUPILOT, LATER, item_of(GATE, 0, 0, NAN, NAN), Result.INVALID_PARAM3),
    (ARDUPILOT, LATER, item_of(Command.NAV_WAYPOINT, frame=2), Result.ACCEPTED),
]


@pytest.mark.parametrize(("autopilot", "version", "item", "result"), ROWS)
def test_items_are_judged_as_they_were(autopilot: Autopilot, version: Version, item: Item, result: Result) -> None:
    assert verdict(autopilot, version, item) is result


@pytest.mark.parametrize(
    ("required", "commands", "why"),
    [
        (0, (), None),
        (1, (Command.NAV_LAND,), "takeoff_missing"),
        (2, (TAKEOFF,), "land_missing"),
        (3, (TAKEOFF,), "takeoff_or_land_missing"),
        (4, (TAKEOFF,), "add_land_or_rm_to"),
        (4, (Command.NAV_LAND,), "add_to_or_rm_land"),
        (5, (), "land_missing"),
        (5, (TAKEOFF, Command.NAV_LAND), None),
    ],
)
def test_px4_requires_the_ends_of_its_parameter(required: int, commands: tuple[Command, ...], why: str | None) -> None:
    """As FeasibilityChecker of PX4 1.17 and 1.18."""
    order = sorted((*commands, Command.NAV_WAYPOINT), key=[TAKEOFF, Command.NAV_WAYPOINT, Command.NAV_LAND].index)
    items = [item_of(command, frame=3) for command in order]
    parameters = {"MIS_TKO_LAND_REQ": float(required)}
    verdict = infeasibility(PX4, PX4.firmware(), items, Geodetic(*PLACE[:2]), parameters)
    assert verdict == (why and event(f"navigator_mis_{why}"))
    wrong = PX4.refusals.ends(set(commands), parameters)
    assert words_in(verdict) == ("" if wrong is None else wrong.words)


@pytest.mark.parametrize("height", [-1.0, 0.0, 0.1, 0.5, 1.0, 2.0, 3.0, 5.0, 10.0])
def test_px4_refuses_a_take_off_that_does_not_climb(height: float) -> None:
    """Uploaded to PX4 1.17 and 1.18 in SIH, with NAV_MC_ALT_RAD 0.8 and 0.3, alone and with a waypoint behind it."""
    item = item_of(TAKEOFF, place=(*PLACE[:2], height))
    for version in (RELEASED, BETA):
        verdict = infeasibility(PX4, PX4.firmware(version), [item], Geodetic(*PLACE[:2]), {})
        assert verdict == (event("navigator_mis_takeoff_too_low") if height <= 0.0 else None)


@pytest.mark.parametrize(
    ("command", "is_refused"),
    [
        (Command.DO_GRIPPER, True),
        (Command.DO_SET_ACTUATOR, True),
        (Command.DO_WINCH, True),
        (Command.COMPONENT_ARM_DISARM, True),
        (Command.DO_AUTOTUNE_ENABLE, True),
        (Command.NAV_WAYPOINT, True),
        (Command.NAV_RETURN_TO_LAUNCH, True),
        (Command.NAV_DELAY, False),
        (Command.NAV_ROI, False),
        (Command.DO_SET_ROI_LOCATION, False),
        (Command.DO_SET_CAM_TRIGG_DIST, False),
        (Command.DO_CHANGE_SPEED, False),
    ],
)
def test_px4_refuses_a_take_off_behind_what_it_takes_for_a_place(command: Command, is_refused: bool) -> None:
    """As `checkTakeoff` of FeasibilityChecker in PX4 1.17 and 1.18."""
    items = [item_of(command, frame=3), item_of(TAKEOFF, frame=3)]
    verdict = infeasibility(PX4, PX4.firmware(), items, Geodetic(*PLACE[:2]), {})
    assert (verdict == event("navigator_mis_takeoff_not_first")) == is_refused
    findings = check_mission(Mission(Geodetic(*PLACE), tuple(items), PX4))
    assert any(finding.code == "takeoff-not-first" for finding in findings) == is_refused
