from dataclasses import replace

import numpy as np
import pytest

from ipoa_mission.autopilot.autopilot import Autopilot
from ipoa_mission.autopilot.commands import Frame
from ipoa_mission.autopilot.failsafe import Contingency
from ipoa_mission.autopilot.returning import ReturnBy
from ipoa_mission.checks.unsafe import check_start
from ipoa_mission.errors import NotModeled
from ipoa_mission.flight.post_flight import _from_ground
from ipoa_mission.forecast.conformance import ConformanceMonitor
from ipoa_mission.forecast.contingency.contingencies import Contingencies
from ipoa_mission.forecast.deviation.clearance_guarantee import KeptLimit
from ipoa_mission.forecast.forecast import Forecast
from ipoa_mission.geodesy import Geodetic, LocalFrame
from ipoa_mission.mission.items import Mission
from ipoa_mission.report.compare import flown_track
from ipoa_mission.report.drawn_flight import item_legs
from ipoa_mission.scenario import Scenario
from ipoa_mission.simulator.fly import fly_built_in
from ipoa_mission.studio.mission_view import mission_world
from ipoa_mission.studio.plan_answers import expected
from ipoa_mission.wind import Wind
from tests.checks.test_airspace import WORLD, flight, place, seen, world
from tests.forecast.test_flown_contingencies import row_at
from tests.refused import refuses

AUTOPILOTS = (Autopilot.PX4, Autopilot.ARDUPILOT)
PLACE, ABOVE_HOME, AMSL, OVER_TERRAIN = (
    (0.0, 0.0, 0.0),
    Frame.GLOBAL_RELATIVE_ALT,
    Frame.GLOBAL,
    Frame.GLOBAL_TERRAIN_ALT,
)
SIDEWAYS, UP, BOTH = (0.0, 28.0, 0.0), (0.0, 0.0, 5.0), (0.0, 28.0, 5.0)


def moved(mission: Mission, scenario: Scenario, home: tuple[float, float, float]) -> Mission:
    return replace(mission, home=scenario.frame.geodetic(np.array(home)))


def past_the_hall(scenario: Scenario, *home: float) -> Mission:
    """Return a flight past the hall at 3 m, its home moved."""
    east, north = home
    return moved(flight(scenario, (0.0, 12.0, 20.0), (100.0, 12.0, 20.0)), scenario, (east, north, 0.0))


def over_the_hall(scenario: Scenario, autopilot: Autopilot, frame: Frame) -> Mission:
    """Return a flight 6 m above the roof."""
    mission = flight(scenario, (0.0, 20.0, 36.0), (100.0, 20.0, 36.0), autopilot=autopilot)
    altitude = 436.0 if frame is Frame.GLOBAL else 36.0
    first, *ways, last = mission.items
    return replace(mission, items=(first, *(replace(way, frame=int(frame), altitude=altitude) for way in ways), last))


def clearance(forecast: Forecast) -> KeptLimit:
    limit = next(limit for limit in forecast.guarantee.limits if limit.limit == "obstacles" and limit.in_cruise)
    assert limit.to == "hall"
    return limit


@pytest.mark.parametrize(("east", "north"), [(0.0, 0.0), (0.05, 0.0), (-0.7, -0.7), (0.0, 28.0), (0.0, -28.0)])
def test_moving_home_makes_no_clearance_of_the_cruise_better(east: float, north: float) -> None:
    scenario = world()
    in_place = clearance(Forecast(past_the_hall(scenario, 0.0, 0.0), scenario))
    there = clearance(Forecast(past_the_hall(scenario, east, north), scenario))
    assert there.nominal == pytest.approx(3.3, abs=0.1)  # the corner before it is cut
    assert in_place.guaranteed - 0.2 < there.guaranteed < in_place.guaranteed + 0.11  # other noise of eight runs


@pytest.mark.parametrize("autopilot", AUTOPILOTS)
@pytest.mark.parametrize(
    ("frame", "home", "above_roof"),
    [
        *((frame, home, 6.0) for frame in (ABOVE_HOME, AMSL, OVER_TERRAIN) for home in (PLACE, SIDEWAYS)),
        *((ABOVE_HOME, home, 11.0) for home in (UP, BOTH)),
        (ABOVE_HOME, (0.0, 28.0, -3.0), 3.0),
        *((frame, home, 6.0) for frame in (AMSL, OVER_TERRAIN) for home in (UP, BOTH)),
    ],
)
def test_heights_above_home_alone_move_with_home(
    autopilot: Autopilot, frame: Frame, home: tuple[float, float, float], above_roof: float
) -> None:
    scenario = world()
    mission = over_the_hall(scenario, autopilot, frame)
    in_place = clearance(Forecast(mission, scenario))
    forecast = Forecast(moved(mission, scenario, home), scenario)
    there = clearance(forecast)
    assert there.nominal == pytest.approx(above_roof, abs=0.15)
    assert there.guaranteed - in_place.guaranteed == pytest.approx(above_roof - 6.0, abs=0.15)
    legs = min(check.nearest.distance for check in forecast.proof.checks if check.limit == "obstacles")
    assert legs == pytest.approx(above_roof, abs=0.01)
    assert forecast.estimate.track.points[0] == pytest.approx(np.array(home), abs=1e-6)


@pytest.mark.parametrize("autopilot", AUTOPILOTS)
@pytest.mark.parametrize("home", [PLACE, SIDEWAYS, UP, BOTH])
def test_contingencies_and_their_landing_count_from_the_missions_home(
    autopilot: Autopilot, home: tuple[float, float, float]
) -> None:
    scenario = world()
    contingencies = [
        Contingencies(Forecast(moved(over_the_hall(scenario, autopilot, ABOVE_HOME), scenario, at), scenario))
        for at in (PLACE, home)
    ]
    middle_s = [each.forecast.estimate.items[2].done_s - 8.0 for each in contingencies]
    near = []
    for each, time in zip(contingencies, middle_s, strict=True):
        holds = each.samples(Contingency.HOLD)
        around = np.flatnonzero(np.abs(holds.times - time) < 3.0).tolist()
        clearances = [each.paths.exact_clearance(Contingency.HOLD, holds, n) for n in around]
        near.append(min(clearances, key=lambda clearance: clearance.distance))
    in_place, there = near
    assert there.what == in_place.what == "hall"
    assert there.distance - in_place.distance == pytest.approx(home[2], abs=0.15)
    returns = row_at(contingencies[1], Contingency.RTL, middle_s[1])
    assert returns.lands == pytest.approx(home[:2], abs=1e-6)
    way = contingencies[1].paths.at(Contingency.RTL, np.array(middle_s[1:])).paths[0, 0]
    assert way[-1] == pytest.approx([home[0], home[1], 0.0], abs=1e-3)
    assert way[-2, 2] == pytest.approx(home[2] + 36.0, abs=0.1)


def test_a_mission_with_another_home_is_found_where_it_matters() -> None:
    scenario = world()
    mission = over_the_hall(scenario, Autopilot.PX4, ABOVE_HOME)
    assert seen(moved(mission, scenario, (0.5, 0.0, 0.0)), scenario) == []
    assert seen(moved(mission, scenario, SIDEWAYS), scenario) == ["warning home-differs 0"]
    low = seen(moved(mission, scenario, (0.0, 0.0, -4.0)), scenario)  # 2.00 m above the roof, 2.50 m required
    assert "error leg-too-near 3" in low


def test_a_flight_is_compared_in_the_frame_of_its_forecast() -> None:
    scenario = world()
    forecast = Forecast(moved(past_the_hall(scenario, 0.0, 0.0), scenario, BOTH), scenario)
    monitor = ConformanceMonitor(forecast)
    assert monitor.local(forecast.mission.home, 0.0) == pytest.approx(np.array(BOTH), abs=1e-6)
    track = forecast.estimate.track
    for item in forecast.estimate.items:
        assert monitor.see(item.done_s, track.at(np.array([item.done_s]))[0], item.seq - 1) is None


@pytest.mark.parametrize("frame", [ABOVE_HOME, AMSL, OVER_TERRAIN])
def test_a_log_with_another_altitude_of_home_is_judged_from_the_ground(frame: Frame) -> None:
    scenario = world()
    planned = over_the_hall(scenario, Autopilot.PX4, frame)
    higher = [
        replace(item, altitude=item.altitude + 184.0) if item.frame == Frame.GLOBAL else item for item in planned.items
    ]
    logged = moved(replace(planned, items=tuple(higher)), scenario, (0.7, 0.0, 184.0))
    there = clearance(Forecast(_from_ground(logged, scenario), scenario))
    assert there.nominal == pytest.approx(6.0, abs=0.15)


def test_a_vehicle_off_its_home_starts_from_the_ground() -> None:
    scenario = world()
    first, *ways, last = over_the_hall(scenario, Autopilot.PX4, ABOVE_HOME).items
    lower = (first, *(replace(way, altitude=30.0) for way in ways), last)
    mission = moved(replace(over_the_hall(scenario, Autopilot.PX4, ABOVE_HOME), items=lower), scenario, UP)
    (clear,) = check_start(mission, scenario, 1, mission.home)
    assert clear.endswith("the way from there was checked and is clear")
    with refuses("not-at-start", "", "item 3", "hall"):
        check_start(mission, scenario, 1, place(scenario, 0.0, -4.0))


def test_the_ground_is_seen_from_the_missions_home() -> None:
    """A slope of 1 in 10 to the east, and a home 20 m up it."""
    slope = 'terrain = { kind = "grid", east = -100.0, north = -100.0, spacing = 200.0, heights = [[-10.0, 10.0]] }'
    scenario = world(slope.replace("[[-10.0, 10.0]]", "[[-10.0, 10.0], [-10.0, 10.0]]") + WORLD)
    there = LocalFrame(scenario.frame.geodetic(np.array([20.0, 0.0, 2.0])))
    places = np.array([[0.0, 0.0], [50.0, 0.0], [-120.0, 30.0]])
    assert scenario.ground_from(there)(places) == pytest.approx([0.0, 5.0, -12.0], abs=1e-2)
    assert scenario.ground_from(scenario.frame)(places) == pytest.approx(scenario.ground(places), abs=0.0)


@pytest.mark.parametrize("offset", [SIDEWAYS, BOTH, (20_000.0, -3_000.0, 400.0)])
def test_a_move_between_frames_is_one_through_degrees_and_back(offset: tuple[float, float, float]) -> None:
    here = LocalFrame(Geodetic(47.4, 8.5, 400.0))
    there = LocalFrame(here.geodetic(np.array(offset)))
    points = np.array([[[0.0, 0.0, 0.0], [300.0, -40.0, 20.0]], [[-3.0, 4.0, 5.0], [5000.0, 60.0, -7.0]]])
    seen_there = there.moved(points, here)
    assert here.moved(there.moved(np.zeros(3), here), there) == pytest.approx(np.zeros(3), abs=1e-6)
    assert there.local(here.geodetic(points[1, 1])) == pytest.approx(seen_there[1, 1], abs=1e-6)
    apart_m = np.linalg.norm(points[1, 1] - points[0, 1])
    assert np.linalg.norm(seen_there[1, 1] - seen_there[0, 1]) == pytest.approx(apart_m, abs=1e-6)
    assert here.moved(points, here) is points


@pytest.mark.parametrize("autopilot", AUTOPILOTS)
@pytest.mark.parametrize("home", [PLACE, SIDEWAYS, UP, BOTH])
def test_returns_lead_to_a_rally_point_at_its_place(autopilot: Autopilot, home: tuple[float, float, float]) -> None:
    scenario = world()
    rally = replace(place(scenario, 100.0, -20.0), altitude=10.0)  # above home
    mission = replace(over_the_hall(scenario, autopilot, ABOVE_HOME), rally=(rally,))
    forecast = Forecast(moved(mission, scenario, home), scenario)
    contingencies = Contingencies(forecast)
    returns = row_at(contingencies, Contingency.RTL, forecast.estimate.items[2].done_s - 1.0)
    assert returns.goal == "rally point 1"
    assert returns.lands == pytest.approx((100.0, -20.0), abs=1e-3)
    path = contingencies.paths.at(Contingency.RTL, np.array([contingencies.in_air[1] / 2])).paths[0, -1]
    assert path[-2] == pytest.approx([100.0, -20.0, 36.0 + home[2]], abs=0.2)


@pytest.mark.parametrize("home", [SIDEWAYS, UP, BOTH])
def test_a_return_along_the_mission_ends_at_its_home(home: tuple[float, float, float]) -> None:
    scenario = world()
    mission = over_the_hall(scenario, Autopilot.PX4, ABOVE_HOME).with_parameters({"RTL_TYPE": 2.0})
    ends = []
    for at in (PLACE, home):
        forecast = Forecast(moved(mission, scenario, at), scenario)
        paths = Contingencies(forecast).paths
        assert paths.routes.kinds == (ReturnBy.MISSION_REVERSED,)
        time = np.array([forecast.estimate.items[2].done_s - 8.0])
        ends.append(paths.at(Contingency.RTL, time).paths[0, -1])
    in_place, there = ends
    assert there[-3:, :2] - in_place[-3:, :2] == pytest.approx(np.array([[0, 0], home[:2], home[:2]]), abs=0.2)
    assert there[-3:, 2] - in_place[-3:, 2] == pytest.approx(np.full(3, home[2]), abs=0.2)


@pytest.mark.parametrize("home", [SIDEWAYS, BOTH])
def test_report_and_studio_draw_the_flight_from_its_home(home: tuple[float, float, float]) -> None:
    scenario = world()
    forecast = Forecast(moved(over_the_hall(scenario, Autopilot.PX4, ABOVE_HOME), scenario, home), scenario)
    begins = forecast.mission.home.longitude_deg, forecast.mission.home.latitude_deg
    assert expected(forecast, "over").course.line.points[0] == pytest.approx(begins, abs=2e-7)
    assert mission_world(forecast).spots[0].up == pytest.approx(home[2], abs=0.01)
    assert item_legs(forecast)[0].path[0] == pytest.approx(np.array(home), abs=1e-6)
    flown = flown_track(forecast, fly_built_in(forecast.mission))
    assert flown is not None
    assert flown.points[0] == pytest.approx(np.array(home), abs=0.1)
    assert float(flown.points[:, 2].max()) == pytest.approx(home[2] + 36.0, abs=1.0)


def test_clearance_over_uneven_terrain_is_unknown() -> None:
    rows = ", ".join(f"[0.0, 0.0, 0.0, {top}, {top}]" for top in (0.0, 10.0, 0.0))
    hill = f'\n[terrain]\nkind = "grid"\neast = -100.0\nnorth = -100.0\nspacing = 100.0\nheights = [{rows}]\n'
    for scenario, unknown in ((world(), []), (world(WORLD + hill), ["warning terrain-clearance 2"])):
        mission = over_the_hall(scenario, Autopilot.ARDUPILOT, OVER_TERRAIN)
        forecast = Forecast(mission, scenario)
        assert [code for code in seen(mission, scenario) if "terrain-clearance" in code] == unknown
        if unknown:
            with refuses("not-modeled", "items 2 to 3", "uneven terrain", kind=NotModeled):
                _ = forecast.guarantee
            with refuses("not-modeled", "items 2 to 3", kind=NotModeled):
                Contingencies(forecast).rows(Contingency.RTL)
        else:
            assert clearance(forecast).guaranteed > 0.0


@pytest.mark.parametrize("autopilot", AUTOPILOTS)
def test_levels_of_wind_count_from_the_scenarios_home(autopilot: Autopilot) -> None:
    scenario = world()
    mission = flight(scenario, (0.0, 60.0, 20.0), (100.0, 60.0, 20.0), autopilot=autopilot)
    heights = np.array([30.0, 45.0, 60.0])
    there, here = (Wind.of_profile(list(heights - up), [0.0, 6.0, 14.0], [90.0] * 3) for up in (0.0, 25.0))
    higher = Forecast(moved(mission, scenario, (0.0, 0.0, 25.0)), scenario, there)
    level = Forecast(mission, scenario, here)
    assert higher.expected.done[:-1] == pytest.approx(level.expected.done[:-1], rel=0.02)
    assert level.expected.done[-2] != pytest.approx(Forecast(mission, scenario, there).expected.done[-2], rel=0.05)
