import csv
import json
import math
from collections.abc import Iterable, Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from ipoa_mission import read_mission
from ipoa_mission.autopilot.autopilot import Autopilot
from ipoa_mission.autopilot.version import Version
from ipoa_mission.checks.unsafe import begun_at
from ipoa_mission.errors import MissionError
from ipoa_mission.forecast.conformance import ConformanceMonitor
from ipoa_mission.forecast.forecast import Forecast
from ipoa_mission.geodesy import Geodetic, LocalFrame
from ipoa_mission.link.flight_order import Conformance, FlightOrder
from ipoa_mission.link.logbook import Logbook
from ipoa_mission.link.vehicle_state import VehicleState
from ipoa_mission.logs.flight_log import read_flights as read_log
from ipoa_mission.mission.flight_record import Deviation, DeviationKind, OnDeviation
from ipoa_mission.mission.items import Item, Mission, land, takeoff, waypoint
from tests.forecast.test_items_flown import FOLDERS as ITEMS_FLOWN
from tests.forecast.test_items_flown import read as read_items
from tests.recorded_flights import FLIGHTS, IN_WIND, LANDINGS, read_flight

HERE = Path(__file__).resolve().parent
AWAY = HERE.parent / "data" / "flyaway"
LOGS = HERE.parents[1] / "missions" / "logs"
HOME = Geodetic(47.4, 8.5, 400.0)
RECORDED = [
    folder
    for kind in (FLIGHTS, LANDINGS, IN_WIND)
    for folder in sorted(kind.iterdir())
    if (folder / "trace.csv").exists()
]


def by_times(forecast: Forecast, done: dict[int, float], time: float) -> int | None:
    """An item whose time was not reported was done with the next one."""
    seqs = [visit.seq for visit in forecast.itinerary.visits]
    for n, seq in enumerate(seqs):
        if time < next((done[later] for later in seqs[n:] if later in done), math.inf):
            return seq - 1
    return None


def deviations(
    forecast: Forecast, samples: Iterable[tuple[float, float, float, float]], done: dict[int, float]
) -> list[Deviation]:
    monitor, reported = ConformanceMonitor(forecast), []
    for time, east, north, up in samples:
        item = by_times(forecast, done, time)
        if item is not None and up > 0.5 and (deviation := monitor.see(time, np.array([east, north, up]), item)):
            reported.append(deviation)
    return reported


@pytest.mark.parametrize("folder", RECORDED, ids=lambda folder: f"{folder.parent.name}-{folder.name}")
def test_no_recorded_flight_deviates(folder: Path) -> None:
    flight = read_flight(folder)
    forecast = Forecast(flight.mission.with_parameters(flight.parameters), wind=flight.wind)
    time, latitude, longitude, height = flight.trace[:, :4].T
    places = forecast.frame.to_local(latitude, longitude, flight.mission.home.altitude + height)
    assert len(time) > 20
    assert deviations(forecast, zip(time, *places.T, strict=True), flight.runs[0]) == []


def rally_on_px4() -> Forecast:
    return Forecast(replace(read_mission(AWAY / "h6_rally-px4.plan"), firmware_version=Version(1, 17)))


def flown_away() -> Iterator[tuple[float, np.ndarray, int]]:
    """PX4 release/1.18 on h6_rally: it passes item 3 and flies on, 490 m east and 205 m up after four minutes."""
    with (AWAY / "h6_rally-px4-1.18-1.csv").open() as file:
        for row in csv.DictReader(file):
            yield float(row["t_s"]), np.array([float(row[axis]) for axis in ("east", "north", "up")]), int(row["item"])


def test_a_fly_away_is_found_long_before_it_is_50_m_from_the_item() -> None:
    forecast = rally_on_px4()
    monitor, goal = ConformanceMonitor(forecast), forecast.itinerary.program.places[2]
    reported = {}
    for time, place, item in flown_away():
        if place[2] > 0.5 and (deviation := monitor.see(time, place, item)):
            reported[deviation.kind] = float(np.linalg.norm(place - goal))
            assert deviation.item == 3
            assert deviation.measured > deviation.allowed
    assert reported.keys() == {DeviationKind.OUTSIDE, DeviationKind.PASSED, DeviationKind.LATE}
    assert reported[DeviationKind.OUTSIDE] < 31.0
    assert reported[DeviationKind.PASSED] < 35.0


def test_the_fly_away_that_was_recorded_first_is_found_within_50_m(shared: Path) -> None:
    """A sample every 20 s, joined by straight lines; it passed items 3 and 4, and never turned at item 5."""
    file = shared / "real4" / "traces" / "h6_rally-px4-118-1.flyaway.csv"
    forecast = rally_on_px4()
    goals = forecast.itinerary.program.places
    monitor, item = ConformanceMonitor(forecast), 2
    track = np.loadtxt(file, delimiter=",")
    for time in np.arange(112.0, 240.0, 0.2):
        place = np.array([np.interp(time, track[:, 0], axis) for axis in track.T[1:]])
        item += item < 4 and math.dist(place[:2], goals[item][:2]) < 2.5
        if (deviation := monitor.see(time, place, item)) is not None:
            break
    assert deviation is not None
    assert (deviation.kind, deviation.item) == (DeviationKind.PASSED, 5)
    assert np.linalg.norm(place - goals[4]) < 30.0


@pytest.mark.parametrize("with_world", [False, True])
def test_no_other_flight_of_the_same_campaign_deviates(shared: Path, with_world: bool) -> None:
    from ipoa_mission import read_scenario

    folder, flown = shared / "real4", 0
    for line in (folder / "flights.jsonl").read_text().splitlines():
        flight = json.loads(line)
        trace = folder / "traces" / f"{flight['name']}.csv"
        if not trace.exists():
            continue
        mission = read_mission(folder / "plans" / f"{flight['scenario']}-{flight['autopilot']}.plan")
        world = read_scenario(folder / "scenarios" / f"{flight['scenario']}.toml") if with_world else None
        if flight["autopilot"] == "px4":
            mission = replace(mission, firmware_version=Version(1, 17))
        done = {item["seq"]: item["flown"] for item in flight["items"] if item.get("flown") is not None}
        assert deviations(Forecast(mission, world), np.loadtxt(trace, delimiter=","), done) == [], flight["name"]
        flown += 1
    assert flown == 23


@pytest.mark.parametrize("log", ["campus-arducopter.tlog", "copter-6.bin", "copter-8.bin"])
def test_no_logged_flight_deviates_as_a_link_tells_it(log: str) -> None:
    for flight in read_log(LOGS / log).flights:
        assert flight.mission is not None
        state, logbook = VehicleState(flight.autopilot), Logbook(flight.mission.items, flight.autopilot)
        compared = Conformance(state, FlightOrder(state, lambda: 0.0))
        compared.logbook = logbook
        compared.on_deviation = OnDeviation.REPORT
        compared.begin(ConformanceMonitor(Forecast(flight.mission.with_parameters(flight.parameters))))
        for message in flight.messages:
            state.note(message)
            logbook.note(message)
            assert list(compared.observe(message, 0.0)) == []
        assert compared.deviations == []


def mission(*items: Item) -> Mission:
    return Mission(HOME, (takeoff(HOME, 20.0), *items), Autopilot.ARDUPILOT)


def place(east: float, north: float, up: float = 20.0) -> Geodetic:
    return LocalFrame(HOME).geodetic(np.array([east, north, up]))


OUT_AND_ASIDE = mission(
    waypoint(place(200.0, 0.0), 20.0), waypoint(place(200.0, 100.0), 20.0), land(place(200.0, 100.0))
)


def flown(monitor: ConformanceMonitor, *samples: tuple[float, ...]) -> list[Deviation]:
    answers = (monitor.see(time, np.array([east, north, up]), int(item)) for time, east, north, up, item in samples)
    return [deviation for deviation in answers if deviation is not None]


def test_a_vehicle_that_moves_away_from_its_item_is_found() -> None:
    monitor = ConformanceMonitor(Forecast(OUT_AND_ASIDE))
    outward = [(20.0 + t, 5.0 * t, 0.0, 20.0, 1) for t in range(15)]
    back = [(40.0 + t, 70.0 - 5.0 * t, 0.0, 20.0, 1) for t in range(12)]
    assert flown(monitor, *outward) == []
    (deviation,) = flown(monitor, *back)
    assert (deviation.kind, deviation.item) == (DeviationKind.AWAY, 2)
    assert str(deviation).startswith("item 2: the vehicle moves away from it: it was 130 m away, and is ")


def test_a_late_vehicle_is_found_and_one_that_was_held_is_not_late() -> None:
    forecast = Forecast(OUT_AND_ASIDE)
    monitor, longest = (
        ConformanceMonitor(forecast),
        forecast.estimate.items[1].high_s - forecast.estimate.items[0].done_s,
    )
    assert longest > 20.0
    stands = [(20.0 + t, 60.0, 0.0, 20.0, 1) for t in np.arange(0.0, 2.0 * longest - 1.0, 1.0)]
    assert flown(monitor, *stands) == []
    monitor.interrupt()
    assert flown(monitor, *((100.0 + time, *there) for time, *there in stands)) == []
    late = [(200.0 + t, 60.0, 0.0, 20.0, 1) for t in np.arange(0.0, 10.0, 1.0)]
    (deviation,) = flown(monitor, *late)
    assert (deviation.kind, deviation.allowed) == (DeviationKind.LATE, pytest.approx(2.0 * longest))


def test_the_way_back_to_its_item_from_where_it_was_held_is_no_deviation() -> None:
    monitor = ConformanceMonitor(Forecast(OUT_AND_ASIDE))
    assert flown(monitor, (20.0, 50.0, 0.0, 20.0, 1), (21.0, 55.0, 0.0, 20.0, 1)) == []
    monitor.interrupt()
    direct = [(60.0 + t, 100.0 + 5.0 * t, 60.0 - 3.0 * t, 20.0, 1) for t in range(20)]
    assert flown(monitor, *direct) == []
    monitor.interrupt()
    assert flown(monitor, (90.0, 100.0, 60.0, 20.0, 1)) == []
    aside = [(91.0 + t, 100.0, 90.0, 20.0, 1) for t in range(3)]
    assert [deviation.kind for deviation in flown(monitor, *aside)] == [DeviationKind.OUTSIDE]


def test_a_loop_is_followed_visit_by_visit() -> None:
    jump = Item(177, 2, (2.0, 1.0, 0.0, 0.0), 0.0, 0.0, 0.0)
    looped = mission(
        waypoint(place(100.0, 0.0), 20.0), waypoint(place(100.0, 100.0), 20.0), jump, land(place(0.0, 0.0))
    )
    monitor = ConformanceMonitor(Forecast(looped))
    twice = [(20.0, 50.0, 0.0, 20.0, 1), (30.0, 100.0, 50.0, 20.0, 2), (40.0, 100.0, 60.0, 20.0, 1)]
    again = [(50.0, 100.0, 50.0, 20.0, 2), (60.0, 50.0, 50.0, 20.0, 4), (62.0, 49.0, 49.0, 20.0, 4)]
    assert flown(monitor, *twice, *again) == []


def test_lower_ground_at_the_landing_is_no_deviation() -> None:
    monitor = ConformanceMonitor(Forecast(OUT_AND_ASIDE))
    sinks = [(60.0 + t, 200.0, 100.0, 20.0 - t, 3) for t in range(80)]
    assert flown(monitor, *sinks) == []


def test_a_circle_that_the_forecast_does_not_have_is_not_compared() -> None:
    circle = Item(
        18, 3, (1.0, 0.0, 60.0, 0.0), *(place(200.0, 0.0).latitude_deg, place(200.0, 0.0).longitude_deg), 20.0
    )
    monitor = ConformanceMonitor(Forecast(mission(circle, waypoint(place(0.0, 100.0), 20.0), land(place(0.0, 100.0)))))
    assert flown(monitor, *((20.0 + t, 200.0, 60.0, 20.0, 1) for t in range(100))) == []


def test_a_wait_until_a_time_of_day_is_not_late() -> None:
    waits = Item(93, 2, (-1.0, 14.0, 30.0, 0.0), 0.0, 0.0, 0.0)
    monitor = ConformanceMonitor(Forecast(mission(waits, waypoint(place(100.0, 0.0), 20.0), land(place(100.0, 0.0)))))
    assert flown(monitor, *((20.0 + t, 0.0, 0.0, 20.0, 1) for t in range(300))) == []


def test_unknown_flight_has_no_monitor() -> None:
    endless = mission(Item(177, 2, (1.0, -1.0, 0.0, 0.0), 0.0, 0.0, 0.0), land(HOME))
    with pytest.raises(MissionError):
        ConformanceMonitor(Forecast(endless))


def test_a_hold_is_flown_where_it_is() -> None:
    holding = mission(waypoint(place(100.0, 0.0), 20.0, 60.0), land(place(100.0, 0.0)))
    monitor = ConformanceMonitor(Forecast(holding))
    assert flown(monitor, *((20.0 + t, 100.0, 0.0, 20.0, 1) for t in range(70))) == []


#: In `spline_arc` the begin of item 4 was not reported.
ITEMS = [folder for folder in ITEMS_FLOWN if folder.name != "spline_arc-ardupilot"]


@pytest.mark.parametrize("folder", ITEMS, ids=lambda folder: folder.name)
def test_circles_payloads_and_splines_are_compared_and_do_not_deviate(folder: Path) -> None:
    forecast, begins, trace = read_items(folder)
    monitor, reported = ConformanceMonitor(forecast), []
    for time, east, north, up in trace:
        seq = max((seq for seq, begin in begins.items() if begin <= time), default=0)
        if 0 < seq <= len(forecast.mission.items) and up > 0.5:
            reported.append(monitor.see(time, np.array([east, north, up]), seq - 1))
    assert len(reported) > 20
    assert not any(reported)


def test_a_circle_of_another_radius_deviates() -> None:
    forecast, begins, trace = read_items(next(folder for folder in ITEMS if folder.name == "circle60-ardupilot"))
    monitor, reported = ConformanceMonitor(forecast), []
    center = np.array(forecast.itinerary.program.places[2])
    for time, east, north, up in trace[(trace[:, 0] > begins[3] + 15.0) & (trace[:, 0] < begins[4])]:
        wider = center + 1.3 * (np.array([east, north, up]) - center) * [1.0, 1.0, 0.0]
        reported.append(monitor.see(time, np.array([*wider[:2], up]), 2))
    assert any(deviation and deviation.kind is DeviationKind.OUTSIDE for deviation in reported)


@pytest.mark.parametrize("autopilot", [Autopilot.PX4, Autopilot.ARDUPILOT])
def test_climb_to_the_first_item_is_part_of_it(autopilot: Autopilot) -> None:
    begun = Forecast(begun_at(replace(OUT_AND_ASIDE, autopilot=autopilot), 2))
    monitor = ConformanceMonitor(begun, 2)
    track = begun.estimate.track
    times = np.arange(0.0, begun.estimate.items[2].done_s, 0.2)
    samples = list(zip(times, track.at(times), strict=True))
    assert samples[len(samples) // 3][1][2] > 3.0
    assert [found for time, place in samples if (found := monitor.see(time, place, 2))] == []
    aside = ConformanceMonitor(begun, 2)
    shifted = [found for time, place in samples if (found := aside.see(time, place + np.array([0.0, 60.0, 0.0]), 2))]
    assert [found.kind for found in shifted] == [DeviationKind.OUTSIDE]
