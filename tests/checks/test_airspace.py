import re
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ipoa_mission.autopilot.autopilot import Autopilot, registered
from ipoa_mission.autopilot.commands import Command
from ipoa_mission.autopilot.failsafe import FlightStage
from ipoa_mission.checks.check import check_mission
from ipoa_mission.checks.unsafe import NotAtStart, begun_at, check_start
from ipoa_mission.forecast.forecast import Forecast, estimate
from ipoa_mission.forecast.itinerary.flown_legs import Leg, flown_legs
from ipoa_mission.forecast.leg_limits import broken_limits
from ipoa_mission.geodesy import Geodetic
from ipoa_mission.geometry import Points, Vector
from ipoa_mission.ground import Ground
from ipoa_mission.mission.items import Item, Mission, land, return_to_launch, takeoff
from ipoa_mission.scenario import Scenario, parse_scenario
from ipoa_mission.simulator.fly import fly_built_in
from ipoa_mission.world.terrain import Flat
from tests.examples import examples
from tests.finding_codes import codes_of
from tests.px4_waypoints import waypoint
from tests.refused import refuses

PX4, ARDUPILOT = Autopilot.PX4, Autopilot.ARDUPILOT
WORLD = """
home = { latitude_deg = 47.4, longitude_deg = 8.5, altitude_amsl = 400.0 }
start = { east = 0.0, north = 0.0, up = 20.0 }
goal = { east = 100.0, north = 0.0, up = 20.0 }
safety_distance = 2.0
bounds = { east = [-50.0, 150.0], north = [-50.0, 50.0], up = [-5.0, 70.0] }
vehicle = { radius = 0.5, autopilot = "px4", parameters = { RTL_RETURN_ALT = 25.0 } }

[[obstacles]]
kind = "box"
name = "hall"
east = 50.0
north = 20.0
width = 20.0
depth = 10.0
height = 30.0
"""


def world(text: str = WORLD, **changes: str) -> Scenario:
    for old, new in changes.items():
        text = text.replace(old, new)
    return parse_scenario(text, Path("world.toml"))


def place(scenario: Scenario, east: float, north: float) -> Geodetic:
    return scenario.frame.geodetic(np.array([east, north, 0.0]))


def flight(scenario: Scenario, *points: tuple[float, float, float], autopilot: Autopilot = PX4) -> Mission:
    home = scenario.frame.home
    ways = [waypoint(place(scenario, east, north), height) for east, north, height in points]
    return Mission(home, (takeoff(home, 20.0), *ways, return_to_launch()), autopilot)


def seen(mission: Mission, scenario: Scenario) -> list[str]:
    return codes_of(check_mission(mission, scenario))


def corners(leg: Leg) -> list[list[float]]:
    return np.round(leg.points, 2).tolist()


@pytest.mark.parametrize("command", [Command.NAV_PAYLOAD_PLACE, Command.NAV_LOITER_TO_ALT])
def test_the_leg_to_a_payload_place_or_a_loiter_to_altitude_is_checked(command: Command) -> None:
    scenario = world(px4="ardupilot", RTL_RETURN_ALT="RTL_ALT")
    there = replace(waypoint(place(scenario, 100.0, 20.0), 20.0), command=command, params=(0.0, 0.0, 0.0, 0.0))
    through = flight(scenario, (0.0, 20.0, 20.0), (100.0, 0.0, 20.0), autopilot=ARDUPILOT)
    through = replace(through, items=(*through.items[:2], there, *through.items[2:]))
    assert "error leg-too-near 3" in seen(through, scenario)

    flown, predicted = fly_built_in(through), estimate(through)
    assert predicted.items[2].duration_s == pytest.approx(flown.item_reached_s[2] - flown.item_reached_s[1], abs=0.6)
    assert predicted.items[2].duration_s > 10.0
    if command == Command.NAV_PAYLOAD_PLACE:
        down, up = (
            leg for leg in flown_legs(through, scenario.frame) if leg.seq == 3 and leg.stage is FlightStage.LANDING
        )
        assert corners(down)[-1] == corners(up)[0]
        assert corners(up)[-1] == corners(down)[0]


def test_the_legs_of_a_flight_are_climb_cruise_return_and_landing() -> None:
    scenario = world()
    high = {"RTL_RETURN_ALT": 50.0}
    legs = flown_legs(flight(scenario, (60.0, 0.0, 20.0)).with_parameters(high), scenario.frame)
    assert [(leg.seq, leg.stage) for leg in legs] == [
        (1, FlightStage.TAKEOFF),
        (2, FlightStage.ROUTE),
        (3, FlightStage.RETURN),
        (3, FlightStage.LANDING),
    ]
    assert corners(legs[0]) == [[0, 0, 0], [0, 0, 20]]
    assert corners(legs[1]) == [[0, 0, 20], [60, 0, 20]]
    assert corners(legs[2]) == [[60, 0, 20], [60, 0, 50], [0, 0, 50]]
    assert corners(legs[3]) == [[0, 0, 50], [0, 0, 0]]


@pytest.mark.parametrize(
    ("autopilot", "parameters", "east", "tops"),
    [
        (ARDUPILOT, {}, 60.0, [20.0]),  # RTL_ALT is 15 m: it stays where it is
        (ARDUPILOT, {"RTL_ALT": 4000.0}, 60.0, [40.0]),
        (ARDUPILOT, {"RTL_ALT_M": 40.0}, 60.0, [40.0]),
        (ARDUPILOT, {"RTL_ALT": 4000.0}, 10.0, [30.0]),  # RTL_CONE_SLOPE is 3
        (ARDUPILOT, {"RTL_ALT": 4000.0, "RTL_CONE_SLOPE": 0.0}, 10.0, [40.0]),
        (ARDUPILOT, {"RTL_CLIMB_MIN": 500.0}, 60.0, [25.0]),
        (PX4, {}, 45.0, [30.0]),  # RTL_RETURN_ALT is 30 m on every multicopter
        (PX4, {"RTL_RETURN_ALT": 60.0}, 45.0, [60.0]),
        (PX4, {}, 9.0, [20.0]),  # RTL_CONE_ANG is 45 degrees, RTL_MIN_DIST 10 m
        (PX4, {"RTL_CONE_ANG": 0.0, "RTL_RETURN_ALT": 60.0}, 9.0, [60.0]),
        (PX4, {"RTL_RETURN_ALT": 10.0}, 45.0, [20.0]),
    ],
)
def test_the_way_home_is_as_high_as_the_autopilots_parameters_say(
    autopilot: Autopilot, parameters: dict[str, float], east: float, tops: list[float]
) -> None:
    scenario = world()
    mission = flight(scenario, (east, 0.0, 20.0), autopilot=autopilot).with_parameters(parameters)
    ways = [leg for leg in flown_legs(mission, scenario.frame) if leg.stage is FlightStage.RETURN]
    assert [way.points[:, 2].max() for way in ways] == pytest.approx(tops, abs=0.01)
    assert [way.alternative for way in ways] == [False, True][: len(ways)]


def test_ardupilot_climbs_in_place_and_px4_then_flies_to_the_take_off_item() -> None:
    scenario = world()
    items = (takeoff(place(scenario, 10.0, 0.0), 20.0), waypoint(place(scenario, 60.0, 0.0), 20.0))
    starts = {
        autopilot: [
            corners(leg)[0] for leg in flown_legs(Mission(scenario.frame.home, items, autopilot), scenario.frame)
        ]
        for autopilot in registered()
    }
    assert starts[ARDUPILOT] == [[0, 0, 0], [0, 0, 20]]
    assert starts[PX4] == [[0, 0, 0], [0, 0, 20], [10, 0, 20]]


def test_a_jump_adds_the_leg_it_makes_once() -> None:
    scenario = world()
    mission = flight(scenario, (60.0, 0.0, 20.0), (60.0, 40.0, 20.0))
    looped = replace(mission, items=(*mission.items[:3], Item(177, 2, (2.0, 5.0, 0.0, 0.0)), mission.items[3]))
    legs = flown_legs(looped, scenario.frame)
    assert [leg.seq for leg in legs[:4]] == [1, 2, 3, 2]
    assert corners(legs[3]) == [[60, 40, 20], [60, 0, 20]]
    assert corners(legs[4])[0] == [60, 40, 20]


def test_a_landing_is_flown_level_and_then_down_to_the_ground() -> None:
    scenario = world()
    mission = flight(scenario, (60.0, 0.0, 30.0))
    mission = replace(mission, items=(*mission.items[:2], land(place(scenario, 80.0, 0.0))))
    level, down = flown_legs(mission, scenario.frame, ground=Ground(Flat(7.0)))[-2:]
    assert corners(level) == [[60, 0, 30], [80, 0, 30]]
    assert corners(down) == [[80, 0, 30], [80, 0, 7]]


class Slope:
    def height(self, points: Points) -> Vector:
        return 0.1 * points[:, 0]


def test_a_leg_above_terrain_follows_the_ground() -> None:
    scenario = world()
    mission = flight(scenario, (0.0, 0.0, 20.0), (60.0, 0.0, 10.0), autopilot=ARDUPILOT)
    mission = replace(mission, items=(*mission.items[:2], replace(mission.items[2], frame=10)))
    leg = flown_legs(mission, scenario.frame, ground=Ground(Slope()))[-1]
    assert len(leg.points) == 13
    assert np.allclose(leg.points[:, 2] - 0.1 * leg.points[:, 0], np.linspace(20.0, 10.0, 13), atol=0.01)


def test_a_rally_point_is_where_it_returns_as_high_above_it_as_above_home() -> None:
    scenario = world()
    mission = replace(flight(scenario, (60.0, 0.0, 20.0)), rally=(replace(place(scenario, 60.0, 30.0), altitude=10.0),))
    ways = [corners(leg)[-1] for leg in flown_legs(mission, scenario.frame) if leg.stage is FlightStage.RETURN]
    assert ways == [[60, 30, 40], [0, 0, 30]]  # home as well, where rally points are not taken


def test_a_clear_flight_is_found_without_fault() -> None:
    scenario = world()
    assert seen(flight(scenario, (60.0, 0.0, 20.0)), scenario) == []


def test_a_leg_through_a_building_is_an_error_that_names_it_and_the_place() -> None:
    scenario = world()
    through = check_mission(flight(scenario, (100.0, 40.0, 20.0)), scenario)
    assert codes_of(through) == ["error leg-too-near 2", "error leg-too-near 3"]
    assert all("5.00 m inside hall at east " in finding.message for finding in through)


def test_a_place_in_the_ground_is_an_error_of_the_leg_to_it_alone() -> None:
    scenario = world()
    assert seen(flight(scenario, (80.0, 0.0, -3.0)), scenario).count("error leg-too-near 2") == 1
    assert "error leg-too-near 3" not in seen(flight(scenario, (80.0, 0.0, -3.0)), scenario)


def test_a_way_home_through_a_building_names_the_altitude_that_clears_it() -> None:
    """The hall is 30 m high, 2.5 m are required: of steps of 5 m, 35 m is the first that clears it."""
    scenario = world()
    px4, ardupilot = (flight(scenario, (100.0, 40.0, 20.0), autopilot=autopilot) for autopilot in (PX4, ARDUPILOT))
    (hint,) = [f.hint for f in check_mission(px4, scenario) if f.hint]
    assert hint.startswith("RTL_RETURN_ALT = 40 makes it clear, ")
    higher = world(**{"RTL_RETURN_ALT = 25.0": "RTL_RETURN_ALT = 40.0"})
    assert "error leg-too-near 3" in seen(px4, scenario)
    assert "leg-too-near 3" not in " ".join(seen(px4, higher))
    ardupilot_world = world(**{"px4": "ardupilot", "RTL_RETURN_ALT = 25.0": "RTL_ALT = 1500"})
    (hint,) = [f.hint for f in check_mission(ardupilot, ardupilot_world) if f.hint]
    assert hint.startswith("RTL_ALT = 3500 makes it clear, ")


def test_a_way_home_that_only_comes_near_is_a_warning() -> None:
    scenario = world(
        **{
            'autopilot = "px4"': 'autopilot = "ardupilot"',
            "RTL_RETURN_ALT = 25.0": "RTL_ALT = 3150.0",
            "up = [-5.0, 70.0]": "up = [-5.0, 31.0]",
        }
    )
    mission = flight(scenario, (0.0, 40.0, 20.0), (100.0, 40.0, 20.0), autopilot=ARDUPILOT)
    findings = check_mission(mission, scenario)
    near = [finding for finding in findings if finding.code.endswith("-too-near")]
    assert codes_of(near) == ["warning return-too-near 3", *["warning leg-too-near 4"] * 2]
    assert re.search(r"1.50 m from hall at .* at least 2.50 m required", near[1].message)
    assert "0.50 m beyond the upper bound" in near[2].message


def test_a_way_home_on_which_a_hull_may_touch_is_an_error() -> None:
    scenario = world(**{"RTL_RETURN_ALT = 25.0": "RTL_RETURN_ALT = 32.0"})
    findings = check_mission(flight(scenario, (0.0, 40.0, 20.0), (100.0, 40.0, 20.0)), scenario)
    assert codes_of(findings) == ["error flights-too-near 4", "warning leg-too-near 4"]
    assert "99 % of flights keep 0.02 m (predicted 1.98 m)" in findings[0].message


def test_a_climb_beside_a_wall_is_a_warning_and_into_a_roof_an_error() -> None:
    beside = world(**{"east = 50.0\nnorth = 20.0": "east = 12.0\nnorth = 0.0", "height = 30.0": "height = 15.0"})
    findings = check_mission(flight(beside, (-30.0, 0.0, 20.0)), beside)
    climbs = [finding for finding in findings if finding.code == "leg-too-near"]
    assert codes_of(climbs) == ["warning leg-too-near 1", "warning leg-too-near 3"]
    assert all(": 2.00 m from hall at east 0.0, north 0.0" in finding.message for finding in climbs)
    into = world(
        **{
            'kind = "box"': 'kind = "sphere"\nup = 15.0\nradius = 4.0',
            "east = 50.0\nnorth = 20.0": "east = 2.0\nnorth = 0.0",
        }
        | {"width = 20.0\ndepth = 10.0\nheight = 30.0": ""}
    )
    (roof, *_) = check_mission(flight(into, (-30.0, 0.0, 20.0)), into)
    assert codes_of([roof]) == ["error leg-too-near 1"]
    assert "2.00 m inside hall at east 0.0, north 0.0, up 15.0 m" in roof.message


def test_a_leg_into_a_hill_is_an_error() -> None:
    hill = (
        'terrain = { kind = "analytic", peaks = [{ height = 40.0, east = 60.0, north = -30.0, a = 30.0, b = 30.0 }] }'
    )
    scenario = world(WORLD.replace("[[obstacles]]", hill + "\n[[obstacles]]", 1))
    (near, *_) = check_mission(flight(scenario, (60.0, -30.0, 50.0), (100.0, -30.0, 9.0)), scenario)
    (below, *_) = check_mission(flight(scenario, (60.0, -30.0, 30.0)), scenario)
    assert codes_of([near, below]) == ["error leg-too-near 3", "error leg-too-near 2"]
    assert re.search(r"2.24 m .* at east 100.0, north -30.0, up 9.0 m, at least 2.50 m required", near.message)
    assert "10.13 m under the ground" in below.message


def test_heights_above_ground_are_limited_where_the_scenario_says_so() -> None:
    scenario = world(WORLD.replace("[[obstacles]]", "planning = { max_height_above_ground = 25.0 }\n[[obstacles]]", 1))
    findings = check_mission(flight(scenario, (60.0, 0.0, 30.0)), scenario)
    assert codes_of(findings) == ["error leg-too-near 2", "error flights-too-near 3", "warning leg-too-near 3"]
    assert all(re.search(r"30\.0.* at most 25.00 m required", finding.message) for finding in findings)


def test_a_leg_steeper_than_the_limit_is_an_error_and_a_take_off_is_none() -> None:
    steep = "planning = { max_climb_angle_deg = 20.0 }\n[[obstacles]]"
    scenario = world(WORLD.replace("[[obstacles]]", steep, 1))
    assert seen(flight(scenario, (60.0, 0.0, 40.0)), scenario) == []
    (climb,) = check_mission(flight(scenario, (50.0, 0.0, 40.0)), scenario)
    assert codes_of([climb]) == ["error leg-too-near 2"]
    assert "21.80 deg of climb at east 0.0" in climb.message


def test_a_leg_out_of_bounds_is_an_error_with_the_place() -> None:
    scenario = world()
    (out, *_) = check_mission(flight(scenario, (160.0, 0.0, 20.0)), scenario)
    assert codes_of([out]) == ["error leg-too-near 2"]
    assert "10.00 m beyond the east bound at east 160.0, north 0.0, up 20.0 m" in out.message


@pytest.mark.parametrize(("short", "limits"), [(0.01, []), (0.03, ["obstacles"]), (0.3, ["obstacles"])])
def test_a_limit_is_broken_by_more_than_the_rounding_of_a_file(short: float, limits: list[str]) -> None:
    """Places in a file are whole 1e-7 degrees, 1.1 cm: a leg may be short by 2 cm, not by more."""
    north = 15.0 - 2.5 + short  # of the hall's south wall; the radius and the safety distance are 2.5 m
    leg = Leg(1, FlightStage.ROUTE, np.array([(0.0, north, 20.0), (100.0, north, 20.0)]))
    assert [check.limit for check in broken_limits(leg, world())] == limits


def test_another_home_is_a_warning() -> None:
    scenario = world()
    mission = flight(scenario, (60.0, 0.0, 20.0))
    codes = ["warning home-differs 0", "warning home-not-on-ground 0"]
    assert seen(replace(mission, home=replace(mission.home, altitude=405.0)), scenario) == codes


SPOT = st.tuples(st.floats(-40, 140), st.floats(-40, 40), st.floats(5, 45))


@settings(max_examples=examples(30))
@given(points=st.lists(SPOT, min_size=1, max_size=4))
def test_an_error_is_found_exactly_where_sampling_the_legs_finds_one(points: list[tuple[float, float, float]]) -> None:
    scenario = world()
    mission = flight(scenario, *points)
    errors = {
        finding.seq
        for finding in check_mission(mission, scenario)
        if finding.code == "leg-too-near" and finding.severity == "error" and finding.seq != len(mission.items)
    }
    path = [np.array([0.0, 0.0, 20.0]), *map(np.array, points)]
    for seq, (a, b) in enumerate(pairwise(path), start=2):
        along = np.linspace(0, 1, max(2, int(np.linalg.norm(b - a) / 0.02)))[:, None]
        where = a + along * (b - a)
        outside = np.abs(where - [50.0, 20.0, 15.0]) - [10.0, 5.0, 15.0]
        distance = np.linalg.norm(np.maximum(outside, 0), axis=1) + np.minimum(outside.max(axis=1), 0)
        nearest = min(distance.min(), where[:, 2].min())
        if abs(nearest - 2.5) > 0.06:  # rounding of positions, and the sampling itself
            begins_there = min(distance[0], where[0, 2]) - nearest < 0.06 and seq - 1 in errors  # is found once
            assert (seq in errors) == (nearest < 2.5) or begins_there


def test_a_collision_where_two_legs_meet_is_said_once() -> None:
    scenario = world()
    mission = flight(scenario, (0.0, 0.0, 20.0), (50.0, 20.0, 20.0), (100.0, 0.0, 20.0))
    findings = [finding for finding in check_mission(mission, scenario) if finding.code == "leg-too-near"]
    assert [finding.seq for finding in findings] == [3]
    assert "inside hall" in findings[0].message


def test_a_leg_that_a_jump_flies_back_names_both_of_its_ends() -> None:
    scenario = world()
    south, north = (0.0, 0.0, 20.0), (100.0, 40.0, 20.0)
    up, *ways, down = flight(scenario, south, (100.0, 0.0, 20.0), north).items
    back = Item(Command.DO_JUMP, 2, (2.0, 1.0, 0.0, 0.0))
    mission = Mission(scenario.frame.home, (up, *ways, back, down), PX4)
    findings = [
        finding
        for finding in check_mission(mission, scenario)
        if "the leg to it from item 4, after a jump" in finding.message
    ]
    assert codes_of(findings) == ["error leg-too-near 2"]


def test_a_flight_from_a_later_item_keeps_the_clearance_of_flights() -> None:
    scenario = world()
    mission = flight(scenario, (0.0, -20.0, 20.0), (100.0, -20.0, 20.0), (100.0, 20.0, 20.0))
    with refuses("not-at-start", "", "item 4", "hall", "99 %", "1.73 m", "2.50 m"):
        check_start(mission, scenario, 3, mission.home)
    (clear,) = check_start(mission, scenario, 2, mission.home)
    assert clear.endswith("the way from there was checked and is clear")
    with refuses("not-at-start", "", "item 4", "hall", "99 %", "2.50 m"):
        check_start(mission, scenario, 3, place(scenario, -2.0, 0.0))
    (clear,) = check_start(mission, scenario, 2, place(scenario, 0.0, -4.0))
    assert clear.endswith("the way from there was checked and is clear")


def test_a_start_away_from_home_names_the_time_from_there() -> None:
    scenario = world()
    mission = flight(scenario, (0.0, -20.0, 20.0), (100.0, -20.0, 20.0), (100.0, 20.0, 20.0))
    away = place(scenario, 0.0, -40.0)
    for within in (scenario, None):
        seconds = Forecast(begun_at(mission, 2, away), within).estimate.total_s
        try:
            (words,) = check_start(mission, within, 2, away)
        except NotAtStart as error:
            words = str(error)
        assert f"40.0 m from the mission's home ({seconds:.1f} s are estimated from there)" in words
        assert abs(seconds - Forecast(begun_at(mission, 2), within).estimate.total_s) > 2.0
    (at_home,) = check_start(mission, scenario, 2, mission.home)
    assert "estimated" not in at_home
