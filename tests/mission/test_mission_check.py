"""Each rule of `check` with its exact words, and silence about missions that real autopilots have flown."""

import math
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest
from hypothesis import given

from ipoa_mission.checks.check import Severity, check_mission
from ipoa_mission.forecast.forecast import Forecast
from ipoa_mission.items import (
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
from ipoa_mission.mission.files import read_mission
from ipoa_mission.scenario import read_scenario
from ipoa_mission.vehicles.autopilot import Autopilot, autopilot_named, registered
from ipoa_mission.world.frame import Geodetic
from tests.mission.mission_strategies import missions

FILES = Path(__file__).parent / "files"
SHIPPED = Path(__file__).parents[2] / "missions"
PX4, ARDUPILOT = Autopilot.PX4, Autopilot.ARDUPILOT
HOME = Geodetic(39.101, 121.82, 20.0)
NORTH = Geodetic(39.102, 121.82)
EAST = Geodetic(39.101, 121.822)
UP = takeoff(HOME, 20.0)
DOWN = return_to_launch()
AWAY = waypoint(NORTH, 20.0)
AREA = FencePolygon(((39.100, 121.819), (39.100, 121.823), (39.103, 121.823), (39.103, 121.819)))

NEEDS_TERRAIN = (
    "warning: item 2: above terrain: ArduCopter is armed only with terrain data, which a ground station sends or its "
    "card holds, or with a range finder (RNGFND1_TYPE)"
)


def flight(*items: Item, autopilot: Autopilot = PX4, home: Geodetic = HOME) -> Mission:
    return Mission(home, items, autopilot)


#: A mission, and all that is said of it.
SAID: dict[str, tuple[Mission, list[str]]] = {
    "nothing is wrong": (flight(UP, change_speed(5.0), AWAY, DOWN), []),
    "nothing to do": (flight(), ["error: the mission: expected at least one item, but there is none"]),
    "spline on px4": (
        flight(UP, spline_waypoint(NORTH, 20.0), DOWN),
        ["error: item 2 (NAV_SPLINE_WAYPOINT): PX4 1.18 does not take NAV_SPLINE_WAYPOINT"],
    ),
    "unknown command": (
        flight(UP, Item(31999, 2), DOWN, autopilot=ARDUPILOT),
        ["error: item 2 (command 31999): ArduPilot 4.7 does not take command 31999"],
    ),
    "fence item in the mission": (
        flight(UP, Item(5001, 0), DOWN),
        [
            "error: item 2 (NAV_FENCE_POLYGON_VERTEX_INCLUSION): PX4 1.18 does not take "
            "NAV_FENCE_POLYGON_VERTEX_INCLUSION "
            "in a mission: it belongs into the fence or rally list"
        ],
    ),
    "terrain on px4": (
        flight(UP, replace(AWAY, frame=10), DOWN),
        [
            "error: item 2 (NAV_WAYPOINT): expected an altitude above home (frame 3) or AMSL (frame 0), "
            "not an altitude above terrain"
        ],
    ),
    "local frame": (
        flight(UP, replace(AWAY, frame=1), DOWN, autopilot=ARDUPILOT),
        ["error: item 2 (NAV_WAYPOINT): expected an altitude above home (frame 3) or AMSL (frame 0), not frame 1"],
    ),
    "waypoint without a frame on px4": (
        flight(UP, replace(AWAY, frame=2), DOWN),
        ["error: item 2 (NAV_WAYPOINT): expected a frame with a position, not frame 2"],
    ),
    "waypoint without a frame on ardupilot": (
        flight(UP, replace(AWAY, frame=2), DOWN, autopilot=ARDUPILOT),
        [
            "warning: item 2 (NAV_WAYPOINT): expected a frame with a position, not frame 2, "
            "which ArduPilot takes for AMSL"
        ],
    ),
    "fractional hold on ardupilot": (
        flight(UP, waypoint(NORTH, 20.0, hold_s=2.5), DOWN, autopilot=ARDUPILOT),
        ["warning: item 2 (NAV_WAYPOINT): param1: ArduPilot holds for whole seconds: 2 s, not 2.5"],
    ),
    "fractional hold on px4": (flight(UP, waypoint(NORTH, 20.0, hold_s=2.5), DOWN), []),
    "hold beyond sixteen bits": (
        flight(UP, waypoint(NORTH, 20.0, hold_s=70000.0), DOWN, autopilot=ARDUPILOT),
        ["error: item 2 (NAV_WAYPOINT): param1: expected a hold of at most 65535 s, not 70000"],
    ),
    "hold in the past": (
        flight(UP, waypoint(NORTH, 20.0, hold_s=-1.0), DOWN),
        ["error: item 2 (NAV_WAYPOINT): param1: expected a hold of zero seconds or more, not -1"],
    ),
    "hold that is no number": (
        flight(UP, waypoint(NORTH, 20.0, hold_s=math.nan), DOWN),
        ["error: item 2 (NAV_WAYPOINT): param1: expected a hold in seconds, not NaN, at which PX4 stays for ever"],
    ),
    "infinite param": (
        flight(UP, replace(AWAY, params=(0.0, math.inf, 0.0, 0.0)), DOWN),
        ["error: item 2 (NAV_WAYPOINT): param2: expected a number that fits in single precision, not inf"],
    ),
    "no speed": (
        flight(UP, change_speed(0.0), AWAY, DOWN),
        ["error: item 2 (DO_CHANGE_SPEED): param2: expected a speed above zero, not 0"],
    ),
    "jump beyond the end": (
        flight(UP, AWAY, Item(177, 2, (9.0, 1.0, 0.0, 0.0)), DOWN),
        ["error: item 3 (DO_JUMP): param1: expected the number of an item, 1 to 4, not 9"],
    ),
    "jump to itself": (
        flight(UP, AWAY, Item(177, 2, (3.0, 1.0, 0.0, 0.0)), DOWN),
        ["error: item 3 (DO_JUMP): param1: expected another item, not the jump itself"],
    ),
    "jump for ever": (
        flight(UP, AWAY, Item(177, 2, (2.0, -1.0, 0.0, 0.0)), DOWN, autopilot=ARDUPILOT),
        ["warning: item 3 (DO_JUMP): param2: -1 repeats never end: the mission flies until someone ends it"],
    ),
    "no take-off on ardupilot": (
        flight(AWAY, DOWN, autopilot=ARDUPILOT),
        ["error: item 1 (NAV_WAYPOINT): expected the take-off first, not NAV_WAYPOINT"],
    ),
    "no take-off on px4": (
        flight(AWAY, DOWN),
        ["warning: item 1 (NAV_WAYPOINT): the mission has no take-off: it serves a vehicle that already flies"],
    ),
    "late take-off": (
        flight(AWAY, UP, DOWN),
        ["error: item 1 (NAV_WAYPOINT): expected the take-off first, not NAV_WAYPOINT"],
    ),
    "speed and delay before the take-off": (flight(change_speed(5.0), Item(93, 2, (3.0, 0.0, 0.0, 0.0)), UP, DOWN), []),
    "low take-off on px4": (
        flight(takeoff(HOME, 1.5), AWAY, DOWN),
        ["error: item 1 (NAV_TAKEOFF): expected a take-off to more than 1.8 m above home, not to 1.5 m"],
    ),
    "take-off to nowhere": (
        flight(takeoff(HOME, 0.0), AWAY, DOWN, autopilot=ARDUPILOT),
        ["warning: item 1 (NAV_TAKEOFF): a take-off to 0 m above home: ArduCopter climbs 1 m all the same"],
    ),
    "ends in the air": (
        flight(UP, AWAY),
        ["warning: item 2 (NAV_WAYPOINT): the mission ends in the air, where the vehicle stays"],
    ),
    "latitude": (
        flight(UP, replace(AWAY, latitude_deg=95.0), DOWN),
        ["error: item 2 (NAV_WAYPOINT): expected a latitude from -90 to 90 degrees, not 95"],
    ),
    "longitude": (
        flight(UP, replace(AWAY, longitude_deg=200.0), DOWN),
        ["error: item 2 (NAV_WAYPOINT): expected a longitude from -180 to 180 degrees, not 200"],
    ),
    "position that is no number": (
        flight(UP, replace(AWAY, latitude_deg=math.nan), DOWN),
        ["error: item 2 (NAV_WAYPOINT): expected a latitude from -90 to 90 degrees, not nan"],
    ),
    "null island": (
        flight(UP, replace(AWAY, latitude_deg=0.0, longitude_deg=0.0), DOWN),
        ["error: item 2 (NAV_WAYPOINT): expected a position, not latitude 0, longitude 0"],
    ),
    "land here on px4": (
        flight(UP, AWAY, Item(21, 3)),
        ["error: item 3 (NAV_LAND): expected a position: PX4 would fly to latitude 0, longitude 0"],
    ),
    "land here on ardupilot": (flight(UP, AWAY, Item(21, 3), autopilot=ARDUPILOT), []),
    "another continent": (
        flight(UP, replace(AWAY, longitude_deg=-121.82), DOWN),
        ["error: item 2 (NAV_WAYPOINT): expected a position within 100 km of home, not 9196 km"],
    ),
    "a home on another continent": (
        flight(UP, *(replace(there, longitude_deg=-121.82) for there in (AWAY, DOWN)), autopilot=ARDUPILOT),
        ["warning: home: it lies 9196 km from all places of the mission, so it must be armed elsewhere"],
    ),
    "another town": (
        flight(UP, replace(AWAY, latitude_deg=39.301), DOWN),
        ["warning: item 2 (NAV_WAYPOINT): lies 22.2 km from home"],
    ),
    "altitude that is no number": (
        flight(UP, replace(AWAY, altitude=math.nan), DOWN),
        ["error: item 2 (NAV_WAYPOINT): expected an altitude in metres, not nan"],
    ),
    "into space": (
        flight(UP, replace(AWAY, altitude=12000.0), DOWN),
        ["error: item 2 (NAV_WAYPOINT): expected a height from -500 to 10000 m above home, not 12000 m"],
    ),
    "below home": (
        flight(UP, replace(AWAY, altitude=-3.0), DOWN),
        ["warning: item 2 (NAV_WAYPOINT): lies 3 m below home"],
    ),
    "no altitude given": (
        flight(UP, replace(AWAY, altitude=0.0), DOWN),
        ["warning: item 2 (NAV_WAYPOINT): flies at the height of home: has it no altitude?"],
    ),
    "height taken for AMSL": (
        flight(UP, replace(AWAY, frame=0, altitude=30.0), DOWN, home=replace(HOME, altitude=584.0)),
        [
            "error: item 2 (NAV_WAYPOINT): expected a height from -500 to 10000 m above home, not -554 m: "
            "is it meant above home (frame 3), not AMSL (frame 0)?"
        ],
    ),
    "into the terrain": (
        flight(UP, replace(AWAY, frame=10, altitude=-5.0), DOWN, autopilot=ARDUPILOT),
        ["error: item 2 (NAV_WAYPOINT): expected a height above the terrain, not -5 m", NEEDS_TERRAIN],
    ),
    "above any terrain": (
        flight(UP, replace(AWAY, frame=10, altitude=1e308), DOWN, autopilot=ARDUPILOT),
        ["error: item 2 (NAV_WAYPOINT): expected a height above the terrain, not 1e+308 m", NEEDS_TERRAIN],
    ),
    "home on null island": (
        Mission(Geodetic(0.0, 0.0, 20.0), (replace(UP, latitude_deg=0.01, longitude_deg=0.0),)),
        [
            "error: home: expected a position, not latitude 0, longitude 0",
            "warning: item 1 (NAV_TAKEOFF): the mission ends in the air, where the vehicle stays",
        ],
    ),
    "home in the sky": (
        flight(UP, AWAY, DOWN, home=replace(HOME, altitude=20000.0)),
        ["error: home: expected an altitude AMSL from -450 to 9000 m, not 20000"],
    ),
    "rally point off the map": (
        replace(flight(UP, DOWN), rally=(Geodetic(39.1, 221.8, 30.0),)),
        ["error: rally[0]: expected a longitude from -180 to 180 degrees, not 221.8"],
    ),
    "rally point underground": (
        replace(flight(UP, DOWN), rally=(replace(NORTH, altitude=-30.0),)),
        ["error: rally[0]: expected a height above home in metres, not -30"],
    ),
    "fence around everything": (replace(flight(UP, AWAY, DOWN), fence=(AREA,)), []),
    "fence without home": (
        replace(flight(UP, AWAY, DOWN), fence=(FenceCircle((39.102, 121.82), 50.0),)),
        [
            "error: home: expected inside the fence, but it lies outside",
            "error: item 1 (NAV_TAKEOFF): expected inside the fence, but it lies outside",
            "error: item 3 (NAV_RETURN_TO_LAUNCH): expected legs inside the fence, but the way home crosses it",
        ],
    ),
    "item outside": (
        replace(flight(UP, waypoint(Geodetic(39.104, 121.82), 20.0), DOWN), fence=(AREA,)),
        ["error: item 2 (NAV_WAYPOINT): expected inside the fence, but it lies outside"],
    ),
    "item in a hole": (
        replace(flight(UP, AWAY, DOWN), fence=(AREA, FenceCircle((39.102, 121.82), 30.0, inclusion=False))),
        ["error: item 2 (NAV_WAYPOINT): expected inside the fence, but it lies outside"],
    ),
    "leg through a hole": (
        replace(flight(UP, AWAY, DOWN), fence=(AREA, FenceCircle((39.1015, 121.82), 10.0, inclusion=False))),
        [
            "error: item 2 (NAV_WAYPOINT): expected legs inside the fence, but the leg to it crosses it",
            "error: item 3 (NAV_RETURN_TO_LAUNCH): expected legs inside the fence, but the way home crosses it",
        ],
    ),
    "crossed polygon": (
        replace(flight(UP, DOWN), fence=(replace(AREA, vertices=tuple(AREA.vertices[n] for n in (0, 2, 1, 3))),)),
        ["error: fence[0]: expected a polygon with an inside, not with a self-intersection"],
    ),
    "two vertices": (
        replace(flight(UP, DOWN), fence=(replace(AREA, vertices=AREA.vertices[:2]),)),
        ["error: fence[0]: expected a polygon of three vertices or more, not 2"],
    ),
    "circle without a radius": (
        replace(flight(UP, DOWN), fence=(FenceCircle((39.1, 121.8), 0.0),)),
        ["error: fence[0]: expected a radius above zero and up to 100 km, not 0 m"],
    ),
    "fence in another country": (
        replace(flight(UP, DOWN), fence=(FenceCircle((47.4, 8.5), 500.0),)),
        ["error: fence[0]: expected a position within 100 km of home, not 8378 km"],
    ),
    "rally point outside": (
        replace(flight(UP, AWAY, DOWN), fence=(AREA,), rally=(Geodetic(39.12, 121.82, 30.0),)),
        [
            "error: rally[0]: expected inside the fence, but it lies outside",
            "error: item 3 (NAV_RETURN_TO_LAUNCH): expected legs inside the fence, but the way home crosses it",
        ],
    ),
}


@pytest.mark.parametrize("case", SAID)
def test_what_is_wrong_is_said_in_these_words(case: str) -> None:
    mission, messages = SAID[case]
    assert [str(finding) for finding in check_mission(mission)] == messages


@pytest.mark.parametrize(
    ("autopilot", "inside_one_is_enough"), [(PX4, True), (ARDUPILOT, False)], ids=["union", "intersection"]
)
def test_two_areas_to_stay_in_mean_what_the_firmware_means(autopilot: Autopilot, inside_one_is_enough: bool) -> None:
    areas = (FenceCircle((39.101, 121.82), 80.0), FenceCircle((39.102, 121.82), 80.0))
    mission = replace(flight(UP, AWAY, DOWN, autopilot=autopilot), fence=areas)
    assert (not check_mission(mission)) == inside_one_is_enough


LIMITS = [
    (ARDUPILOT, lambda m, n: replace(m, items=(UP, *[AWAY] * (n - 3), DOWN)), 650, "mission items"),
    (PX4, lambda m, n: replace(m, items=(UP, *[AWAY] * (n - 2), DOWN)), 10_000, "mission items"),
    (ARDUPILOT, lambda m, n: replace(m, fence=(FenceCircle((39.101, 121.82), 900.0),) * n), 70, "fence items"),
    (PX4, lambda m, n: replace(m, fence=(FenceCircle((39.101, 121.82), 900.0),) * n), 64, "fence items"),
    (ARDUPILOT, lambda m, n: replace(m, rally=(replace(NORTH, altitude=30.0),) * n), 46, "rally points"),
    (PX4, lambda m, n: replace(m, rally=(replace(NORTH, altitude=30.0),) * n), 32, "rally points"),
]


@pytest.mark.parametrize(("autopilot", "fill", "most", "what"), LIMITS)
def test_what_is_over_the_limit_is_an_error_and_what_is_at_it_is_not(
    autopilot: Autopilot, fill: Callable[[Mission, int], Mission], most: int, what: str
) -> None:
    empty = flight(UP, AWAY, DOWN, autopilot=autopilot)
    assert check_mission(fill(empty, most)) == ()
    (finding,) = check_mission(fill(empty, most + 1))
    assert str(finding).startswith(f"error: the mission: expected at most {most} {what}")
    assert str(finding).endswith(f"not {most + 1}")


def test_what_is_too_long_for_its_autopilot_is_refused_before_its_flight_is_predicted(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    asked: list[Mission] = []
    monkeypatch.setattr(Forecast, "promise_if_known", property(lambda forecast: asked.append(forecast.mission)))
    scenario = read_scenario(SHIPPED / "campus.toml")
    for items, predicted in ((647, 1), (648, 0)):
        mission = flight(UP, *[AWAY] * items, DOWN, autopilot=ARDUPILOT)
        words = [str(finding) for finding in check_mission(mission, scenario)]
        refused = "error: the mission: expected at most 650 mission items for ArduPilot, not 651" in words
        assert (len(asked), refused) == (predicted, not predicted)
        asked.clear()


@pytest.mark.parametrize(("name", "autopilot"), [("corners-ardupilot", ARDUPILOT), ("hold-px4", PX4)])
def test_a_mission_that_was_flown_is_found_without_fault(name: str, autopilot: Autopilot) -> None:
    assert check_mission(read_mission(FILES / f"{name}.waypoints", autopilot)) == ()


FLIGHTS = Path(__file__).parents[1] / "flights"


def test_every_recorded_mission_is_found_without_fault() -> None:
    found = {
        path.parent.name: check_mission(read_mission(path, autopilot_named(path.parent.name.rsplit("-", 1)[1])))
        for path in FLIGHTS.glob("*/mission.waypoints")
    }
    assert len(found) > 40
    assert not {name: findings for name, findings in found.items() if findings}


@given(mission=missions())
def test_whatever_a_file_can_hold_is_checked_without_falling_over(mission: Mission) -> None:
    findings = check_mission(mission)
    order = [finding.severity is Severity.WARNING for finding in findings]
    assert order == sorted(order), "errors come first"
    assert all(finding.seq is None or 0 <= finding.seq <= len(mission.items) for finding in findings)


def test_both_autopilots_take_the_missions_that_the_package_makes() -> None:
    for autopilot in registered():
        for ending in (return_to_launch(), land(NORTH)):
            assert (
                check_mission(flight(UP, change_speed(8.0), AWAY, waypoint(EAST, 30.0), ending, autopilot=autopilot))
                == ()
            )
    assert check_mission(flight(UP, spline_waypoint(NORTH, 20.0), DOWN, autopilot=ARDUPILOT)) == ()
