"""PX4 1.18 may pass waypoints for good: h6_rally flew away in simulation, three times of three."""

from dataclasses import replace

from ipoa_mission.autopilot.autopilot import Autopilot
from ipoa_mission.autopilot.version import Version
from ipoa_mission.checks.check import check_mission
from ipoa_mission.geodesy import Geodetic
from ipoa_mission.mission.items import Mission, land, takeoff, waypoint

HOME = Geodetic(47.397742, 8.545594, 488.0)


def mission(heights: list[float], hold: float, version: Version) -> Mission:
    places = [Geodetic(47.398 + 0.0005 * n, 8.5456, 488.0) for n in range(len(heights))]
    ways = [waypoint(place, height, hold) for place, height in zip(places, heights, strict=True)]
    items = (takeoff(HOME, heights[0]), *ways, land(places[-1]))
    return Mission(HOME, items, Autopilot.PX4, firmware_version=version)


def codes(mission: Mission) -> dict[str, int | None]:
    seq_by_code = {finding.code: finding.seq for finding in check_mission(mission)}
    return {code: seq_by_code[code] for code in ("waypoint-passed", "waypoint-may-be-passed") if code in seq_by_code}


def test_a_waypoint_without_hold_before_a_climb_is_an_error_from_1_18_on() -> None:
    slope = mission([20.0, 20.0, 25.0, 25.0], 0.0, Version(1, 18))
    assert codes(slope) == {"waypoint-passed": 3, "waypoint-may-be-passed": 2}
    assert codes(replace(slope, firmware_version=Version(1, 17))) == {}


def test_level_waypoints_without_hold_warn_but_one_before_landing_fails() -> None:
    assert codes(mission([20.0, 20.0, 20.0], 0.0, Version(1, 18))) == {
        "waypoint-passed": 4,
        "waypoint-may-be-passed": 2,
    }


def test_waypoints_with_a_hold_are_neither() -> None:
    assert codes(mission([20.0, 25.0, 30.0], 0.1, Version(1, 18))) == {}
