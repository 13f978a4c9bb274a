"""Returns by all their parameters, against the firmwares' sources, by hand.

ArduCopter 4.7.0-dev (2598e9d4): mode_rtl.cpp, compute_return_target; AP_Rally. PX4 1.17.0 (d6f12ad1), release/1.18
(05deebf313) and main (bb59c637, to be 1.19): navigator/rtl.cpp, rtl_direct.cpp, RTLPlanner.
"""

import pytest

from ipoa_mission.autopilot.autopilot import Autopilot
from ipoa_mission.autopilot.parameters import Parameters
from ipoa_mission.autopilot.returning import MissionLanding, ReturnBy, ReturnOrder, ReturnRoute
from ipoa_mission.autopilot.version import Version
from ipoa_mission.geometry import Enu
from ipoa_mission.ground import Ground
from ipoa_mission.vehicles.px4_multicopter.dynamics.navigator import return_motions
from ipoa_mission.vehicles.px4_multicopter.limits import px4_limits
from ipoa_mission.world.terrain import Flat

AP, PX4 = Autopilot.ARDUPILOT, Autopilot.PX4
OLD, NEW, MAIN = Version(1, 17), Version(1, 18), Version(1, 19)
FENCE = {"FENCE_ENABLE": 1.0, "FENCE_ALT_MAX": 50.0, "FENCE_TYPE": 1.0}


@pytest.mark.parametrize(
    ("parameters", "above", "away", "goal_up", "height"),
    [
        ({}, 5.0, 100.0, 0.0, 15.0),  # RTL_ALT
        ({}, 0.0, 0.0, 0.0, 0.3),  # RTL_ALT_MIN
        ({}, 40.0, 100.0, 0.0, 40.0),
        ({"RTL_CLIMB_MIN": 500.0}, 40.0, 100.0, 0.0, 45.0),
        ({"RTL_CLIMB_MIN": -500.0}, 40.0, 100.0, 0.0, 40.0),
        ({}, 5.0, 4.0, 0.0, 12.0),  # the cone of 3
        ({"RTL_CONE_SLOPE": 0.4}, 5.0, 4.0, 0.0, 15.0),  # too flat to count
        ({}, 5.0, 4.0, 30.0, 12.0),  # the cone precedes a rally point's height
        ({}, 5.0, 100.0, 30.0, 30.0),
        (FENCE | {"RTL_ALT": 6000.0}, 20.0, 400.0, 0.0, 48.0),  # FENCE_MARGIN is 2
        (FENCE | {"RTL_ALT": 6000.0, "FENCE_MARGIN": 5.0}, 20.0, 400.0, 0.0, 45.0),
        (FENCE | {"RTL_ALT": 6000.0}, 49.0, 400.0, 0.0, 49.0),  # it never comes down
        (FENCE | {"RTL_CLIMB_MIN": 1000.0}, 45.0, 400.0, 0.0, 48.0),
        (FENCE | {"RTL_ALT": 6000.0}, 20.0, 400.0, 70.0, 48.0),  # not even for a rally point
        (FENCE | {"RTL_ALT": 6000.0, "FENCE_TYPE": 6.0}, 20.0, 400.0, 0.0, 60.0),
        (FENCE | {"RTL_ALT": 6000.0, "FENCE_ENABLE": 0.0}, 20.0, 400.0, 0.0, 60.0),
        (FENCE | {"RTL_ALT": 6000.0, "FENCE_ENABLE": 0.0, "FENCE_AUTOENABLE": 3.0}, 20.0, 400.0, 0.0, 48.0),
        (FENCE | {"RTL_ALT": 6000.0, "FENCE_ACTION": 0.0}, 20.0, 400.0, 0.0, 48.0),  # a fence that only reports as well
    ],
)
def test_arducopter_returns_so_high(
    parameters: Parameters, above: float, away: float, goal_up: float, height: float
) -> None:
    assert AP.return_height(AP.complete(parameters), above, away, goal_up) == pytest.approx(height)


@pytest.mark.parametrize(
    ("parameters", "above", "away", "height"),
    [
        ({}, 5.0, 100.0, 30.0),
        ({}, 40.0, 100.0, 40.0),
        ({}, 5.0, 8.0, 8.0),  # within RTL_MIN_DIST the cone of 45 degrees
        ({}, 1.0, 3.0, 4.0),  # two NAV_ACC_RAD at least
        ({}, 1.0, 1.5, 3.0),  # within NAV_ACC_RAD twice the distance
        ({"RTL_RETURN_ALT": 3.0}, 1.0, 100.0, 3.0),  # lower than two NAV_ACC_RAD: it counts
        ({"RTL_RETURN_ALT": 3.0}, 1.0, 1.9, 3.0),
        ({"RTL_CONE_ANG": 0.0}, 1.0, 1.0, 30.0),  # no cone: always as high
        ({"RTL_CONE_ANG": 0.0, "RTL_RETURN_ALT": 3.0}, 1.0, 100.0, 3.0),
        ({"RTL_CONE_ANG": 90.0}, 5.0, 9.0, 5.0),  # taken for 89 degrees
        ({"NAV_ACC_RAD": 10.0}, 5.0, 100.0, 30.0),
        ({"NAV_ACC_RAD": 10.0, "RTL_MIN_DIST": 50.0}, 5.0, 12.0, 20.0),
    ],
)
def test_px4_returns_so_high(parameters: Parameters, above: float, away: float, height: float) -> None:
    complete = PX4.complete(parameters, OLD)
    assert PX4.return_height(complete, above, away) == pytest.approx(height)
    assert PX4.return_height(complete, above + 7.0, away, 7.0) == pytest.approx(height + 7.0)


@pytest.mark.parametrize(("version", "height"), [(OLD, 5.0), (NEW, 10.0), (MAIN, 10.0)])
def test_px4_returns_by_the_acceptance_radius_of_its_version(version: Version, height: float) -> None:
    """Within NAV_ACC_RAD, 10 m since 1.18, twice the distance."""
    assert PX4.return_height(PX4.complete({}, version), 1.0, 5.0) == pytest.approx(height)
    with pytest.raises(KeyError, match="RTL_RETURN_ALT"):
        PX4.return_height({}, 1.0, 5.0)


@pytest.mark.parametrize(
    ("parameters", "ground", "wait"),
    [
        ({}, 0.0, 10.0),  # RTL_DESCEND_ALT
        ({"RTL_DESCEND_ALT": 12.0}, 0.0, 12.0),
        ({"RTL_DESCEND_ALT": 12.0}, 20.0, 32.0),  # it counts from the goal
        ({"RTL_DESCEND_ALT": 80.0}, 0.0, 30.0),  # rtl_direct.cpp: no higher than the return
    ],
)
def test_px4_waits_before_its_landing_at_its_descend_altitude(
    parameters: Parameters, ground: float, wait: float
) -> None:
    limits = px4_limits({**parameters, "RTL_LAND_DELAY": 9.0})
    here = Enu(100.0, 0.0, ground + 20.0)
    *_, down_to, waiting, landing = return_motions(here, (0.0, 0.0, ground), Ground(Flat(ground)), limits)
    assert (waiting.hold_s, landing.goal) == (9.0, Enu(0.0, 0.0, ground))
    assert down_to.goal == waiting.goal == Enu(0.0, 0.0, wait)


@pytest.mark.parametrize(
    ("parameters", "goal"),
    [
        ({}, 0),
        ({"FENCE_ENABLE": 1.0, "FENCE_TYPE": 2.0, "FENCE_RADIUS": 100.0}, None),
        ({"FENCE_ENABLE": 1.0, "FENCE_TYPE": 2.0, "FENCE_RADIUS": 140.0}, 0),
        ({"FENCE_ENABLE": 1.0, "FENCE_TYPE": 1.0, "FENCE_ALT_MAX": 10.0}, 1),
        ({"FENCE_ENABLE": 1.0, "FENCE_TYPE": 8.0, "FENCE_ALT_MIN": 6.0}, 0),
    ],
)
def test_arducopter_passes_over_rally_points_outside_its_fence(parameters: Parameters, goal: int | None) -> None:
    rally = [(130.0, 0.0, 12.0), (110.0, 0.0, 5.0)]
    assert AP.return_route(parameters, ReturnOrder((150.0, 0.0, 20.0), rally)).rally == goal


BEYOND = MissionLanding((210.0, 0.0, 0.0), ahead=3, behind=2)
BEHIND = MissionLanding((10.0, 0.0, 0.0), ahead=2, behind=3)


@pytest.mark.parametrize(
    ("kind", "rally", "landing", "by", "goal", "version"),
    [
        (0.0, (), BEYOND, ReturnBy.DIRECT, None, None),
        (1.0, (), BEYOND, ReturnBy.LANDING, None, None),
        (1.0, (), None, ReturnBy.DIRECT, None, None),
        (1.0, ((170.0, 0.0, 5.0),), BEYOND, ReturnBy.DIRECT, 0, None),
        (1.0, ((400.0, 0.0, 5.0),), None, ReturnBy.DIRECT, 0, None),
        (2.0, (), None, ReturnBy.MISSION_REVERSED, None, None),
        (2.0, ((170.0, 0.0, 5.0),), BEYOND, ReturnBy.MISSION_FORWARD, None, None),
        (3.0, (), BEYOND, ReturnBy.LANDING, None, None),
        (3.0, (), BEHIND, ReturnBy.LANDING, None, None),
        (3.0, ((170.0, 0.0, 5.0),), BEYOND, ReturnBy.DIRECT, 0, None),
        (3.0, ((208.05, 0.0, 5.0),), BEYOND, ReturnBy.LANDING, None, None),  # nearer by 1.95 m: 2 m are required
        (3.0, ((207.9, 0.0, 5.0),), BEYOND, ReturnBy.DIRECT, 0, None),  # by 2.1 m
        (4.0, (), BEYOND, ReturnBy.MISSION_REVERSED, None, None),
        (4.0, (), BEHIND, ReturnBy.MISSION_FORWARD, None, None),
        (5.0, ((9.0, 0.0, 5.0),), BEYOND, ReturnBy.DIRECT, 0, NEW),  # one at home, where home is none
        (5.0, (), BEYOND, ReturnBy.LAND_IN_PLACE, None, NEW),
        (5.0, ((9.0, 0.0, 5.0),), BEYOND, ReturnBy.DIRECT, None, OLD),  # as 0 before 1.18
    ],
)
def test_px4_returns_along_the_way_of_its_type(
    kind: float,
    rally: tuple[tuple[float, float, float], ...],
    landing: MissionLanding | None,
    by: ReturnBy,
    goal: int | None,
    version: Version | None,
) -> None:
    route = PX4.return_route({"RTL_TYPE": kind}, ReturnOrder((150.0, 0.0, 20.0), rally, landing, version))
    assert route == ReturnRoute(by, goal)


def test_arducopter_returns_straight_whatever_its_mission_has() -> None:
    rally = ((130.0, 0.0, 12.0),)
    assert AP.return_route({}, ReturnOrder((150.0, 0.0, 20.0), rally, BEYOND)) == ReturnRoute(ReturnBy.DIRECT, 0)


@pytest.mark.parametrize(
    ("parameters", "follows"),
    [
        ({}, False),
        ({"RTL_ALT_TYPE": 1.0}, True),
        ({"RTL_ALT_TYPE": 2.0}, False),  # no value of it
        ({"RTL_ALT_TYPE": 1.0, "TERRAIN_ENABLE": 0.0}, False),
        ({"RTL_ALT_TYPE": 1.0, "TERRAIN_ENABLE": 0.0, "RNGFND1_TYPE": 8.0}, True),
        ({"RTL_ALT_TYPE": 1.0, "TERRAIN_ENABLE": 0.0, "RNGFND1_TYPE": 8.0, "WPNAV_RFND_USE": 0.0}, False),
    ],
)
def test_arducopter_may_keep_its_height_over_the_ground(parameters: Parameters, follows: bool) -> None:
    assert (AP.over_terrain(parameters) is not None) is follows


def test_px4_flies_around_fences_since_1_19() -> None:
    assert PX4.fence_margin({}, OLD) is PX4.fence_margin({}, NEW) is None
    assert PX4.fence_margin({}, MAIN) == 20.0
    assert PX4.fence_margin({"NAV_ACC_RAD": 2.0}, MAIN) == 4.0
    assert AP.fence_margin({}, Version(4, 7)) is None
