import math
import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest
from hypothesis import given

from ipoa_mission.autopilot.autopilot import Autopilot, registered
from ipoa_mission.checks.check import check_mission, sound_part
from ipoa_mission.finding import Severity
from ipoa_mission.forecast.forecast import Forecast
from ipoa_mission.geodesy import Geodetic
from ipoa_mission.mission.items import (
    FenceCircle,
    FencePolygon,
    Item,
    Mission,
    change_speed,
    land,
    return_to_launch,
    spline_waypoint,
    takeoff,
    waypoint,
)
from ipoa_mission.mission.mission_io import read_mission
from ipoa_mission.mission.positions import check_positions
from ipoa_mission.scenario import read_scenario
from ipoa_mission.wind import Wind
from tests.finding_codes import codes_of
from tests.mission_strategies import missions
from tests.px4_waypoints import PX4_117
from tests.recorded_flights import FLIGHTS, read_flight

FILES = Path(__file__).parents[1] / "mission" / "files"
SHIPPED = Path(__file__).parents[2] / "missions"
PX4, ARDUPILOT = Autopilot.PX4, Autopilot.ARDUPILOT
HOME = Geodetic(39.101, 121.82, 20.0)
NORTH = Geodetic(39.102, 121.82)
EAST = Geodetic(39.101, 121.822)
UP = takeoff(HOME, 20.0)
DOWN = return_to_launch()
AWAY = waypoint(NORTH, 20.0)
AREA = FencePolygon(((39.100, 121.819), (39.100, 121.823), (39.103, 121.823), (39.103, 121.819)))


def flight(*items: Item, autopilot: Autopilot = PX4, home: Geodetic = HOME) -> Mission:
    return Mission(home, items, autopilot, firmware_version=PX4_117.get(autopilot))


#: A mission and its findings.
FOUND: dict[str, tuple[Mission, list[str]]] = {
    "nothing is wrong": (flight(UP, change_speed(5.0), AWAY, DOWN), []),
    "nothing to do": (flight(), ["error empty"]),
    "spline on px4": (flight(UP, spline_waypoint(NORTH, 20.0), DOWN), ["error command-not-taken 2"]),
    "unknown command": (flight(UP, Item(31999, 2), DOWN, autopilot=ARDUPILOT), ["error command-not-taken 2"]),
    "fence item in the mission": (flight(UP, Item(5001, 0), DOWN), ["error command-not-taken 2"]),
    "terrain on px4": (flight(UP, replace(AWAY, frame=10), DOWN), ["error frame-not-taken 2"]),
    "local frame": (flight(UP, replace(AWAY, frame=1), DOWN, autopilot=ARDUPILOT), ["error frame-not-taken 2"]),
    "waypoint without a frame on px4": (flight(UP, replace(AWAY, frame=2), DOWN), ["error frame-without-place 2"]),
    "waypoint without a frame on ardupilot": (
        flight(UP, replace(AWAY, frame=2), DOWN, autopilot=ARDUPILOT),
        ["warning frame-without-place 2"],
    ),
    "fractional hold on ardupilot": (
        flight(UP, waypoint(NORTH, 20.0, hold_s=2.5), DOWN, autopilot=ARDUPILOT),
        ["warning hold-rounded 2"],
    ),
    "fractional hold on px4": (flight(UP, waypoint(NORTH, 20.0, hold_s=2.5), DOWN), []),
    "hold beyond sixteen bits": (
        flight(UP, waypoint(NORTH, 20.0, hold_s=70000.0), DOWN, autopilot=ARDUPILOT),
        ["error hold 2"],
    ),
    "hold of more than a day": (flight(UP, waypoint(NORTH, 20.0, hold_s=86_401.0), DOWN), ["error hold 2"]),
    "delay of more than a day": (flight(UP, AWAY, Item(93, 2, (1e6, 0.0, 0.0, 0.0)), DOWN), ["error hold 3"]),
    "hold without end": (
        flight(UP, waypoint(NORTH, 20.0, hold_s=math.inf), DOWN, autopilot=ARDUPILOT),
        ["error param-too-large 2", "error hold 2"],
    ),
    "hold in the past": (flight(UP, waypoint(NORTH, 20.0, hold_s=-1.0), DOWN), ["error hold 2"]),
    "hold that is no number": (flight(UP, waypoint(NORTH, 20.0, hold_s=math.nan), DOWN), ["error hold 2"]),
    "infinite param": (flight(UP, replace(AWAY, params=(0.0, math.inf, 0.0, 0.0)), DOWN), ["error param-too-large 2"]),
    "no speed": (flight(UP, change_speed(0.0), AWAY, DOWN), ["error speed 2"]),
    "jump beyond the end": (flight(UP, AWAY, Item(177, 2, (9.0, 1.0, 0.0, 0.0)), DOWN), ["error jump-target 3"]),
    "jump to itself": (flight(UP, AWAY, Item(177, 2, (3.0, 1.0, 0.0, 0.0)), DOWN), ["error jump-target 3"]),
    "jump for ever": (
        flight(UP, AWAY, Item(177, 2, (2.0, -1.0, 0.0, 0.0)), DOWN, autopilot=ARDUPILOT),
        ["warning jump-without-end 3"],
    ),
    "no take-off on ardupilot": (flight(AWAY, DOWN, autopilot=ARDUPILOT), ["error takeoff-not-first 1"]),
    "no take-off on px4": (flight(AWAY, DOWN), ["warning takeoff-missing 1"]),
    "late take-off": (flight(AWAY, UP, DOWN), ["error takeoff-not-first 1"]),
    "speed and delay before the take-off": (flight(change_speed(5.0), Item(93, 2, (3.0, 0.0, 0.0, 0.0)), UP, DOWN), []),
    "low take-off on px4": (flight(takeoff(HOME, 1.5), AWAY, DOWN), ["warning takeoff-low 1"]),
    "take-off to home on px4": (flight(takeoff(HOME, 0.0), AWAY, DOWN), ["error takeoff-low 1"]),
    "take-off below the mission's own radius": (
        flight(takeoff(HOME, 5.9), AWAY, DOWN).with_parameters({"NAV_MC_ALT_RAD": 5.0}),
        ["warning takeoff-low 1"],
    ),
    "take-off above the mission's own radius": (
        flight(takeoff(HOME, 1.5), AWAY, DOWN).with_parameters({"NAV_MC_ALT_RAD": 0.4}),
        [],
    ),
    "take-off to nowhere": (flight(takeoff(HOME, 0.0), AWAY, DOWN, autopilot=ARDUPILOT), ["warning takeoff-low 1"]),
    "ends in the air": (flight(UP, AWAY), ["warning ends-in-the-air 2"]),
    "latitude": (flight(UP, replace(AWAY, latitude_deg=95.0), DOWN), ["error position-out-of-range 2"]),
    "longitude": (flight(UP, replace(AWAY, longitude_deg=200.0), DOWN), ["error position-out-of-range 2"]),
    "position that is no number": (
        flight(UP, replace(AWAY, latitude_deg=math.nan), DOWN),
        ["error position-out-of-range 2"],
    ),
    "null island": (flight(UP, replace(AWAY, latitude_deg=0.0, longitude_deg=0.0), DOWN), ["error position-missing 2"]),
    "land here on px4": (flight(UP, AWAY, Item(21, 3)), ["error position-missing 3"]),
    "land here on ardupilot": (flight(UP, AWAY, Item(21, 3), autopilot=ARDUPILOT), []),
    "another continent": (flight(UP, replace(AWAY, longitude_deg=-121.82), DOWN), ["error too-far 2"]),
    "a home on another continent": (
        flight(UP, *(replace(there, longitude_deg=-121.82) for there in (AWAY, DOWN)), autopilot=ARDUPILOT),
        ["warning home-elsewhere 0"],
    ),
    "another town": (flight(UP, replace(AWAY, latitude_deg=39.301), DOWN), ["warning far 2"]),
    "altitude that is no number": (flight(UP, replace(AWAY, altitude=math.nan), DOWN), ["error altitude-missing 2"]),
    "into space": (flight(UP, replace(AWAY, altitude=12000.0), DOWN), ["error height-absurd 2"]),
    "below home": (flight(UP, replace(AWAY, altitude=-3.0), DOWN), ["warning below-home 2"]),
    "no altitude given": (flight(UP, replace(AWAY, altitude=0.0), DOWN), ["warning below-home 2"]),
    "height taken for AMSL": (
        flight(UP, replace(AWAY, frame=0, altitude=30.0), DOWN, home=replace(HOME, altitude=584.0)),
        ["error height-absurd 2"],
    ),
    "into the terrain": (
        flight(UP, replace(AWAY, frame=10, altitude=-5.0), DOWN, autopilot=ARDUPILOT),
        ["error height-over-terrain 2", "warning terrain-data 2"],
    ),
    "above any terrain": (
        flight(UP, replace(AWAY, frame=10, altitude=1e308), DOWN, autopilot=ARDUPILOT),
        ["error height-over-terrain 2", "warning terrain-data 2"],
    ),
    "home on null island": (
        Mission(Geodetic(0.0, 0.0, 20.0), (replace(UP, latitude_deg=0.01, longitude_deg=0.0),)),
        ["error home-unknown 0", "warning ends-in-the-air 1"],
    ),
    "home in the sky": (flight(UP, AWAY, DOWN, home=replace(HOME, altitude=20000.0)), ["error home-altitude 0"]),
    "rally point off the map": (replace(flight(UP, DOWN), rally=(Geodetic(39.1, 221.8, 30.0),)), ["error rally-place"]),
    "rally point underground": (
        replace(flight(UP, DOWN), rally=(replace(NORTH, altitude=-600.0),)),
        ["error rally-height"],
    ),
    "rally point without a height": (
        replace(flight(UP, DOWN), rally=(replace(NORTH, altitude=math.nan),)),
        ["error rally-height"],
    ),
    "rally point down the valley": (replace(flight(UP, DOWN), rally=(replace(NORTH, altitude=-20.0),)), []),
    "rally point down the valley, for ArduPilot": (
        replace(flight(UP, DOWN, autopilot=ARDUPILOT), rally=(replace(NORTH, altitude=-20.0),)),
        [],
    ),
    "fence around everything": (replace(flight(UP, AWAY, DOWN), fence=(AREA,)), []),
    "fence without home": (
        replace(flight(UP, AWAY, DOWN), fence=(FenceCircle((39.102, 121.82), 50.0),)),
        ["error outside-fence 0", "error outside-fence 1", "error outside-fence 3"],
    ),
    "item outside": (
        replace(flight(UP, waypoint(Geodetic(39.104, 121.82), 20.0), DOWN), fence=(AREA,)),
        ["error outside-fence 2"],
    ),
    "item in a hole": (
        replace(flight(UP, AWAY, DOWN), fence=(AREA, FenceCircle((39.102, 121.82), 30.0, inclusion=False))),
        ["error outside-fence 2"],
    ),
    "leg through a hole": (
        replace(flight(UP, AWAY, DOWN), fence=(AREA, FenceCircle((39.1015, 121.82), 10.0, inclusion=False))),
        ["error outside-fence 2", "error outside-fence 3"],
    ),
    "crossed polygon": (
        replace(flight(UP, DOWN), fence=(replace(AREA, vertices=tuple(AREA.vertices[n] for n in (0, 2, 1, 3))),)),
        ["error fence-shape"],
    ),
    "two vertices": (
        replace(flight(UP, DOWN), fence=(replace(AREA, vertices=AREA.vertices[:2]),)),
        ["error fence-shape"],
    ),
    "circle without a radius": (
        replace(flight(UP, DOWN), fence=(FenceCircle((39.1, 121.8), 0.0),)),
        ["error fence-place"],
    ),
    "fence in another country": (
        replace(flight(UP, DOWN), fence=(FenceCircle((47.4, 8.5), 500.0),)),
        ["error fence-place"],
    ),
    "rally point outside": (
        replace(flight(UP, AWAY, DOWN), fence=(AREA,), rally=(Geodetic(39.12, 121.82, 30.0),)),
        ["error outside-fence", "error outside-fence 3"],
    ),
}


def test_a_fence_that_crosses_itself_is_named_so() -> None:
    (finding,) = check_mission(FOUND["crossed polygon"][0])
    assert finding.message == "fence[0]: expected a polygon whose edges do not cross or overlap: self-intersection"


@pytest.mark.parametrize("case", FOUND)
def test_faults_are_found_at_their_item(case: str) -> None:
    mission, findings = FOUND[case]
    assert codes_of(check_mission(mission)) == findings


@pytest.mark.parametrize(
    ("autopilot", "parameters", "wide", "is_inside"),
    [
        (PX4, {}, 80.0, False),  # PX4 #27099: inside all, and an inclusion without home is dropped
        (PX4, {}, 200.0, True),
        (ARDUPILOT, {}, 80.0, False),
        (ARDUPILOT, {"FENCE_OPTIONS": 1.0}, 80.0, False),
        (ARDUPILOT, {"FENCE_OPTIONS": 3.0}, 80.0, True),
    ],
)
def test_two_areas_to_stay_in_mean_what_the_firmware_means(
    autopilot: Autopilot, parameters: dict[str, float], wide: float, is_inside: bool
) -> None:
    areas = (FenceCircle((39.101, 121.82), wide), FenceCircle((39.102, 121.82), wide))
    mission = replace(flight(UP, AWAY, DOWN, autopilot=autopilot), fence=areas, parameters=parameters)
    findings = check_mission(mission)
    assert (not findings) == is_inside
    assert all("inside all inclusions of the fence" in finding.message for finding in findings)


LIMITS = [
    (ARDUPILOT, lambda m, n: replace(m, items=(UP, *[AWAY] * (n - 3), DOWN)), 650, "mission items"),
    (PX4, lambda m, n: replace(m, items=(UP, *[AWAY] * (n - 2), DOWN)), 10_000, "mission items"),
    (ARDUPILOT, lambda m, n: replace(m, fence=(FenceCircle((39.101, 121.82), 900.0),) * n), 70, "fence items"),
    (PX4, lambda m, n: replace(m, fence=(FenceCircle((39.101, 121.82), 900.0),) * n), 64, "fence items"),
    (ARDUPILOT, lambda m, n: replace(m, rally=(replace(NORTH, altitude=30.0),) * n), 46, "rally points"),
    (PX4, lambda m, n: replace(m, rally=(replace(NORTH, altitude=30.0),) * n), 32, "rally points"),
]


@pytest.mark.parametrize(("autopilot", "fill", "most", "expected"), LIMITS)
def test_values_over_the_limit_are_errors_and_values_at_it_are_not(
    autopilot: Autopilot, fill: Callable[[Mission, int], Mission], most: int, expected: str
) -> None:
    empty = flight(UP, AWAY, DOWN, autopilot=autopilot)
    assert check_mission(fill(empty, most)) == ()
    (finding,) = check_mission(fill(empty, most + 1))
    assert codes_of([finding]) == ["error too-many"]
    assert re.search(rf"at most {most} {expected}.* not {most + 1}$", finding.message)


def test_too_long_mission_is_refused_before_its_forecast(monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[Mission] = []
    monkeypatch.setattr(Forecast, "guarantee_if_known", property(lambda forecast: asked.append(forecast.mission)))
    scenario = read_scenario(SHIPPED / "campus.toml")
    for items, predicted in ((647, 1), (648, 0)):
        mission = flight(UP, *[AWAY] * items, DOWN, autopilot=ARDUPILOT)
        refused = "error too-many" in codes_of(check_mission(mission, scenario))
        assert (len(asked), refused) == (predicted, not predicted)
        asked.clear()


def test_the_sound_part_of_a_mission_is_judged_in_the_same_wind() -> None:
    bad = flight(UP, replace(AWAY, latitude_deg=95.0), AWAY, DOWN)
    for scenario in (None, read_scenario(Path(__file__).parents[2] / "missions" / "sitl.toml")):
        forecast = Forecast(bad, scenario, Wind(9.0, 270.0), frozenset({3}))
        sound = sound_part(forecast, check_positions(bad))
        assert sound is not None
        assert (sound.wind, sound.left_out) == (Wind(9.0, 270.0), {2, 3})


@pytest.mark.parametrize(("name", "autopilot"), [("corners-ardupilot", ARDUPILOT), ("hold-px4", PX4)])
def test_a_mission_that_was_flown_is_found_without_fault(name: str, autopilot: Autopilot) -> None:
    mission = read_mission(FILES / f"{name}.waypoints", autopilot)
    assert check_mission(replace(mission, firmware_version=PX4_117.get(autopilot))) == ()


def test_every_recorded_mission_is_found_without_fault() -> None:
    missions = {path.parent.name: read_flight(path.parent).mission for path in FLIGHTS.glob("*/mission.waypoints")}
    findings_by_name = {
        name: check_mission(replace(m, firmware_version=PX4_117.get(m.autopilot))) for name, m in missions.items()
    }
    assert len(findings_by_name) > 40
    assert not {name: findings for name, findings in findings_by_name.items() if findings}


@given(mission=missions())
def test_any_file_content_is_checked_without_an_exception(mission: Mission) -> None:
    findings = check_mission(mission)
    order = [finding.severity is Severity.WARNING for finding in findings]
    assert order == sorted(order), "errors come first"
    assert all(finding.seq is None or 0 <= finding.seq <= len(mission.items) for finding in findings)


def test_both_autopilots_take_the_missions_that_the_package_makes() -> None:
    for autopilot in registered():
        for contingency in (return_to_launch(), land(NORTH)):
            assert (
                check_mission(
                    flight(UP, change_speed(8.0), AWAY, waypoint(EAST, 30.0), contingency, autopilot=autopilot)
                )
                == ()
            )
    assert check_mission(flight(UP, spline_waypoint(NORTH, 20.0), DOWN, autopilot=ARDUPILOT)) == ()


@pytest.mark.parametrize("autopilot", [PX4, ARDUPILOT])
def test_a_speed_in_centimeters_is_found_unless_the_vehicle_is_that_fast(autopilot: Autopilot) -> None:
    fast = flight(UP, change_speed(800.0), AWAY, DOWN, autopilot=autopilot)
    assert codes_of(check_mission(fast)) == ["error speed 2"]
    assert "8 m/s" in check_mission(fast)[0].message
    brisk = flight(UP, change_speed(44.0), AWAY, DOWN, autopilot=autopilot)
    own = {"MPC_XY_VEL_MAX": 45.0} if autopilot is PX4 else {"WPNAV_SPEED": 4500.0}
    assert codes_of(check_mission(brisk)) == ["error speed 2"]
    assert codes_of(check_mission(brisk.with_parameters(own))) == []
