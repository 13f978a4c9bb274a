from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from ipoa_mission.autopilot.autopilot import Autopilot, registered
from ipoa_mission.autopilot.commands import JUMPS, Command, Frame
from ipoa_mission.autopilot.firmware_tables import Firmware
from ipoa_mission.autopilot.version import Version
from ipoa_mission.checks.check import check, check_mission
from ipoa_mission.finding import Severity
from ipoa_mission.forecast.forecast import Forecast
from ipoa_mission.geodesy import Geodetic, LocalFrame
from ipoa_mission.mission.items import Item, Mission, change_speed, return_to_launch, spline_waypoint, takeoff, waypoint
from ipoa_mission.scenario import Scenario

HOME = Geodetic(47.397742, 8.545594, 488.0)
FRAME = LocalFrame(HOME)


def at(east: float, north: float) -> Geodetic:
    return FRAME.geodetic(np.array([east, north, 0.0]))


FIRST, SECOND, LAST = (waypoint(at(*place), 20.0) for place in ((0, 30), (0, 90), (-40, 60)))
TABLES = [
    pytest.param(autopilot, autopilot.firmware(Version(*series)), id=f"{autopilot}-{series[0]}.{series[1]}")
    for autopilot in registered()
    for series in autopilot.tables.series
]
STOPS_FOR_IT = 2.5  # a corner is not cut where a command is passed over [m]


@cache
def world_of(autopilot: Autopilot) -> Scenario:
    home = {"latitude_deg": HOME.latitude_deg, "longitude_deg": HOME.longitude_deg, "altitude_amsl": HOME.altitude}
    mast = {"kind": "cylinder", "name": "mast", "east": 60.0, "north": 60.0, "radius": 5.0, "height": 50.0}
    start, goal = ({"east": east, "north": north, "up": 20.0} for east, north in ((0.0, 0.0), (-40.0, 60.0)))
    vehicle = {"autopilot": str(autopilot)}
    return Scenario.from_dict({"home": home, "start": start, "goal": goal, "vehicle": vehicle, "obstacles": [mast]})


def clearance_is_known(mission: Mission) -> bool:
    forecast = Forecast(mission, world_of(mission.autopilot))
    errors = {finding.code for finding in check(forecast) if finding.severity is Severity.ERROR}
    unknown = bool(errors & {"way-unknown", "never-reached", "command-never-flown"})
    if unknown:
        assert forecast.guarantee_if_known is None
        assert forecast.proof_if_known is None
    return not unknown


@pytest.mark.parametrize(("autopilot", "firmware"), TABLES)
def test_command_is_modeled_or_harmless_or_clearance_is_unknown(autopilot: Autopilot, firmware: Firmware) -> None:
    known, plain = autopilot.command_effects, Mission(HOME, (takeoff(HOME, 20.0), FIRST, LAST), autopilot)
    newest = autopilot.firmware().version
    straight = Forecast(plain).predicted(noise_free=True).track.points
    for command in sorted({*firmware.placed, *firmware.plain} - JUMPS):
        placed = command in firmware.placed
        item = Item(command, Frame.GLOBAL_RELATIVE_ALT if placed else Frame.MISSION, (3.0, 3.0, 3.0, 0.0))
        if placed:
            item = replace(
                item, latitude_deg=at(60, 60).latitude_deg, longitude_deg=at(60, 60).longitude_deg, altitude=20.0
            )
        mission = replace(plain, items=(plain.items[0], FIRST, item, LAST), firmware_version=firmware.version)
        assert clearance_is_known(mission) == (known.why_unknown(command, item.params) is None), command
        if command in known.still and firmware.version == newest:
            flown = Forecast(mission).predicted(noise_free=True).track.points
            nearest = np.linalg.norm(flown[:, None] - straight, axis=2).min(axis=1)
            assert nearest.max() < STOPS_FOR_IT, command


def after_a_spline(item: Item) -> Mission:
    spline = spline_waypoint(at(0, 90), 20.0)
    return Mission(HOME, (takeoff(HOME, 20.0), FIRST, spline, item, LAST, return_to_launch()), Autopilot.ARDUPILOT)


@pytest.mark.parametrize(
    ("command", "params", "dives"),
    [
        (Command.NAV_DELAY, (5.0, -1.0, -1.0, -1.0), True),  # as ArduCopter 4.8.0-dev flew it
        (Command.NAV_DELAY, (5.0, 0.0, 0.0, 0.0), False),
        (Command.NAV_SET_YAW_SPEED, (90.0, 5.0, 0.0, 0.0), True),
        (Command.NAV_ALTITUDE_WAIT, (50.0, 2.0, 0.0, 0.0), True),
        (Command.NAV_RETURN_TO_LAUNCH, (0.0, 0.0, 0.0, 0.0), False),
        (Command.NAV_GUIDED_ENABLE, (0.0, 0.0, 0.0, 0.0), False),
    ],
)
def test_a_spline_before_a_command_without_a_place_is_flown_or_an_error(
    command: Command, params: tuple[float, float, float, float], dives: bool
) -> None:
    mission = after_a_spline(Item(command, Frame.MISSION, params))
    assert ("never-reached" in {finding.code for finding in check_mission(mission)}) == dives
    assert clearance_is_known(mission) != dives


def test_a_payload_place_above_the_waypoint_before_has_no_known_clearance() -> None:
    beside = at(40, 60)
    where = beside.latitude_deg, beside.longitude_deg
    for height, placed in ((30.0, False), (20.0, True), (0.0, True)):
        item = Item(Command.NAV_PAYLOAD_PLACE, Frame.GLOBAL_RELATIVE_ALT, (0.0,) * 4, *where, height)
        mission = Mission(HOME, (takeoff(HOME, 20.0), FIRST, item, LAST, return_to_launch()), Autopilot.ARDUPILOT)
        assert clearance_is_known(mission) == placed


@pytest.mark.parametrize(("place", "is_known"), [((-40, 60), True), ((-5, 40), False)])
def test_a_spline_that_turns_back_has_no_clearance(place: tuple[float, float], is_known: bool) -> None:
    """ArduCopter 4.8.0-dev: 0.4 m off the forecast at a turn of 127 degrees, 1.5 m at a hairpin."""
    assert clearance_is_known(after_a_spline(waypoint(at(*place), 20.0))) is is_known


@pytest.mark.parametrize(("radius", "is_known"), [(150.0, True), (300.0, False)])
def test_a_large_circle_has_no_clearance(radius: float, is_known: bool) -> None:
    """ArduCopter 4.8.0-dev: 0.5 m off the forecast at a radius of 150 m, 1.0 m at 300 m."""
    circle = replace(waypoint(at(0, 500), 20.0), command=Command.NAV_LOITER_TURNS, params=(1.0, 0.0, radius, 0.0))
    mission = Mission(HOME, (takeoff(HOME, 20.0), FIRST, circle, return_to_launch()), Autopilot.ARDUPILOT)
    assert clearance_is_known(mission) is is_known


@pytest.mark.parametrize(
    ("gap", "speed", "is_known"), [(10, 8.0, False), (20, 8.0, False), (30, 8.0, True), (10, 3.0, True)]
)
@pytest.mark.parametrize("hold_s", [0.0, 1.0])
def test_a_spline_too_short_to_stop_on_has_no_clearance(gap: int, speed: float, is_known: bool, hold_s: float) -> None:
    """ArduCopter 4.8.0-dev at 8 m/s: 1.4, 0.7, 0.1 m beyond the forecast after held splines of 10, 20 and 30 m."""
    *splines, last = (spline_waypoint(at(0, gap * n), 20.0, hold_s if n == 4 else 0.0) for n in range(1, 5))
    mission = Mission(
        HOME, (takeoff(HOME, 20.0), change_speed(speed), *splines, last, return_to_launch()), Autopilot.ARDUPILOT
    )
    assert clearance_is_known(mission) is is_known
    at_once = Mission(HOME, (takeoff(HOME, 20.0), change_speed(speed), last, return_to_launch()), Autopilot.ARDUPILOT)
    assert clearance_is_known(at_once)


@pytest.mark.parametrize(
    ("later", "is_known"),
    [
        ((), True),
        ((Item(Command.DO_CHANGE_SPEED, Frame.MISSION, (2.0, 8.0, -1.0, 0.0)),), True),  # the climb's
        ((change_speed(8.0), Item(Command.DO_JUMP, Frame.MISSION, (3.0, 1.0, 0.0, 0.0))), False),
    ],
)
def test_the_speed_on_such_a_spline_is_the_greatest_that_may_be(later: tuple[Item, ...], is_known: bool) -> None:
    """The second pass of a jump flies at the later speed; the speed of climbs does not count."""
    *splines, last = (spline_waypoint(at(0, 10 * n), 20.0, 1.0 if n == 4 else 0.0) for n in range(1, 5))
    items = (takeoff(HOME, 20.0), change_speed(3.0), *splines, last, *later, return_to_launch())
    assert clearance_is_known(Mission(HOME, items, Autopilot.ARDUPILOT)) is is_known
