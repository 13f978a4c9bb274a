"""PX4 release/1.18 (05deebf313): waypoints with a hold, and h6_rally without: it flew away."""

import csv
import json
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from ipoa_mission.autopilot.autopilot import Autopilot
from ipoa_mission.autopilot.version import Version
from ipoa_mission.forecast.forecast import Forecast
from ipoa_mission.geodesy import LocalFrame
from ipoa_mission.mission.mission_io import read_mission
from ipoa_mission.vehicles.px4_multicopter.simulation import MissionSimulation
from tests.refused import refuses

AWAY = Path(__file__).parents[1] / "data" / "flyaway" / "h6_rally-px4.plan"
FLIGHTS = sorted((Path(__file__).parents[1] / "data" / "flights_118").iterdir())
VERSION = Version(1, 18, 0, "beta")


@cache
def forecast(folder: Path) -> Forecast:
    mission = read_mission(folder / "mission.plan", Autopilot.PX4)
    return Forecast(replace(mission, firmware_version=VERSION), None)


def done(folder: Path) -> dict[int, float]:
    flown = json.loads((folder / "flight.json").read_text())["item_done_s"]
    return {int(seq): float(at) for seq, at in flown.items()}


@pytest.mark.parametrize("folder", FLIGHTS, ids=lambda folder: folder.name)
def test_the_time_to_the_last_waypoint_is_within_three_per_cent(folder: Path) -> None:
    flown, expected = done(folder), {item.seq: item.done_s for item in forecast(folder).estimate.items}
    first, last = min(flown), sorted(flown)[-2]
    assert expected[last] - expected[first] == pytest.approx(flown[last] - flown[first], rel=0.03)


@pytest.mark.parametrize("folder", FLIGHTS, ids=lambda folder: folder.name)
def test_the_true_track_is_within_what_a_flight_in_a_hundred_exceeds(folder: Path) -> None:
    flown, here = done(folder), forecast(folder)
    with (folder / "track.csv").open() as lines:
        rows = np.array([[float(cell) for cell in row.values()] for row in csv.DictReader(lines)])
    rows = rows[(rows[:, 0] >= min(flown.values())) & (rows[:, 0] <= sorted(flown.values())[-2])]
    places = LocalFrame(here.mission.home).to_local(rows[:, 1], rows[:, 2], rows[:, 3] + here.mission.home.altitude)
    path = np.asarray(here.expected.track.points)
    beside = np.array([np.hypot(*(path[:, :2] - place[:2]).T).min() for place in places])
    assert np.quantile(beside, 0.9) < 1.7
    assert beside.max() < 2.5


def test_flyaway_without_a_hold_is_predicted() -> None:
    away = read_mission(AWAY, Autopilot.PX4)
    with refuses("unreachable", "", "item 3"):
        Forecast(replace(away, firmware_version=VERSION), None).predicted(noise_free=True)
    assert Forecast(replace(away, firmware_version=Version(1, 17)), None).predicted(noise_free=True).done[-1] > 100.0


def test_a_waypoint_without_a_radius_of_its_own_is_reached_at_10_m() -> None:
    mission = replace(forecast(FLIGHTS[0]).mission, parameters={})
    items = (replace(item, params=(*item.params[:1], 0.0, *item.params[2:])) for item in mission.items)
    itinerary = Forecast(replace(mission, items=tuple(items)), None).itinerary
    missions = (replace(mission, firmware_version=version) for version in (VERSION, Version(1, 17)))
    flights = [MissionSimulation(replace(itinerary, mission=mission)) for mission in missions]
    radii = [{motion.radius for motion in each.mission_motions.motions[2:4]} for each in flights]
    assert radii == [{10.0}, {2.0}]
