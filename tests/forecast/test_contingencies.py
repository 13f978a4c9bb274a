import json
import math
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from typer.testing import CliRunner

from ipoa_mission import Forecast, plan_flight, read_mission, read_scenario
from ipoa_mission.autopilot.autopilot import Autopilot
from ipoa_mission.autopilot.commands import Command, Frame
from ipoa_mission.autopilot.failsafe import COMPUTED, IN_PLACE, TIMED, Contingency, FailsafeProfile
from ipoa_mission.autopilot.version import Version
from ipoa_mission.cli.app import app
from ipoa_mission.errors import BadInput, MissionError
from ipoa_mission.forecast.contingency.contingencies import (
    Contingencies,
    ContingencyRow,
    Grade,
    contingencies_of,
    predict_contingency,
)
from ipoa_mission.forecast.contingency.contingency_paths import ContingencyPaths
from ipoa_mission.forecast.contingency.contingency_samples import SAMPLING
from ipoa_mission.geodesy import Geodetic
from ipoa_mission.mission.items import FenceCircle, Item, Mission, change_speed, land, takeoff, waypoint
from ipoa_mission.vehicles.arducopter.braking import braking_displacement
from ipoa_mission.vehicles.px4_multicopter.simulation import MissionSimulation
from tests.examples import examples
from tests.forecast.test_flown_contingencies import row_at
from tests.refused import refuses

MISSIONS = Path(__file__).parents[2] / "missions"
NEAR_RETURNS = Path(__file__).parents[1] / "data" / "near_returns"
HOME = Geodetic(47.397742, 8.545594, 488.0)


def forecast_of(name: str, folder: Path = MISSIONS, /, **parameters: float) -> Forecast:
    mission = read_mission(folder / f"{name}.plan").with_parameters(parameters)
    return Forecast(mission, read_scenario(MISSIONS / f"{name}.toml"))


def near_a_rally_point() -> Forecast:
    return forecast_of("oldtown", NEAR_RETURNS, RTL_RETURN_ALT=50.0, MPC_LAND_ALT1=49.0, MPC_LAND_ALT2=44.0)


@pytest.fixture(scope="module")
def campus() -> Contingencies:
    return Contingencies(forecast_of("campus"))


@pytest.fixture(scope="module")
def sitl() -> Contingencies:
    return Contingencies(forecast_of("sitl", RTL_RETURN_ALT=30.0))  # as PX4 has it, not as was planned


@pytest.fixture(scope="module")
def rows(campus: Contingencies) -> dict[Contingency, tuple[ContingencyRow, ...]]:
    return {contingency: campus.rows(contingency, timed=False) for contingency in COMPUTED}


@pytest.mark.parametrize("contingency", COMPUTED)
def test_every_second_in_the_air_is_in_some_row(
    campus: Contingencies, rows: dict[Contingency, tuple[ContingencyRow, ...]], contingency: Contingency
) -> None:
    of_contingency = rows[contingency]
    assert all(earlier.to_s == later.from_s for earlier, later in pairwise(of_contingency))
    assert of_contingency[0].from_s < 6.0
    assert campus.forecast.estimate.total_s - of_contingency[-1].to_s < 6.0


def test_the_first_example_comes_home_clear_from_every_second(campus: Contingencies) -> None:
    (row,) = campus.rows(Contingency.RTL)
    assert row.clear
    assert row.goal == "home"
    assert row.duration_s is not None
    assert 0.0 < row.duration_s[0] < row.duration_s[1]
    assert row.touches_s is not None
    assert row.touches_s[0] < row.duration_s[0] - 1.0
    assert row.touches_s[1] < row.duration_s[1] - 1.0


def test_a_flight_of_one_moment_has_all_contingencies() -> None:
    forecast = forecast_of("campus")
    grounded = replace(forecast.mission_as_read, items=forecast.mission_as_read.items[-1:])
    rows = Contingencies(Forecast(grounded, forecast.scenario)).all_rows()
    assert {row.contingency for row in rows} == set(COMPUTED)
    assert len({time for row in rows for time in (row.from_s, row.to_s)}) == 1


def test_land_where_it_is_may_be_on_a_roof(rows: dict[Contingency, tuple[ContingencyRow, ...]]) -> None:
    (over,) = (row for row in rows[Contingency.LAND] if row.grade is Grade.UNCLEAR)
    assert over.to == "auditorium"
    assert over.least_m < 0.0


def test_a_return_through_a_mast_is_told_and_a_higher_one_is_clear(sitl: Contingencies) -> None:
    row = next(row for row in sitl.rows(Contingency.RTL, timed=False) if not row.clear)
    assert (row.to, row.goal) == ("mast", "home")
    high = Contingencies(forecast_of("sitl", RTL_RETURN_ALT=80.0))
    unclear = [row for row in high.rows(Contingency.RTL, timed=False) if not row.clear]
    # No height helps where it brakes at a corner; the flight may be two seconds early or late.
    assert all(row.to_s - row.from_s < 3.0 + 2 * 2.5 for row in unclear)


def test_an_unclear_stretch_is_widened_by_how_late_the_flight_may_be(campus: Contingencies) -> None:
    unclear = [row for row in campus.rows(Contingency.LAND, timed=False) if not row.clear]
    assert [row.grade for row in unclear] == [Grade.POSSIBLY_UNCLEAR, Grade.UNCLEAR, Grade.POSSIBLY_UNCLEAR]
    samples_of_land = campus.paths.samples(Contingency.LAND)
    samples = samples_of_land.times[~samples_of_land.clear]
    assert samples[0] - unclear[0].from_s >= 0.6
    assert unclear[-1].to_s - samples[-1] >= 0.6
    assert unclear[1].from_s == pytest.approx(samples[0], abs=0.5)


def test_brake_flies_on_farther_than_a_return_does(campus: Contingencies) -> None:
    """ArduCopter's source, and flown: at 6 m/s 10.7 m against 8.2."""
    autopilot, level = campus.forecast.mission.autopilot, np.array([[5.9, 0.0, 0.0]])
    paths = [
        autopilot.stopping_displacement({}, level, 0.0 * level, contingency)[0, 0]
        for contingency in (Contingency.HOLD, Contingency.RTL, Contingency.LAND)
    ]
    assert paths == pytest.approx([10.7, 8.2, 8.9], abs=0.25)


#: On ArduCopter 4.8.0-dev and PX4 release/1.18: climb rate at the order [m/s], and the farthest height above it [m].
ARDUCOPTER_RUNS_ON = [
    (Contingency.HOLD, 2.49, 4.22),
    (Contingency.HOLD, -1.48, -2.46),
    (Contingency.LAND, 2.51, 3.41),
    (Contingency.RTL, 2.47, 2.04),
    (Contingency.RTL, -1.5, -1.18),
    (Contingency.SMART_RTL, 2.49, 2.37),
    (Contingency.SMART_RTL, -1.5, -1.27),
]
PX4_RUNS_ON = [
    (Contingency.HOLD, 3.1, 2.82),
    (Contingency.HOLD, -1.64, -1.19),
    (Contingency.LAND, 3.05, 2.75),
    (Contingency.RTL, 3.1, 3.44),
    (Contingency.RTL, -1.67, -1.94),  # above its return altitude
    (Contingency.RTL, -1.27, -0.88),  # below
]


@pytest.mark.parametrize(("contingency", "climb", "flown"), ARDUCOPTER_RUNS_ON)
def test_climbs_and_descents_run_on_as_flown(contingency: Contingency, climb: float, flown: float) -> None:
    velocity = np.array([[0.0, 0.0, climb]])
    ((_, _, counted),) = Autopilot.ARDUPILOT.stopping_displacement({}, velocity, 0.0 * velocity, contingency)
    assert abs(flown) - 0.03 <= counted * math.copysign(1.0, climb) <= abs(flown) + 0.55


@pytest.mark.parametrize("level", [0.0, 0.05, 0.3])
@pytest.mark.parametrize(("contingency", "climb", "flown"), PX4_RUNS_ON)
def test_px4_runs_on_as_flown(contingency: Contingency, climb: float, flown: float, level: float) -> None:
    velocity = np.array([[level, 0.0, climb]])
    ((_, _, runs_on),) = Autopilot.PX4.stopping_displacement({}, velocity, 0.0 * velocity, contingency)
    counted = abs(runs_on + climb * Autopilot.PX4.braking_delay_s(contingency))
    assert runs_on * climb > 0.0
    assert abs(flown) - 0.03 <= counted <= abs(flown) + (0.45 if contingency in IN_PLACE else 1.15)


@pytest.mark.parametrize(("cruise", "farthest"), [(5.0, -1.51), (10.0, -2.32), (15.0, -3.01)])
def test_px4_runs_on_farther_before_a_fast_return(cruise: float, farthest: float) -> None:
    # by `MissionSimulation` without noise
    velocity = np.array([[0.0, 0.0, -1.5]])
    ((_, _, runs_on),) = Autopilot.PX4.stopping_displacement(
        {"MPC_XY_CRUISE": cruise}, velocity, 0.0 * velocity, Contingency.RTL
    )
    assert farthest - 1.05 <= runs_on - 0.6 * 1.5 <= farthest


@pytest.mark.parametrize(
    ("level", "climb", "flown"),
    [(12.85, 3.04, 9.57), (12.82, 2.93, 9.34), (12.42, -1.52, -4.67), (12.91, -1.44, -4.41), (12.37, -1.33, -3.67)],
)
def test_px4_runs_on_as_flown_on_a_slope_away_from_home(level: float, climb: float, flown: float) -> None:
    # four on PX4 1.18, one on PX4 1.17
    velocity = np.array([[level, 0.0, climb]])
    ((_, _, runs_on),) = Autopilot.PX4.stopping_displacement(
        {"MPC_XY_CRUISE": 13.0}, velocity, 0.0 * velocity, Contingency.RTL
    )
    counted = abs(runs_on + climb * Autopilot.PX4.braking_delay_s(Contingency.RTL))
    assert abs(flown) <= counted <= abs(flown) + 1.4


@pytest.mark.parametrize("speed", [0.0, 0.1, 0.5, 1.0, 1.2, 5.0])
def test_px4_brakes_by_its_jerk_also_when_slow(speed: float) -> None:
    times = np.linspace(0.0, 4.0, 40_001)
    slowing = np.maximum(-4.0 * times, -3.0)  # MPC_JERK_AUTO, MPC_ACC_HOR
    speeds = speed + np.concatenate([[0.0], np.cumsum(slowing[1:] * np.diff(times))])
    distance = np.maximum(speeds, 0.0)[1:] @ np.diff(times)
    assert Autopilot.PX4.braking_distance({}, np.array([speed]), np.zeros(1)) == pytest.approx([distance], abs=1e-3)


#: LAND on PX4 1.18, PX4 1.17 and ArduCopter 4.8.0-dev: velocity at the order [m/s], then run and height [m] flown.
SUNK = [
    (Autopilot.PX4, (4.93, -0.11), [(4.5, -0.54), (6.9, -1.92), (8.0, -3.38), (8.4, -4.15), (8.68, -6.07)]),
    (Autopilot.PX4, (9.58, -0.1), [(9.2, -0.41), (16.4, -1.61), (21.6, -3.0), (24.2, -4.45), (25.35, -6.75)]),
    (Autopilot.PX4, (12.82, -0.08), [(12.3, -0.5), (22.3, -1.87), (29.6, -3.37), (34.0, -4.89), (36.29, -9.16)]),
    (Autopilot.PX4, (12.56, -1.59), [(12.3, -1.67), (22.3, -3.21), (29.5, -4.62), (33.6, -6.12), (34.66, -7.6)]),
    (Autopilot.PX4, (12.74, -0.04), [(12.3, -0.36), (22.1, -1.7), (29.1, -3.42), (33.1, -5.18), (34.29, -7.99)]),
    (Autopilot.ARDUPILOT, (5.0, -0.03), [(4.5, -0.4), (5.9, -1.01), (6.5, -1.78), (6.54, -2.09)]),
    (Autopilot.ARDUPILOT, (9.79, -0.03), [(9.2, -0.42), (16.2, -1.86), (20.6, -3.38), (22.3, -4.85)]),
    (Autopilot.ARDUPILOT, (13.01, -0.03), [(12.4, -0.36), (22.4, -1.76), (30.2, -3.35), (35.3, -4.82), (37.48, -6.59)]),
    (Autopilot.ARDUPILOT, (12.92, -1.5), [(12.5, -1.46), (22.8, -2.99), (30.5, -4.53), (35.5, -6.03), (37.59, -7.82)]),
]


@pytest.mark.parametrize(("autopilot", "velocity", "flown"), SUNK)
def test_land_sinks_while_it_brakes(
    campus: Contingencies, autopilot: Autopilot, velocity: tuple[float, float], flown: list[tuple[float, float]]
) -> None:
    place = np.array([[0.0, 0.0, 100.0]])
    moving = np.array([[velocity[0], 0.0, velocity[1]]])
    level = autopilot.stopping_displacement({}, moving * (1.0, 1.0, 0.0), 0.0 * moving, Contingency.LAND)
    farthest = place + autopilot.farthest_landing({}, moving)
    stops, sinks = campus.paths.in_place(Contingency.LAND, place, place + level, farthest)[0]
    for run, height in flown:
        from_columns = np.abs(np.array([stops[2, 0], sinks[2, 0]]) - run).min()
        assert np.interp(run, *sinks[:3, ::2].T) <= 100.25 + height or from_columns < 1.5
    assert flown[-1][0] < sinks[2, 0] < flown[-1][0] + 0.55 * velocity[0]


@pytest.mark.parametrize(("speed", "flown"), [(7.89, 16.96), (9.4, 22.22), (7.6, 16.72), (8.52, 21.69)])
def test_px4_hold_flies_beyond_its_stopping_point(speed: float, flown: float) -> None:
    # two on PX4 1.18, two on PX4 1.17
    velocity = np.array([[speed, 0.0, 0.0]])
    ((counted, _, _),) = Autopilot.PX4.stopping_displacement({}, velocity, 0.0 * velocity, Contingency.HOLD)
    assert flown - 0.3 <= counted <= flown + 0.35 * speed


def test_land_over_a_roof_in_its_braking_distance_is_not_clear() -> None:
    scenario = read_scenario(MISSIONS / "sitl.toml")
    places = scenario.frame.geodetic
    ways = (waypoint(places(np.array([east, 75.0, 0.0])), 24.0, 0.1) for east in (0.0, 220.0))
    items = (takeoff(HOME, 24.0), change_speed(10.0), *ways, land(places(np.array([220.0, 75.0, 0.0]))))
    contingencies = Contingencies(Forecast(Mission(HOME, items, Autopilot.PX4), scenario))
    stops = contingencies.stops(Contingency.LAND)
    time = float(np.interp(90.0, stops.places[:, 0], stops.times))
    level, sinking = contingencies.paths.at(Contingency.LAND, np.array([time])).near[0].min(axis=1)
    assert sinking < contingencies.paths.required < level  # the stopping point is 7 m beyond the hangar
    assert not row_at(contingencies, Contingency.LAND, time).clear


def test_hold_in_a_descent_ends_at_the_height_flown() -> None:
    # on ArduCopter 4.8.0-dev: heights of the order and of the end
    flown = [(42.12, 39.73), (40.98, 38.58), (14.59, 12.13), (13.7, 11.4), (13.06, 11.13), (12.57, 11.13)]
    scenario = read_scenario(MISSIONS / "sitl.toml")
    places = scenario.frame.geodetic
    heights = {40.0: 45.0, 75.0: 12.0, 110.0: 12.0, 145.0: 45.0}
    ways = (waypoint(places(np.array([east, 0.0, 0.0])), height) for east, height in heights.items())
    items = (takeoff(HOME, 45.0), *ways, land(places(np.array([145.0, 0.0, 0.0]))))
    stops = Contingencies(Forecast(Mission(HOME, items, Autopilot.ARDUPILOT), scenario)).stops(Contingency.HOLD)
    descends = (stops.places[:, 0] > 42.0) & (stops.places[:, 0] < 80.0)
    ordered, ends = stops.places[descends, 2], stops.stops[descends, 2]
    order_heights, end_heights = np.array(flown).T
    predicted = np.interp(-order_heights, -ordered, ends)
    assert predicted == pytest.approx(end_heights, abs=0.15)


def test_px4_hold_and_return_in_vertical_flight_are_as_flown() -> None:
    # on PX4 release/1.18: heights of order and farthest place
    flown = [(Contingency.HOLD, 44.37, 47.19), (Contingency.HOLD, 46.15, 44.96), (Contingency.RTL, 24.01, 23.13)]
    scenario = read_scenario(MISSIONS / "sitl.toml")
    places = scenario.frame.geodetic
    heights = {30.0: 18.0, 31.0: 62.0, 32.0: 14.0}
    ways = (waypoint(places(np.array([east, 0.0, 0.0])), up, 0.1, 2.0) for east, up in heights.items())
    items = (takeoff(HOME, 18.0), *ways, land(places(np.array([32.0, 0.0, 0.0]))))
    paths = Contingencies(Forecast(Mission(HOME, items, Autopilot.PX4), scenario)).paths
    for contingency, ordered, farthest in flown:
        stops = paths.stops(contingency)
        up = math.copysign(1.0, farthest - ordered)
        is_flown = (stops.places[:, 0] > 25.0) & (np.gradient(stops.places[:, 2], stops.times) * up > 1.0)
        time = np.interp(up * ordered, up * stops.places[is_flown, 2], stops.times[is_flown])
        (path,) = paths.at(contingency, np.array([time])).paths[:, 0]
        assert path[1, 2] == pytest.approx(farthest, abs=0.2 if contingency is Contingency.HOLD else 1.0)
        assert up * (path[1, 2] - farthest) > -0.2
        assert path[2, 2] == pytest.approx(ordered, abs=0.05)


@settings(max_examples=examples(20))
@given(share=st.floats(0.0, 1.0), contingency=st.sampled_from([Contingency.RTL, Contingency.LAND, Contingency.HOLD]))
def test_clear_contingencies_keep_their_distance_by_another_geometry(
    campus: Contingencies, rows: dict[Contingency, tuple[ContingencyRow, ...]], share: float, contingency: Contingency
) -> None:
    times = campus.paths.stops(contingency).times
    time = float(times[0] + share * (times[-1] - times[0]))
    row = next(row for row in rows[contingency] if row.from_s <= time <= row.to_s)
    place, stand = (point[0] for point in campus.paths.stops(contingency).at(np.array([time])))
    way = {Contingency.HOLD: [place, stand], Contingency.LAND: [place, stand, np.array([*stand[:2], 0.0])]}.get(
        contingency, [place, *campus.forecast.returns_from(stand[None])[0, 0]]
    )
    dense = np.vstack([np.linspace(a, b, 400) for a, b in pairwise(way)])
    distance = campus.forecast.world.airspace.obstacle_distance(dense).min()
    assert not row.clear or distance >= row.required_m


@pytest.mark.parametrize("kind", [1.0, 3.0])
def test_a_return_to_the_landing_is_not_called_clear(kind: float) -> None:
    """PX4 1.17 descends all the way there: one flight went through a hangar."""
    (row,) = Contingencies(forecast_of("sitl", RTL_TYPE=kind)).rows(Contingency.RTL)
    assert (row.clear, row.goal) == (False, "unknown")
    assert "begin during the landing" in row.keeps


@pytest.mark.parametrize("kind", [1.0, 3.0])
def test_rtl_without_a_mission_landing_takes_as_long_as_straight_home(kind: float) -> None:
    landed = forecast_of("sitl", RTL_TYPE=kind)
    away = replace(landed.mission_as_read, items=landed.mission_as_read.items[:-1])
    typed, home = (Forecast(away.with_parameters({"RTL_TYPE": rtl_type}), landed.scenario) for rtl_type in (kind, 0.0))
    time = home.estimate.total_s / 2
    lasts = [predict_contingency(each, Contingency.RTL, time).duration_s for each in (typed, home)]
    assert lasts[0] == lasts[1]
    with refuses("not-modeled", "", "returns to the mission's landing"):
        predict_contingency(landed, Contingency.RTL, time)


def test_duration_of_a_row_is_that_of_its_longest_path() -> None:
    contingencies = Contingencies(forecast_of("oldtown"))
    *_, row = contingencies.rows(Contingency.RTL)
    times = np.linspace(row.from_s, row.to_s, 12)
    lasts = [predict_contingency(contingencies.forecast, Contingency.RTL, float(time)).duration_s[1] for time in times]
    assert row.duration_s is not None
    assert row.duration_s[1] > 0.99 * max(lasts)


def test_a_duration_of_two_ways_home_holds_both() -> None:
    # PX4 1.18 does not climb within 10 m of a rally point: some flights with noise are nearer, others are not
    predicted = predict_contingency(near_a_rally_point(), Contingency.RTL, 79.0)
    assert predicted.duration_s == pytest.approx((29.9, 100.3), abs=3.0)
    assert predicted.touches_s == pytest.approx((27.7, 93.4), abs=3.0)
    assert predicted.likely_s == pytest.approx(35.8, abs=1.0)
    assert predicted.remarks == (
        "ordered at 79.0 s, of 90 flights with noise it takes 30 to 42 s in 63, 84 to 100 s in 27",
    )


def lose_noisy_flights(monkeypatch: pytest.MonkeyPatch, lost: range) -> list[int]:
    """Lose the flights of these seeds that have a contingency; return the list of seeds that are not lost."""
    flown, ended = MissionSimulation.flown_with, list[int]()

    def flown_with(self: MissionSimulation, contingency: Contingency, time: float, seed: int | None) -> Any:
        if seed in lost:
            raise MissionError("the vehicle circles", code="unreachable")
        ended.extend([seed] if seed else [])
        return flown(self, contingency, time, seed)

    monkeypatch.setattr(MissionSimulation, "flown_with", flown_with)
    return ended


def test_lost_noisy_flights_are_counted_in_a_remark(monkeypatch: pytest.MonkeyPatch) -> None:
    ended = lose_noisy_flights(monkeypatch, range(2, 7))
    predicted = predict_contingency(forecast_of("sitl"), Contingency.LAND, 30.0)
    assert len(ended) >= 3, "one flight has no spread"
    assert predicted.remarks == (f"5 of {5 + len(ended)} flights with noise did not end: the vehicle circles",)


def test_a_contingency_whose_noisy_flights_are_mostly_lost_has_no_duration(monkeypatch: pytest.MonkeyPatch) -> None:
    ended = lose_noisy_flights(monkeypatch, range(2, 91))
    with refuses("unreachable"):
        predict_contingency(forecast_of("sitl"), Contingency.LAND, 30.0)
    assert ended == [1]


@pytest.mark.parametrize("contingency", sorted(set(Contingency) - set(TIMED)))
def test_a_contingency_without_a_model_of_its_flight_has_no_duration(contingency: Contingency) -> None:
    with refuses("not-modeled", "", contingency):
        predict_contingency(forecast_of("sitl"), contingency, 30.0)


@pytest.mark.parametrize("time", [-5.0, 1e9, math.inf, math.nan])
def test_a_contingency_outside_of_the_flight_is_refused(time: float) -> None:
    with refuses("bad-input", "", f"{time:g}"):
        predict_contingency(forecast_of("sitl"), Contingency.LAND, time)


def test_a_return_that_lands_in_place_has_no_duration() -> None:
    """RTL_TYPE 5 without a rally point, since 1.18."""
    newer = replace(forecast_of("sitl", RTL_TYPE=5.0).mission_as_read, firmware_version=Version(1, 18))
    with refuses("not-modeled", "", "returns here"):
        predict_contingency(Forecast(newer, forecast_of("sitl").scenario), Contingency.RTL, 30.0)


@pytest.mark.parametrize("parameters", [{"RTL_TYPE": 0.0}, {"RTL_TYPE": 2.0}])
def test_a_return_round_fences_is_not_called_clear(parameters: dict[str, float]) -> None:
    forecast = forecast_of("sitl", **parameters)
    home = forecast.mission.home
    round_all = FenceCircle((home.latitude_deg, home.longitude_deg), 2000.0)
    items = (
        replace(item, params=(0.1, *item.params[1:])) if item.has_position else item
        for item in forecast.mission_as_read.items
    )  # or 1.19 passes them
    fenced = replace(forecast.mission_as_read, items=tuple(items), fence=(round_all,), firmware_version=Version(1, 19))
    (row,) = Contingencies(Forecast(fenced, forecast.scenario)).rows(Contingency.RTL)
    assert not row.clear
    assert math.isnan(row.least_m)
    assert row.goal == "unknown"


@pytest.mark.parametrize(
    ("kind", "first", "last"),
    [
        (2.0, "the landing along the mission", "the landing along the mission"),
        (4.0, "home", "the landing along the mission"),
    ],
)
def test_a_return_leads_along_the_mission_by_its_type(sitl: Contingencies, kind: float, first: str, last: str) -> None:
    typed = Contingencies(forecast_of("sitl", RTL_TYPE=kind))
    rows = typed.rows(Contingency.RTL)
    assert (rows[0].goal, rows[-1].goal) == (first, last)
    landing = typed.forecast.estimate.track.points[-1, :2]
    assert rows[-1].lands == pytest.approx(tuple(landing), abs=1.0)
    assert all(row.duration_s is None and "along the mission" in row.why_untimed for row in rows)


@pytest.mark.parametrize("kind", [0.0, 2.0, 4.0])
def test_a_mission_that_ends_in_a_return_is_flown_by_its_type(sitl: Contingencies, kind: float) -> None:
    out = sitl.forecast.mission_as_read
    items = (*out.items[:-1], Item(Command.NAV_RETURN_TO_LAUNCH, Frame.MISSION))
    parameters = {**out.parameters, "RTL_TYPE": kind}
    forecast = Forecast(replace(out, items=items, parameters=parameters), sitl.forecast.scenario)
    home, down = [leg for leg in forecast.legs if leg.seq == len(items)]
    places = [leg.points[-1] for leg in forecast.cruise]
    passed = [np.linalg.norm(home.points - place, axis=1).min() < 0.01 for place in places[:-1]]
    assert all(passed) == (kind > 0.0)
    assert np.hypot(*down.points[-1, :2]) < 0.01
    track = forecast.estimate.track
    back = track.points[track.times > forecast.estimate.items[-2].done_s]
    missed = [np.linalg.norm(back - place, axis=1).min() for place in places[:-1]]
    assert (max(missed) < 6.0) == (kind > 0.0)
    assert np.hypot(*back[-1, :2]) < 1.0


@pytest.mark.parametrize("share", [0.2, 0.5, 0.8])
def test_back_along_the_mission_it_keeps_what_the_way_out_kept(share: float) -> None:
    """By dense points."""
    back = Contingencies(forecast_of("sitl", RTL_TYPE=4.0))
    begin, end = back.paths.in_air
    time = begin + share * (end - begin)
    samples = back.paths.at(Contingency.RTL, np.array([time]))
    path = samples.paths[0][samples.possible[0]][0]
    dense = np.vstack([np.linspace(a, b, 400) for a, b in pairwise(path)])
    nearest = back.paths.enlarged.whole.obstacle_distance(dense).min()
    noted = samples.near[0][samples.possible[0]].min()
    assert noted <= nearest + 1e-6 or nearest > back.paths.required + SAMPLING.max_slack
    assert np.linalg.norm(path[-1] - path[-2]) > 1.0


def test_over_a_hill_a_return_keeps_its_height_over_the_ground() -> None:
    over = Contingencies(forecast_of("campus", RTL_ALT_TYPE=1.0))
    samples = over.paths.at(Contingency.RTL, np.array([sum(over.paths.in_air) / 2]))
    paths = samples.paths[0][samples.possible[0]][:, 3:-1]
    ground = over.forecast.world.airspace.ground(paths.reshape(-1, 3)).reshape(paths.shape[:2])
    assert np.ptp(ground[0]) > 1.0
    above = paths[..., 2] - ground
    assert np.ptp(above, axis=1).max() < 0.01  # each way keeps its own,
    assert np.ptp(above[:, 0]) == pytest.approx(20.0)  # as far as WPNAV_TER_MARGIN allows
    assert np.diff(np.sort(above[:, 0])).max() <= 2 * over.paths.required
    sunk = samples.paths.copy()
    sunk[0, ~samples.possible[0], :, 2] -= 100.0
    low, same = (
        over.paths.lowest_height(Contingency.RTL, each, 0).nearest.distance
        for each in (samples, replace(samples, paths=sunk))
    )
    assert same == low > 0.0  # a way that is not taken does not count
    level = {"RNGFND1_TYPE": 1.0}  # may not see the ground: as over home
    seeing = Contingencies(forecast_of("campus", RTL_ALT_TYPE=1.0, **level))
    assert seeing.paths.at(Contingency.RTL, np.array([20.0])).possible.sum() == samples.possible.sum() + 1


def test_endless_hold_has_no_landing_time() -> None:
    for contingencies in (forecast_of("sitl", RTL_LAND_DELAY=-1.0), forecast_of("campus", RTL_ALT_FINAL=500.0)):
        rows = Contingencies(contingencies).rows(Contingency.RTL)
        assert all(row.duration_s is None and row.why_untimed for row in rows)


def test_a_return_altitude_is_planned_for_a_clear_return(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    text = (MISSIONS / "sitl.toml").read_text(encoding="utf-8")
    (tmp_path / "planned.toml").write_text(
        text.replace("[vehicle]", '[vehicle]\nautopilot = "ardupilot"').replace('autopilot = "px4"\n', ""),
        encoding="utf-8",
    )
    flight = plan_flight(read_scenario(tmp_path / "planned.toml"), seed=0)
    assert flight.mission.parameters["RTL_ALT"] > 3000.0
    assert any("RTL is clear from every second" in remark for remark in flight.remarks)
    assert all(row.clear for row in Contingencies(flight.forecast).rows(Contingency.RTL, timed=False))


@pytest.mark.parametrize(
    ("name", "parameters", "contingencies"),
    [
        ("sitl", {}, "rtl land hold"),  # PX4 has no SmartRTL, whatever its parameters
        ("sitl", {"NAV_RCL_ACT": 3.0, "GF_ACTION": 0.0}, "rtl land hold"),
        ("campus", {}, "rtl land smart_rtl hold"),
        ("campus", {"SRTL_POINTS": 0.0}, "rtl land hold"),  # it keeps no path to go back along
    ],
)
def test_a_contingency_that_the_vehicle_does_not_have_is_not_listed(
    name: str, parameters: dict[str, float], contingencies: str
) -> None:
    assert contingencies_of(forecast_of(name, **parameters)) == tuple(map(Contingency, contingencies.split()))


def test_a_vehicle_of_whose_failsafes_nothing_is_known_has_what_all_have(monkeypatch: pytest.MonkeyPatch) -> None:
    forecast = forecast_of("campus")
    monkeypatch.setattr(type(forecast.mission.autopilot), "failsafe_profile", FailsafeProfile())
    assert contingencies_of(forecast) == (Contingency.RTL, Contingency.LAND, Contingency.HOLD)


def test_check_lists_contingencies_and_what_leads_to_them() -> None:
    words = ["check", str(MISSIONS / "sitl.plan"), "--scenario", str(MISSIONS / "sitl.toml"), "--contingencies"]
    document = json.loads(CliRunner().invoke(app, [*words, "--json"]).output)
    assert list(dict.fromkeys(row["contingency"] for row in document["contingencies"])) == ["rtl", "land", "hold"]
    assert {"cause": "radio control lost", "parameter": "NAV_RCL_ACT", "value": 2.0} in [
        {key: failsafe[key] for key in ("cause", "parameter", "value")} for failsafe in document["failsafes"]
    ]
    assert "stretches are not clear" in CliRunner().invoke(app, words).output


@pytest.mark.parametrize(
    ("changed", "words"),
    [
        ({}, "rtl 3.0 to 4.5 s, to home: clear, 2.47 m from mast"),
        ({"grade": Grade.UNCLEAR}, "rtl 3.0 to 4.5 s, to home: not clear, 2.47 m from mast, 2.50 m required"),
        ({"grade": Grade.UNCLEAR, "least_m": -0.805}, "rtl 3.0 to 4.5 s, to home: not clear, 0.81 m inside mast"),
        ({"least_m": math.inf, "goal": "here"}, "rtl 3.0 to 4.5 s, here: clear, nothing near"),
        (
            {"grade": Grade.UNCLEAR, "to": "the ground"},
            "s, to home: not clear, 2.47 m above the ground, 2.50 m required",
        ),
        (
            {"grade": Grade.UNCLEAR, "to": "the ground", "least_m": -1.0},
            "s, to home: not clear, 1.00 m below the ground",
        ),
        (
            {"grade": Grade.POSSIBLY_UNCLEAR},
            "rtl 3.0 to 4.5 s, to home: perhaps not clear, 2.47 m from mast, 2.50 m required",
        ),
        (
            {"grade": Grade.UNKNOWN, "least_m": math.nan, "to": "not modeled", "goal": "unknown"},
            ": not clear: not modeled",
        ),
    ],
)
def test_a_row_says_in_words_what_is_in_the_way_and_where_it_leads(changed: dict[str, Any], words: str) -> None:
    row = ContingencyRow(Contingency.RTL, 3.0, 4.5, Grade.CLEAR, 2.478, 2.494, "mast", "home")
    assert str(replace(row, **changed)).endswith(words)


def test_contingencies_depend_on_a_world() -> None:
    ended = CliRunner().invoke(app, ["check", str(MISSIONS / "sitl.plan"), "--contingencies"])
    assert isinstance(ended.exception, BadInput)


@pytest.mark.parametrize("contingency", [Contingency.RTL, Contingency.LAND])
def test_looks_at_a_few_times_at_once_are_those_at_all(
    sitl: Contingencies, contingency: Contingency, monkeypatch: pytest.MonkeyPatch
) -> None:
    times = np.linspace(*sitl.paths.in_air, 50)
    whole = sitl.paths.at(contingency, times)
    monkeypatch.setattr("ipoa_mission.forecast.contingency.contingency_paths.SAMPLING", replace(SAMPLING, batch_size=7))
    parts = ContingencyPaths(sitl.forecast).at(contingency, times)
    for name in ("times", "paths", "possible", "near", "which", "slack"):
        assert np.array_equal(getattr(parts, name), getattr(whole, name))


def test_many_are_braked_as_each_alone() -> None:
    random = np.random.default_rng(3)
    velocity, accel = 8.0 * random.normal(size=(10, 2)) @ (1.0, 1.0j), random.normal(size=(10, 2)) @ (1.0, 1.0j)
    alone = [braking_displacement(velocity[n : n + 1], accel[n : n + 1], 2.5, 5.0) for n in range(10)]
    assert np.array_equal(braking_displacement(velocity, accel, 2.5, 5.0), np.concatenate(alone))
