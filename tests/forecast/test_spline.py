import json
from pathlib import Path

import numpy as np
import pytest
import scipy
import shapely

from ipoa_mission.autopilot.autopilot import Autopilot
from ipoa_mission.autopilot.commands import Command
from ipoa_mission.autopilot.failsafe import FlightStage
from ipoa_mission.checks.check import check_mission
from ipoa_mission.forecast.forecast import estimate
from ipoa_mission.forecast.itinerary.flown_legs import flown_legs, join
from ipoa_mission.geodesy import LocalFrame
from ipoa_mission.mission.items import Mission, return_to_launch, spline_waypoint, takeoff, waypoint
from ipoa_mission.mission.mission_io import read_mission_file
from ipoa_mission.routing.build import build_mission
from ipoa_mission.routing.resample import Route
from ipoa_mission.scenario import Scenario, parse_scenario
from ipoa_mission.simulator.fly import fly_built_in
from tests.examples import some

FLIGHTS = Path(__file__).parents[1] / "data" / "flights"
WORLD = """
home = { latitude_deg = 47.4, longitude_deg = 8.5, altitude_amsl = 400.0 }
start = { east = 0.0, north = 0.0, up = 20.0 }
goal = { east = 120.0, north = 0.0, up = 20.0 }
bounds = { east = [-50.0, 170.0], north = [-90.0, 90.0], up = [-5.0, 70.0] }
vehicle = { radius = 0.5, autopilot = "ardupilot", cruise_speed = 10.0 }
obstacles = [{ kind = "cylinder", name = "mast", east = EAST, north = NORTH, radius = 0.5, height = 40.0 }]
"""
ZIGZAG = ((60.0, 0.0), (60.0, 60.0), (120.0, 60.0), (120.0, 0.0))


def zigzag(mast: tuple[float, float], is_spline: bool) -> tuple[Mission, Scenario]:
    text = WORLD.replace("EAST", f"{mast[0]:.3f}").replace("NORTH", f"{mast[1]:.3f}")
    scenario = parse_scenario(text, Path("world.toml"))
    home, fly_to = scenario.frame.home, spline_waypoint if is_spline else waypoint
    ways = [fly_to(scenario.frame.geodetic(np.array([*place, 0.0])), 20.0) for place in ZIGZAG]
    return Mission(home, (takeoff(home, 20.0), *ways, return_to_launch()), Autopilot.ARDUPILOT), scenario


@pytest.mark.parametrize("name", ["ways_spl12", "ways_spl25", "ways_spl40"])
def test_arducopter_flew_along_the_curve_and_not_along_its_chords(name: str) -> None:
    folder = FLIGHTS / f"{name}-ardupilot"
    mission = read_mission_file(folder / "mission.waypoints", Autopilot.ARDUPILOT).mission
    frame = LocalFrame(mission.home)
    legs = [leg for leg in flown_legs(mission, frame) if mission.items[leg.seq - 1].command == 82]
    curve = shapely.LineString(join(legs)[0][:, :2])
    chords = shapely.LineString(np.array([leg.points[i, :2] for leg in legs for i in (0, -1)]))

    done = {int(seq): at for seq, at in json.loads((folder / "flight.json").read_text())["item_done_s"].items()}
    trace = np.loadtxt(folder / "trace.csv", delimiter=",", skiprows=1)
    splines = [n for n, item in enumerate(mission.items, 1) if item.command == Command.NAV_SPLINE_WAYPOINT]
    between = (trace[:, 0] > done[splines[0]]) & (trace[:, 0] < done[splines[-1]])
    flown = frame.to_local(trace[between, 1], trace[between, 2], mission.home.altitude + trace[between, 3])
    near, far = (shapely.distance(line, shapely.points(flown[:, :2])).max() for line in (curve, chords))
    assert near < 1.4  # a copter at 10 m/s lags behind its reference
    assert near < 0.6 * far


def test_mast_on_a_spline_is_found_but_not_one_on_its_chord() -> None:
    mission, scenario = zigzag((-40.0, -80.0), is_spline=True)
    legs = [leg for leg in flown_legs(mission, scenario.frame) if leg.stage is FlightStage.ROUTE]
    curve, _ = join(legs)
    chords = shapely.LineString([(0.0, 0.0), *ZIGZAG])
    away = shapely.distance(chords, shapely.points(curve[:, :2]))
    mast = tuple(curve[np.argmax(away), :2])
    assert away.max() > 5.0

    findings = [str(finding) for finding in check_mission(*zigzag(mast, is_spline=True))]
    assert any("the leg to it: 0.50 m inside mast" in text for text in findings), findings
    assert not any("mast" in str(finding) for finding in check_mission(*zigzag(mast, is_spline=False)))


def test_the_chords_stand_for_the_curve_as_closely_as_they_say() -> None:
    mission, scenario = zigzag((-40.0, -80.0), is_spline=True)
    for leg in flown_legs(mission, scenario.frame):
        if leg.chord_error > 0:
            u = np.linspace(0.0, 1.0, len(leg.points))
            cubic = scipy.interpolate.CubicSpline(u, leg.points)  # the leg's own, through points of it
            fine = cubic(np.linspace(0, 1, 2000))
            apart = shapely.distance(shapely.LineString(leg.points[:, :2]), shapely.points(fine[:, :2]))
            assert 0.2 * leg.chord_error < apart.max() < leg.chord_error


@pytest.mark.parametrize("end", some(2, ["long curve", "short curve", "straight"]))
def test_place_after_a_spline_is_that_of_the_model(end: str) -> None:
    """On a curve it brakes by half of its acceleration and within the last leg only: a short one is overrun."""
    _, scenario = zigzag((-40.0, -80.0), is_spline=True)
    east = {"straight": (30, 60, 90, 120), "long curve": (30, 60, 90, 150), "short curve": (30, 60, 90, 110)}[end]
    points = np.array([(0.0, 0.0, 20.0), *((x, 2.0 * (-1) ** n, 20.0) for n, x in enumerate(east))])
    mission = build_mission(Route(points, spline=True, brakes_on_curve=end != "straight"), scenario)
    assert [item.command for item in mission.items[2:]] == [82, 82, 82, 16 if end == "straight" else 82, 20]
    flight, predicted = fly_built_in(mission), estimate(mission)
    latitude, longitude = (np.array([getattr(s, k) for s in flight.path]) for k in ("latitude_deg", "longitude_deg"))
    local = scenario.frame.to_local(latitude, longitude, 0.0)
    times, done = np.array([sample.time_s for sample in flight.path]), [item.done_s for item in predicted.items]
    ahead = (points[-1] - points[-2])[:2] / np.linalg.norm((points[-1] - points[-2])[:2])
    overrun, expected = (
        ((places[np.abs(at - goal) < 8.0, :2] - points[-1, :2]) @ ahead).max()
        for places, at, goal in (
            (local, times, flight.item_reached_s[5]),
            (predicted.track.points, predicted.track.times, done[5]),
        )
    )
    assert overrun == pytest.approx(expected, abs=1.6)
    if end == "short curve":
        assert overrun == pytest.approx(3.88, abs=0.2), "as real ArduCopter 4.7 flew this mission in its simulator"
    else:
        assert overrun < 1.0
    way_home = flight.item_reached_s[6] - flight.item_reached_s[5]
    assert way_home == pytest.approx(done[6] - done[5], rel=0.04)
