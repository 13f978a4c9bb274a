import csv
import json
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import shapely

from ipoa_mission.autopilot.autopilot import autopilot_named
from ipoa_mission.forecast.forecast import Forecast, estimate
from ipoa_mission.forecast.timing.estimate import Estimate
from ipoa_mission.geodesy import LocalFrame
from ipoa_mission.mission.flight_record import FlightRecord, Sample
from ipoa_mission.mission.items import Mission
from ipoa_mission.mission.mission_io import read_mission
from ipoa_mission.report.compare import compare_flight, flown_track
from tests.px4_waypoints import PX4_117
from tests.report.conftest import Bowed, Foreseen
from tests.report_pages import page_of

RECORDED = Path(__file__).parents[1] / "data" / "flights"


def flown_as(timed: Estimate, mission: Mission, factor: float, offset: float) -> FlightRecord:
    """Fly as estimated, slower by a factor, later by an offset."""
    track = timed.track
    latitude, longitude, altitude = LocalFrame(mission.home).to_geodetic(track.points)
    times = offset + factor * track.times
    columns = (times, latitude, longitude, altitude, altitude - mission.home.altitude, track.speeds / factor)
    path = tuple(Sample(*(float(v) for v in row)) for row in zip(*columns, strict=True))
    reached = {item.seq - 1: offset + factor * item.done_s for item in timed.items}
    return FlightRecord(reached, offset + factor * timed.total_s, path, (), True)


def test_a_flight_slower_by_a_tenth_shows_a_tenth_on_every_leg(bowed: Bowed) -> None:
    _, mission, timed = bowed("campus.toml")
    comparison = compare_flight(timed, flown_as(timed, mission, 1.1, 0.0))
    assert comparison.total_error == pytest.approx(1 / 1.1 - 1)
    assert comparison.route_error == pytest.approx(1 / 1.1 - 1)
    assert len(comparison.legs) == len(timed.items)
    for leg in comparison.legs:
        assert leg.flown_s == pytest.approx(1.1 * leg.estimated_s)


def test_a_late_start_spoils_the_total_and_not_the_route(bowed: Bowed) -> None:
    _, mission, timed = bowed("campus.toml")
    comparison = compare_flight(timed, flown_as(timed, mission, 1.0, 7.0))
    assert comparison.route_error == pytest.approx(0)
    assert comparison.flown_total_s == pytest.approx(timed.total_s + 7)
    assert comparison.legs[0].error_s == pytest.approx(-7)
    assert [leg.error_s for leg in comparison.legs[1:]] == pytest.approx([0] * (len(comparison.legs) - 1))


def test_items_that_the_autopilot_does_not_report_are_joined_to_the_next(bowed: Bowed) -> None:
    _, mission, timed = bowed("campus.toml")
    whole = flown_as(timed, mission, 1.0, 0.0)
    gaps = {index: time for index, time in whole.item_reached_s.items() if index not in (1, 4, 5)}
    comparison = compare_flight(timed, FlightRecord(gaps, whole.total_s, (), (), False))
    assert [leg.seq for leg in comparison.legs] == [index + 1 for index in gaps]
    assert sum(leg.estimated_s for leg in comparison.legs) == pytest.approx(timed.total_s)
    assert math.isnan(comparison.flown_total_s)


def test_a_flight_that_reached_nothing_is_no_crash(bowed: Bowed, forecast: Foreseen) -> None:
    _, mission, timed = bowed("sitl.toml")
    nothing = FlightRecord({}, 0.0, (), (), False)
    comparison = compare_flight(timed, nothing)
    assert comparison.legs == ()
    assert math.isnan(comparison.route_error)
    assert flown_track(Forecast(mission), nothing) is None
    assert "reports no item" in page_of(forecast("sitl.toml"), flight=nothing)


def test_the_flown_path_comes_back_to_the_millimeter(bowed: Bowed) -> None:
    _, mission, timed = bowed("campus.toml")
    track = flown_track(Forecast(mission), flown_as(timed, mission, 1.0, 0.0))
    assert track is not None
    assert np.abs(track.points - timed.track.points).max() < 1e-3


def test_the_report_of_a_flight_has_both_times_in_every_row(bowed: Bowed, forecast: Foreseen) -> None:
    _, mission, timed = bowed("campus.toml")
    page = page_of(forecast("campus.toml"), flight=flown_as(timed, mission, 1.25, 0.0))
    assert "the estimate is off by −20.0\N{NO-BREAK SPACE}%" in page
    assert f"<td>{1.25 * timed.items[5].done_s:.1f}</td>" in page
    assert 'class="flown"' in page
    assert "NaN" not in page


def test_heights_count_from_home_as_set_at_arming(bowed: Bowed) -> None:
    _, mission, timed = bowed("campus.toml")
    flight = flown_as(timed, mission, 1.0, 0.0)
    drifted = tuple(replace(s, height=s.height - (2.0 if s.time_s > 5.0 else 0.0)) for s in flight.path)
    as_px4_117 = replace(flight, path=drifted)
    assert (flight.home_drift, as_px4_117.home_drift) == (pytest.approx(0.0), pytest.approx(2.0))
    before, after = flown_track(Forecast(mission), flight), flown_track(Forecast(mission), as_px4_117)
    assert before is not None
    assert after is not None
    assert np.abs(before.points - after.points).max() < 1e-6


@pytest.mark.parametrize("name", ["campus-ardupilot", "campus-px4", "hold-ardupilot", "long-px4"])
def test_recorded_flights_are_compared_item_by_item(name: str) -> None:
    facts = json.loads((RECORDED / name / "flight.json").read_text())
    mission = read_mission(RECORDED / name / "mission.waypoints", autopilot_named(facts["autopilot"]))
    mission = replace(mission, firmware_version=PX4_117.get(mission.autopilot))
    timed = estimate(mission, {key: float(value) for key, value in facts["params"].items()})
    with (RECORDED / name / "trace.csv").open() as file:
        rows = [[float(v) for v in row] for row in list(csv.reader(file))[1:]]
    path = tuple(Sample(r[0], r[1], r[2], r[3], r[3], math.hypot(*r[4:7])) for r in rows)
    reached = {int(seq) - 1: time for seq, time in facts["item_done_s"].items()}
    flight = FlightRecord(reached, facts["end_s"], path, (), True)
    comparison = compare_flight(timed, flight)
    known = [item.seq for item in timed.items if str(item.seq) in facts["item_done_s"]]
    assert [leg.seq for leg in comparison.legs] == known
    assert sum(leg.flown_s for leg in comparison.legs) == pytest.approx(facts["item_done_s"][str(known[-1])])
    track = flown_track(Forecast(mission), flight)
    assert track is not None
    # the autopilot passed every waypoint that it reports
    for item in timed.items:
        place = mission.items[item.seq - 1]
        if str(item.seq) in facts["item_done_s"] and place.has_position:
            done = facts["item_done_s"][str(item.seq)]
            around = track.points[np.abs(track.times - done) < 4.0, :2]
            spot = LocalFrame(mission.home).to_local(
                *(np.array([v]) for v in (place.latitude_deg, place.longitude_deg, mission.home.altitude))
            )[0]
            assert shapely.LineString(around).distance(shapely.Point(spot[:2])) < 7.0  # PX4 turns early
