import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ipoa_mission.autopilot.autopilot import Autopilot, registered
from ipoa_mission.autopilot.commands import Command, Frame
from ipoa_mission.forecast.forecast import estimate
from ipoa_mission.forecast.timing.estimate import Estimate
from ipoa_mission.geodesy import Geodetic, LocalFrame
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
from ipoa_mission.vehicles.arducopter.limits import PARAMETER_TABLE as ARDUCOPTER_BOOK
from ipoa_mission.vehicles.arducopter.limits import copter_limits
from ipoa_mission.vehicles.px4_multicopter.dynamics.state import normal
from ipoa_mission.wind import Wind
from tests.refused import refuses

HOME = Geodetic(39.101, 121.82, 20.0)
FRAME = LocalFrame(HOME)


def place(east: float, north: float) -> Geodetic:
    lat, lon, _ = FRAME.to_geodetic([[east, north, 0.0]])  # type: ignore[arg-type]
    return Geodetic(float(lat[0]), float(lon[0]), HOME.altitude)


def fly(autopilot: Autopilot, *items: Item, wind: Wind | None = None, **parameters: float) -> Estimate:
    mission = Mission(HOME, (takeoff(HOME, 30.0), *items), autopilot)
    return estimate(mission, parameters, wind or Wind())


def lasted(predicted: Estimate, seq: int) -> float:
    return next(item.duration_s for item in predicted.items if item.seq == seq)


BOTH = pytest.mark.parametrize("autopilot", registered())


@BOTH
def test_a_changed_speed_holds_for_the_legs_after_it(autopilot: Autopilot) -> None:
    far, back = waypoint(place(200.0, 0.0), 30.0), waypoint(HOME, 30.0)
    predicted = fly(autopilot, change_speed(4.0), far, change_speed(8.0), back)
    assert lasted(predicted, 3) == pytest.approx(200.0 / 4.0, rel=0.12)
    assert lasted(predicted, 5) < 0.75 * lasted(predicted, 3)
    assert predicted.items[2].peak_speed < 4.5 < 7.0 < predicted.items[4].peak_speed < 8.6


@BOTH
def test_a_corner_costs_time_and_is_named(autopilot: Autopilot) -> None:
    straight = fly(autopilot, change_speed(6.0), waypoint(place(0, 100), 30.0), waypoint(place(0, 200), 30.0))
    bent = fly(autopilot, change_speed(6.0), waypoint(place(0, 100), 30.0), waypoint(place(100, 100), 30.0))
    assert bent.total_s > straight.total_s + (0.5 if autopilot is Autopilot.PX4 else -0.5)
    assert "corner 90 deg" in bent.items[2].reason
    assert "corner" not in straight.items[2].reason


@BOTH
def test_reasons_name_the_hold_the_stop_and_the_short_leg(autopilot: Autopilot) -> None:
    predicted = fly(
        autopilot,
        change_speed(10.0),
        waypoint(place(0, 20), 30.0),
        waypoint(place(0, 120), 30.0, hold_s=5.0),
        waypoint(place(0, 140), 30.0),
    )
    assert "leg shorter than its braking distance" in predicted.items[2].reason
    assert predicted.items[3].reason == "hold"
    assert "stop" in predicted.items[4].reason


@BOTH
def test_headwind_costs_more_than_tailwind_saves(autopilot: Autopilot) -> None:
    legs = (change_speed(9.0), waypoint(place(0, 300), 30.0))
    calm, ahead, behind = (
        lasted(fly(autopilot, *legs, wind=wind), 3) for wind in (Wind(), Wind(5.0, 0.0), Wind(5.0, 180.0))
    )
    assert behind <= calm < ahead
    assert ahead - calm > calm - behind


@BOTH
def test_a_wind_that_cannot_be_flown_against_is_an_error(autopilot: Autopilot) -> None:
    with refuses("unreachable"):
        fly(autopilot, waypoint(place(0, 300), 30.0), wind=Wind(25.0, 0.0))


@pytest.mark.parametrize(("speed", "seq"), [(10.0, 3), (12.0, 1)])
def test_a_wind_that_px4_cannot_fly_against_is_named_as_the_cause(speed: float, seq: int) -> None:
    with refuses(
        "unreachable", "", f"item {seq}, ", f"the wind of {speed:g} m/s is stronger than the 9.8 m/s"
    ) as error:
        fly(Autopilot.PX4, change_speed(9.0), waypoint(place(0, 300), 30.0), wind=Wind(speed, 0.0))
    assert "MPC_TILTMAX_AIR" in str(error.value.hint)


def test_wind_is_named_for_where_it_comes_from() -> None:
    west = Wind(4.0, 270.0)
    assert (west.east, west.north) == (pytest.approx(4.0), pytest.approx(0.0, abs=1e-12))


@pytest.mark.parametrize(("new", "old"), [(new, old) for new, (old, _) in ARDUCOPTER_BOOK.renamed.items()])
def test_arducopters_new_names_mean_the_same_as_the_old(new: str, old: str) -> None:
    value = 1.7 * ARDUCOPTER_BOOK.moving.get(old, 100.0) or 40.0
    assert copter_limits({new: value / ARDUCOPTER_BOOK.renamed[new][1]}) == copter_limits({old: value})


@BOTH
@pytest.mark.parametrize("value", [0.0, -3.0, math.nan])
def test_a_parameter_without_sense_is_named(autopilot: Autopilot, value: float) -> None:
    name = {Autopilot.ARDUPILOT: "WPNAV_JERK", Autopilot.PX4: "MPC_JERK_AUTO"}[autopilot]
    with refuses("bad-input", name):
        fly(autopilot, waypoint(place(0, 50), 30.0), **{name: value})  # type: ignore[arg-type]


@BOTH
def test_the_greatest_tilt_and_drag_limit_what_can_be_asked_for(autopilot: Autopilot) -> None:
    fast: dict[str, Any] = {"MPC_XY_VEL_MAX": 20.0} if autopilot is Autopilot.PX4 else {}
    predicted = fly(autopilot, change_speed(18.0), waypoint(place(0, 600), 30.0), **fast)
    assert 9.0 < predicted.items[2].peak_speed < 11.5
    if autopilot is Autopilot.ARDUPILOT:
        assert "drag at the greatest tilt" in predicted.items[2].reason


@BOTH
def test_landing_where_one_is_and_landing_elsewhere(autopilot: Autopilot) -> None:
    there = fly(autopilot, waypoint(place(0, 60), 30.0), land(place(0, 60)))
    farther = fly(autopilot, waypoint(place(0, 60), 30.0), land(place(0, 160)))
    landing_here = Item(Command.NAV_LAND, Frame.GLOBAL_RELATIVE_ALT)
    if autopilot.guidance.zero_is_here:
        here = fly(autopilot, waypoint(place(0, 60), 30.0), landing_here)
        assert here.total_s == pytest.approx(there.total_s, rel=0.03)
    else:
        with refuses("position-missing"):
            fly(autopilot, waypoint(place(0, 60), 30.0), landing_here)
    assert farther.total_s > there.total_s + 8.0
    assert there.track.points[-1, 2] == pytest.approx(0.0, abs=0.1)


@BOTH
def test_return_to_launch_ends_on_the_ground_at_home(autopilot: Autopilot) -> None:
    predicted = fly(autopilot, waypoint(place(80, 60), 30.0), return_to_launch())
    assert math.hypot(*predicted.track.points[-1, :2]) < 2.5
    assert predicted.track.points[-1, 2] == pytest.approx(0.0, abs=0.1)
    assert list(predicted.track.times) == sorted(predicted.track.times)


def test_arducopter_counts_whole_seconds_of_a_hold() -> None:
    times = [lasted(fly(Autopilot.ARDUPILOT, waypoint(place(0, 60), 30.0, hold_s=hold)), 2) for hold in (3.0, 3.9, 4.0)]
    assert times[1] == pytest.approx(times[0])
    assert times[2] == pytest.approx(times[0] + 1.0)


def test_px4_waits_for_its_yaw_where_an_item_names_a_heading() -> None:
    def headed(yaw: float) -> Item:
        there = place(0, 4)
        return Item(
            Command.NAV_WAYPOINT, Frame.GLOBAL_RELATIVE_ALT, (0, 0, 0, yaw), there.latitude_deg, there.longitude_deg, 30
        )

    first = Item(
        Command.NAV_WAYPOINT, Frame.GLOBAL_RELATIVE_ALT, (0, 0, 0, 0.0), HOME.latitude_deg, HOME.longitude_deg, 30
    )
    ahead, about = (fly(Autopilot.PX4, first, headed(yaw)).total_s for yaw in (0.0, 180.0))
    assert about > ahead + 0.5


def test_px4_takes_off_straight_up_and_then_flies_to_the_take_off_item() -> None:
    mission = Mission(HOME, (takeoff(place(0.0, 400.0), 30.0), land(place(0.0, 400.0))), Autopilot.PX4)
    points = estimate(mission).track.points
    climbing, level = points[points[:, 2] < 28.0], np.hypot(*points.T[:2])
    up = climbing[: np.argmax(np.hypot(*climbing.T[:2]) > 5.0)]
    assert len(up) > 50
    assert np.hypot(*up.T[:2]).max() < 5.0
    assert level.max() == pytest.approx(400.0, abs=3.0)
    assert points[level < 300.0][:, 2].max() < 32.0


def test_splines_are_quicker_on_arducopter_and_straight_on_px4() -> None:
    places = [place(15.0 * n, 8.0 * math.sin(n)) for n in range(1, 8)]
    end = waypoint(place(120.0, 0.0), 30.0)
    points, splines = ([kind(p, 30.0) for p in places] for kind in (waypoint, spline_waypoint))
    copter = [fly(Autopilot.ARDUPILOT, change_speed(8.0), *items, end) for items in (points, splines)]
    assert copter[1].total_s < 0.8 * copter[0].total_s
    px4 = [fly(Autopilot.PX4, change_speed(8.0), *items, end) for items in (points, splines)]
    assert px4[1].total_s == px4[0].total_s
    assert any("PX4 knows no splines" in remark for remark in px4[1].remarks)


@BOTH
def test_unmodeled_commands_are_remarked(autopilot: Autopilot) -> None:
    odd = Item(Command.NAV_ALTITUDE_WAIT, Frame.MISSION)
    there = place(0, 40)
    terrain = Item(
        Command.NAV_WAYPOINT, Frame.GLOBAL_TERRAIN_ALT, (0, 0, 0, math.nan), there.latitude_deg, there.longitude_deg, 30
    )
    predicted = fly(autopilot, odd, terrain)
    assert "item 2: command 83 is not modeled and counts as no time" in predicted.remarks
    assert "item 3: height over terrain taken as height over home" in predicted.remarks


@BOTH
def test_an_empty_mission_takes_no_time(autopilot: Autopilot) -> None:
    predicted = estimate(Mission(HOME, (), autopilot))
    assert (predicted.total_s, predicted.items) == (0.0, ())


@BOTH
def test_loitering_for_a_time_is_counted_and_without_end_refused(autopilot: Autopilot) -> None:
    there = place(0, 60)
    at = (there.latitude_deg, there.longitude_deg, 30.0)
    loiter = Item(Command.NAV_LOITER_TIME, Frame.GLOBAL_RELATIVE_ALT, (20.0, 0.0, 0.0, 0.0), *at)
    delay = Item(Command.NAV_DELAY, Frame.MISSION, (7.0, -1.0, -1.0, -1.0))
    predicted = fly(autopilot, loiter, delay)
    plain = fly(autopilot, waypoint(there, 30.0))
    assert predicted.total_s == pytest.approx(plain.total_s + 27.0, abs=2.0)
    with refuses("endless-flight", "item 2"):
        fly(autopilot, Item(Command.NAV_LOITER_UNLIM, Frame.GLOBAL_RELATIVE_ALT, (0.0, 0.0, 0.0, 0.0), *at))


@given(st.integers(1, 2_000_000_000))
def test_a_seed_goes_on_as_whole_numbers_do(seed: int) -> None:
    first, second = seed, seed
    noise = (float(seed), float(seed))
    for _ in range(50):
        first, second = first * 40014 % 2147483563, second * 40692 % 2147483399
        noise = normal(*noise)[:2]
        assert noise == (first, second)
