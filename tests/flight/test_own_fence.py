import math
from dataclasses import replace

import numpy as np
import pytest

from ipoa_mission.autopilot.autopilot import Autopilot
from ipoa_mission.autopilot.failsafe import OwnFence
from ipoa_mission.autopilot.parameters import Parameters
from ipoa_mission.flight.preflight import breaches, expect_fit
from ipoa_mission.geodesy import Geodetic, LocalFrame
from ipoa_mission.mission.items import Mission, return_to_launch, takeoff, waypoint
from ipoa_mission.simulator.fly import board
from tests.refused import refuses

HOME = Geodetic(47.4, 8.5, 400.0)
FRAME = LocalFrame(HOME)
AP, PX4 = Autopilot.ARDUPILOT, Autopilot.PX4


def mission(autopilot: Autopilot, away: float, height: float) -> Mission:
    place = FRAME.geodetic(np.array([away, 0.0, height]))
    items = (takeoff(HOME, 20.0), waypoint(place, height), return_to_launch())
    return Mission(HOME, items, autopilot)


def limits(fence: OwnFence | None) -> tuple[float, ...] | None:
    return None if fence is None else (fence.radius.value, fence.ceiling.value, fence.floor.value)


SET = {"FENCE_ENABLE": 1.0, "FENCE_ACTION": 1.0, "FENCE_RADIUS": 150.0, "FENCE_ALT_MAX": 90.0, "FENCE_ALT_MIN": 5.0}


@pytest.mark.parametrize(
    ("autopilot", "values", "expected"),
    [
        (AP, SET | {"FENCE_TYPE": 15.0}, (150.0, 90.0, 5.0)),
        (AP, SET | {"FENCE_TYPE": 7.0}, (150.0, 90.0, -math.inf)),
        (AP, SET | {"FENCE_TYPE": 4.0}, (math.inf, math.inf, -math.inf)),
        (AP, SET | {"FENCE_TYPE": 15.0, "FENCE_ENABLE": 0.0}, None),
        (AP, SET | {"FENCE_TYPE": 15.0, "FENCE_ACTION": 0.0}, None),
        (AP, SET | {"FENCE_TYPE": 15.0, "FENCE_ACTION": math.nan}, (150.0, 90.0, 5.0)),
        (AP, {}, None),
        (AP, {"FENCE_ENABLE": 1.0}, (300.0, 100.0, -math.inf)),
        (PX4, {}, (math.inf, math.inf, -math.inf)),
        (PX4, {"GF_MAX_VER_DIST": 50.0}, (math.inf, 50.0, -math.inf)),
        (PX4, {"GF_ACTION": 2.0, "GF_MAX_HOR_DIST": 150.0, "GF_MAX_VER_DIST": 0.0}, (150.0, math.inf, -math.inf)),
        (PX4, {"GF_ACTION": 3.0, "GF_MAX_HOR_DIST": 0.0, "GF_MAX_VER_DIST": 40.0}, (math.inf, 40.0, -math.inf)),
        (PX4, {"GF_ACTION": 1.0, "GF_MAX_HOR_DIST": 1.0, "GF_MAX_VER_DIST": 1.0}, None),
    ],
)
def test_limits_in_force_follow_the_own_fence(
    autopilot: Autopilot, values: Parameters, expected: tuple[float, ...] | None
) -> None:
    assert limits(autopilot.own_fence(values)) == expected


@pytest.mark.parametrize(
    ("away", "height", "types", "parts"),
    [
        (149.7, 30.0, 15.0, ()),
        (
            149.8,
            30.0,
            15.0,
            ("149.8 m away from home (150.1 m with the deviation of flights), and", "150.0 m at most (FENCE_RADIUS)"),
        ),
        (100.0, 89.3, 15.0, ()),
        (
            100.0,
            89.4,
            15.0,
            ("89.4 m above home (90.1 m with the deviation of flights), and", "90.0 m at most (FENCE_ALT_MAX)"),
        ),
        (100.0, 5.4, 15.0, ()),
        (
            100.0,
            5.2,
            15.0,
            ("5.2 m above home (4.9 m with the deviation of flights), and", "5.0 m at least (FENCE_ALT_MIN)"),
        ),
        (149.0, 30.0, 15.0, ()),
        (151.0, 30.0, 15.0, ("item 2 (NAV_WAYPOINT): 151.0 m away from home (", "150.0 m at most (FENCE_RADIUS)")),
        (151.0, 30.0, 4.0, ()),
        (100.0, 91.0, 15.0, ("91.0 m above home (", "90.0 m at most (FENCE_ALT_MAX)")),
        (100.0, 4.0, 15.0, ("4.0 m above home (", "5.0 m at least (FENCE_ALT_MIN)")),
        (100.0, 4.0, 7.0, ()),  # take-off and landing are below any least height
    ],
)
def test_each_limit_that_is_passed_is_named(away: float, height: float, types: float, parts: tuple[str, ...]) -> None:
    fence = AP.own_fence(SET | {"FENCE_TYPE": types})
    assert fence is not None
    words = breaches(mission(AP, away, height), fence, HOME)
    assert len(words) == (1 if parts else 0)
    assert all(part in words[0] for part in parts)


def test_the_circle_is_around_where_the_vehicle_stands() -> None:
    fence = AP.own_fence(SET | {"FENCE_TYPE": 2.0})
    assert fence is not None
    flight = mission(AP, 140.0, 30.0)
    assert breaches(flight, fence, HOME) == ()
    (words,) = breaches(flight, fence, FRAME.geodetic(np.array([-20.0, 0.0, 0.0])))
    assert "160.0 m away from home" in words


def test_the_way_home_counts_with_its_height() -> None:
    fence = AP.own_fence(SET | {"FENCE_TYPE": 1.0, "FENCE_ALT_MAX": 40.0})
    assert fence is not None
    high = replace(mission(AP, 100.0, 30.0), parameters={"RTL_ALT": 5000.0})
    (words,) = breaches(high, fence, HOME)
    assert words.startswith("item 3 (NAV_RETURN_TO_LAUNCH): 50.0 m above home")


@pytest.mark.parametrize(
    ("autopilot", "own", "wide"),
    [
        (AP, {"FENCE_ENABLE": 1.0, "FENCE_RADIUS": 150.0}, {"FENCE_ENABLE": 1.0}),
        (PX4, {"GF_MAX_HOR_DIST": 150.0}, {"GF_MAX_HOR_DIST": 300.0}),
    ],
)
def test_vehicle_with_too_narrow_a_fence_is_sent_nothing(
    autopilot: Autopilot, own: Parameters, wide: Parameters
) -> None:
    flight = mission(autopilot, 200.0, 30.0)
    with board(flight.with_parameters(own)) as vehicle:
        with refuses("outside-own-fence", "", "200.0", "150") as no:
            expect_fit(vehicle, flight)
        assert "--anyway" in str(no.value.hint)
        assert any("200.0 m away from home" in words for words in expect_fit(vehicle, flight, anyway=True))
    with board(flight.with_parameters(wide)) as vehicle:
        assert not any("fence" in words for words in expect_fit(vehicle, flight))


def test_a_mission_that_no_vehicle_should_fly_is_not_compared_and_says_so() -> None:
    flight = mission(PX4, 200.0, 12_000.0)
    with board(flight.with_parameters({"GF_MAX_HOR_DIST": 150.0})) as vehicle:
        (words,) = (words for words in expect_fit(vehicle, flight, anyway=True) if "own fence" in words)
    assert words.startswith("the mission was not compared with the vehicle's own fence: ")
    assert "12000" in words
