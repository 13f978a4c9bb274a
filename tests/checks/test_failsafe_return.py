import csv
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from ipoa_mission import read_mission, read_scenario
from ipoa_mission.autopilot.autopilot import Autopilot, autopilot_named, registered
from ipoa_mission.autopilot.failsafe import Contingency
from ipoa_mission.autopilot.version import Version
from ipoa_mission.checks.world_check import check_failsafe_return
from ipoa_mission.forecast.contingency.contingency_paths import ContingencyPaths
from ipoa_mission.forecast.contingency.contingency_samples import ReturnLeg, StoppingPoints
from ipoa_mission.forecast.deviation.law import law_of
from ipoa_mission.forecast.forecast import Forecast
from ipoa_mission.mission.items import land
from ipoa_mission.planning.proof import prove
from ipoa_mission.routing.build import build_mission
from ipoa_mission.routing.resample import Route
from ipoa_mission.scenario import Scenario, parse_scenario

FLOWN = list(csv.DictReader((Path(__file__).parents[1] / "data" / "braked.csv").read_text().splitlines()))
ROUND_THE_HALL = np.array([(0.0, 0.0, 20.0), (0.0, -40.0, 20.0), (100.0, -40.0, 20.0), (100.0, 0.0, 20.0)])
BESIDE = {"ardupilot": 0.3, "px4": 3.2}  # [m]
FARTHER = {"ardupilot": 0.0, "px4": 1.05}  # than is counted [m]


@pytest.mark.parametrize("row", FLOWN, ids=lambda row: f"{row['autopilot']}-{row['scenario']}-{row['speed']}")
def test_real_vehicles_fly_on_within_what_is_counted_and_deviation(row: dict[str, str]) -> None:
    autopilot, speed = autopilot_named(row["autopilot"]), float(row["speed"])
    gains, waits = max(float(row["gaining"]), 0.0), autopilot.guidance.brakes_after
    then = np.array([speed + gains * waits])
    counted = waits * (speed + gains * waits / 2) + autopilot.braking_distance({}, then, np.array([gains]))[0]
    farther = FARTHER[row["autopilot"]]
    assert farther == 0.0 or farther < law_of(autopilot).lateral_bound(0.01)
    assert -farther <= counted - float(row["flown_on"]) <= 4.1
    assert float(row["beside"]) <= BESIDE[row["autopilot"]]


def scene(autopilot: Autopilot, *obstacles: str) -> Scenario:
    text = f"""
    safety_distance = 2.0
    home = {{ latitude_deg = 47.4, longitude_deg = 8.5, altitude_amsl = 400.0 }}
    start = {{ east = 0.0, north = 0.0, up = 20.0 }}
    goal = {{ east = 100.0, north = 0.0, up = 20.0 }}
    bounds = {{ east = [-50.0, 150.0], north = [-80.0, 50.0], up = [-5.0, 60.0] }}
    vehicle = {{ radius = 0.5, autopilot = "{autopilot}" }}
    {"".join(f"[[obstacles]]{chr(10)}{body}{chr(10)}" for body in obstacles)}
    """
    return parse_scenario(text, Path("scene.toml"))


HALL = 'kind = "box"\nname = "hall"\neast = 50.0\nnorth = 0.0\nwidth = 20.0\ndepth = 20.0\nheight = 45.0'
LOW_HALL = HALL.replace("45.0", "12.0")
BALL = 'kind = "sphere"\nname = "balloon"\neast = 50.0\nnorth = 0.0\nup = 25.0\nradius = 10.0'
WALL = 'kind = "box"\nname = "wall"\neast = 0.0\nnorth = -43.8\nwidth = 30.0\ndepth = 2.0\nheight = 45.0'


def flight_in(scenario: Scenario) -> Forecast:
    return Forecast(build_mission(Route(ROUND_THE_HALL), scenario), scenario)


@pytest.mark.parametrize("autopilot", registered())
@pytest.mark.parametrize(("body", "clears"), [(HALL, 50.0), (BALL, 40.0)], ids=["hall", "balloon"])
def test_obstacles_of_the_return_are_named_with_a_height_that_clears_them(
    autopilot: Autopilot, body: str, clears: float
) -> None:
    scenario = nominal(scene(autopilot, body))
    forecast = flight_in(scenario)
    (finding,) = check_failsafe_return(forecast)
    by = autopilot.parameter_table.by_meaning["return height"]
    name, unit = by.name, by.unit
    assert finding.code == "return-too-near"
    assert finding.hint is not None
    words = finding.hint.split()
    assert words[:2] == [name, "="]
    assert float(words[2]) * unit == clears
    assert not list(
        check_failsafe_return(Forecast(forecast.mission.with_parameters({name: float(words[2])}), scenario))
    )


@pytest.mark.parametrize("autopilot", registered())
def test_a_clear_way_home_is_nothing_to_speak_of(autopilot: Autopilot) -> None:
    assert not list(check_failsafe_return(flight_in(scene(autopilot, LOW_HALL))))


@pytest.mark.parametrize("autopilot", registered())
def test_no_height_helps_where_it_brakes_into_a_wall(autopilot: Autopilot) -> None:
    (braking,) = check_failsafe_return(flight_in(scene(autopilot, WALL)))
    assert braking.code == "return-too-near"
    assert "from wall" in braking.message
    assert braking.hint is None


@pytest.mark.parametrize("autopilot", registered())
@pytest.mark.parametrize("height", [22.0, pytest.param(33.0, marks=pytest.mark.long), 41.0])
def test_items_whose_return_is_unclear_are_those_of_single_unclear_paths(autopilot: Autopilot, height: float) -> None:
    scenario = nominal(scene(autopilot, HALL.replace("45.0", str(height)), BALL.replace("50.0", "80.0")))
    paths = ContingencyPaths(flight_in(scenario))
    samples = paths.samples(Contingency.RTL)
    single = [
        any(c.slack < -0.02 for path in ways_of for c in prove(path[:5], scenario).checks if c.limit == "obstacles")
        for ways_of in samples.paths
    ]
    exact = {int(seq) for seq, is_broken in zip(paths.stops().seqs_at(samples.times), single, strict=True) if is_broken}
    reported = {int(seq) for seq in paths.stops().seqs_at(samples.times[~samples.clear])}
    assert reported == exact


@pytest.mark.parametrize("autopilot", registered())
def test_a_hill_in_the_way_home_counts_as_well(autopilot: Autopilot) -> None:
    text = (Path("missions/mountains.toml").read_text()).replace('"px4"', f'"{autopilot}"')
    scenario = parse_scenario(text, Path("missions/mountains.toml"))
    start, goal = scenario.places[0], scenario.places[-1]
    high = np.array([start, [start[0], start[1], 95.0], [goal[0], goal[1], 95.0], goal])
    mission = build_mission(Route(high), scenario)
    (finding,) = check_failsafe_return(Forecast(mission, scenario))
    assert finding.code == "return-too-near"
    assert finding.hint is not None
    name, _, value, *_ = finding.hint.split()
    assert not list(check_failsafe_return(Forecast(mission.with_parameters({name: float(value)}), scenario)))


@pytest.mark.parametrize("autopilot", registered())
def test_px4_may_turn_home_anywhere_between_the_order_and_its_stop(autopilot: Autopilot) -> None:
    scenario = scene(autopilot, HALL)
    paths = ContingencyPaths(flight_in(scenario))
    places, stopping_points = (np.array([[100.0, y, 20.0], [100.0, y - 0.1, 20.0]]) for y in (-20.0, -60.0))
    paths._stops[Contingency.RTL] = StoppingPoints(
        np.arange(2.0), places, stopping_points, np.array([4, 4]), stopping_points
    )
    returns = paths.at(Contingency.RTL, np.arange(2.0)).near[:, :, ReturnLeg.RETURNS].min()
    assert (returns < scenario.limits.obstacle_distance) == (autopilot is Autopilot.PX4)


@pytest.mark.parametrize(("ordered", "stops", "top"), [(12.0, 2.0, 30.0), (4.0, 14.0, 20.0)])
def test_px4_chooses_its_return_altitude_at_the_place_of_the_order(ordered: float, stops: float, top: float) -> None:
    # rtl.cpp: within NAV_ACC_RAD it does not climb to RTL_RETURN_ALT
    paths = ContingencyPaths(flight_in(scene(Autopilot.PX4, HALL)))
    places, stopping_points = (np.array([[east, 0.0, 20.0], [east, 0.1, 20.0]]) for east in (ordered, stops))
    paths._stops[Contingency.RTL] = StoppingPoints(
        np.arange(2.0), places, stopping_points, np.array([4, 4]), stopping_points
    )
    (path, *_) = paths.at(Contingency.RTL, np.arange(1.0)).paths[0]
    assert path[3, 2] == pytest.approx(top, abs=0.01)


def nominal(scenario: Scenario) -> Scenario:
    return scenario.model_copy(update={"safety": scenario.safety.model_copy(update={"confidence": "nominal"})})


def test_a_return_that_is_not_modeled_is_told_of() -> None:
    forecast = flight_in(scene(Autopilot.PX4, HALL))
    items = (*forecast.mission.items[:-1], land(forecast.frame.geodetic(ROUND_THE_HALL[-1])))
    mission = replace(forecast.mission, items=items).with_parameters({"RTL_TYPE": 3.0})
    (finding,) = check_failsafe_return(Forecast(mission, forecast.world))
    assert (finding.code, finding.seq) == ("return-too-near", None)
    assert "begin during the landing" in finding.message


@pytest.mark.parametrize(("nearer", "verbs"), [(0.01, ["brake"]), (0.03, ["brake", "pass"]), (0.3, ["brake", "pass"])])
def test_the_way_home_is_reported_where_it_comes_nearer_than_the_braking(
    monkeypatch: pytest.MonkeyPatch, nearer: float, verbs: list[str]
) -> None:
    """Both begin at one place: by the rounding of 2 cm alone the way home is no other finding."""
    forecast = flight_in(scene(Autopilot.PX4, WALL))
    paths = forecast.cached(ContingencyPaths)
    whole = paths.samples(Contingency.RTL)
    near, worst = np.full_like(whole.near, np.inf), int(np.argmin(whole.slack))
    near[worst, :, 0], near[worst, :, ReturnLeg.RETURNS] = paths.required - 1.0, paths.required - 1.0 - nearer
    lowered = replace(whole, near=near)
    monkeypatch.setattr(ContingencyPaths, "samples", lambda *_: lowered)
    findings = [finding.message for finding in check_failsafe_return(forecast)]
    assert [next(verb for verb in ("brake", "pass") if f" {verb} " in words) for words in findings] == verbs


def test_a_shortfall_within_the_spread_of_flights_names_less_than_required() -> None:
    missions = Path(__file__).parents[2] / "missions"
    mission = read_mission(Path(__file__).parents[1] / "data" / "near_returns" / "sitl.plan")
    mission = mission.with_parameters({"RTL_RETURN_ALT": 70.0})
    at_117, at_118 = (
        Forecast(replace(mission, firmware_version=Version(1, minor)), read_scenario(missions / "sitl.toml"))
        for minor in (17, 18)
    )
    (finding,) = check_failsafe_return(at_117)
    assert "would brake or climb 1.90 m from hangar" in finding.message
    assert "at least 2.50 m required" in finding.message
    assert not list(check_failsafe_return(at_118))  # its lower bound is 2.47 m, the distance 3.02 m
