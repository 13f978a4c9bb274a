import html
import json
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import shapely

from ipoa_mission.autopilot.autopilot import Autopilot
from ipoa_mission.autopilot.commands import Command
from ipoa_mission.autopilot.energy import NotEnoughBattery
from ipoa_mission.errors import BadInput
from ipoa_mission.flight.flight import plan_flight
from ipoa_mission.forecast.contingency.energy_budget import budget_of
from ipoa_mission.forecast.forecast import Forecast
from ipoa_mission.geodesy import Geodetic
from ipoa_mission.mission.items import Mission
from ipoa_mission.mission.mission_io import read_mission
from ipoa_mission.planning.obstruction import NoPath
from ipoa_mission.scenario import Scenario
from ipoa_mission.survey.assembly import assemble_survey
from ipoa_mission.survey.flown_coverage import lines_of_forecast, smallest_overlaps
from ipoa_mission.survey.survey_flight import Survey, plan_survey
from ipoa_mission.survey.survey_report import survey_as_json
from ipoa_mission.survey.survey_task import task_of
from ipoa_mission.survey.tour import Swath, Tour
from tests.refused import refuses

HOME = {"latitude_deg": 47.4, "longitude_deg": 8.5, "altitude_amsl": 400.0}
FIELD = [[20.0, 10.0], [200.0, 10.0], [200.0, 150.0], [20.0, 150.0]]
LINES = {"polygon": FIELD, "line_spacing": 20.0, "height_above_ground": 40.0}
PHOTOS = {"polygon": FIELD, "camera": "Sony A6000 16mm", "gsd_cm": 1.5}
HILL = {"kind": "analytic", "peaks": [{"height": 30.0, "east": 110.0, "north": 80.0, "a": 70.0, "b": 50.0}]}
TOWER = {"kind": "cylinder", "name": "tower", "east": 110.0, "north": 80.0, "radius": 10.0, "height": 80.0}
SHED = TOWER | {"name": "shed", "height": 12.0}
AIRFRAME = {"mass_kg": 2.0, "rotor_diameter": 0.3}


def scenario(survey: dict[str, Any], autopilot: Autopilot = Autopilot.ARDUPILOT, **tables: Any) -> Scenario:
    vehicle = {"autopilot": autopilot, "cruise_speed": 8.0} | tables.pop("vehicle", {})
    return Scenario.from_dict({"name": "field", "home": HOME, "survey": survey, "vehicle": vehicle, **tables})


def waypoints(forecast: Forecast) -> np.ndarray[Any, Any]:
    """Return waypoints from items, east, north, up (n, 3)."""
    frame, home = forecast.frame, forecast.mission.home
    items = [item for item in forecast.mission.items if item.command == Command.NAV_WAYPOINT]
    places = [Geodetic(i.latitude_deg, i.longitude_deg, home.altitude + i.altitude) for i in items]
    return np.array([frame.local(place) for place in places])


def along(points: np.ndarray[Any, Any], step: float = 0.5) -> np.ndarray[Any, Any]:
    shares = [np.linspace(0, 1, int(np.linalg.norm(b - a) / step) + 2)[:, None] for a, b in pairwise(points)]
    return np.vstack([a + share * (b - a) for share, (a, b) in zip(shares, pairwise(points), strict=True)])


def swaths_of(survey: Survey) -> list[Any]:
    return [swath for flight in survey.plan.flights for swath in flight.tour.swaths]


@pytest.mark.parametrize("autopilot", [Autopilot.PX4, Autopilot.ARDUPILOT])
def test_every_place_of_a_field_is_seen_and_nothing_outside_is_flown_over(autopilot: Autopilot) -> None:
    survey = plan_survey(scenario=scenario(LINES, autopilot))
    (flight,) = survey.flights
    east, north = np.meshgrid(np.arange(20.5, 200.0, 2.0), np.arange(10.5, 150.0, 2.0))
    lines = shapely.multilinestrings([[s.begin, s.end] for s in swaths_of(survey)])
    away = shapely.distance(shapely.points(east.ravel(), north.ravel()), lines)
    assert (away <= 10.0 + 1e-6).mean() > 0.999
    lined = along(waypoints(flight)[:, :2])
    assert shapely.distance(shapely.points(lined), shapely.Polygon(FIELD)).max() < 0.05
    assert np.abs(waypoints(flight)[:, 2] - 40.0).max() < 0.05
    assert not flight.guarantee.forbidding
    assert flight.estimate.total_s > 0


@pytest.mark.parametrize("battery", [{}, {"airframe": AIRFRAME, "battery": {"capacity_wh": 25.0}}])
def test_a_flight_that_was_tried_is_not_made_again(battery: dict[str, Any], monkeypatch: pytest.MonkeyPatch) -> None:
    made = list[bytes]()

    def counted(tour: Tour, *rest: Any) -> Mission:
        made.append(tour.places.tobytes())
        return assemble_survey(tour, *rest)

    monkeypatch.setattr("ipoa_mission.survey.survey_plan.assemble_survey", counted)
    flights = plan_survey(scenario=scenario(LINES, vehicle=battery)).plan.flights
    assert (len(flights) > 1) == bool(battery)
    assert [made.count(flight.tour.places.tobytes()) for flight in flights] == [1] * len(flights)


def test_photos_are_triggered_on_lines_only_and_counted() -> None:
    survey = plan_survey(scenario=scenario(PHOTOS))
    (flight,) = survey.flights
    distance, photos, shooting = survey.plan.sight.trigger, 0, 0.0
    assert distance is not None  # 0.08 m later: sampled 50 times a second at 8 m/s
    here = np.zeros(2)
    for item in flight.mission.items:
        if item.command == Command.DO_SET_CAM_TRIGG_DIST:
            shooting = item.params[0]
            assert item.params[2] == float(shooting > 0)
            photos += shooting > 0
            assert shooting <= distance
        elif item.command == Command.NAV_WAYPOINT:
            place = Geodetic(item.latitude_deg, item.longitude_deg, flight.mission.home.altitude)
            there = flight.frame.local(place)[:2]
            photos += int(np.linalg.norm(there - here) / (shooting + 0.08)) if shooting > 0 else 0
            here = there
    assert shooting == 0.0
    assert photos == survey.plan.photos > 40
    assert distance == pytest.approx(0.3 * 61.277 * 15.6 / 16.0, abs=0.01)  # 15.6 by 23.5 mm through 16 mm
    assert survey.plan.sight.spacing == pytest.approx(0.3 * 61.277 * 23.5 / 16.0, abs=0.01)


def test_over_a_hill_no_photo_overlaps_less_than_was_asked() -> None:
    """On the ground itself."""
    world = scenario(PHOTOS, terrain=HILL)
    survey = plan_survey(scenario=world)
    sight, (flight,) = survey.plan.sight, survey.flights
    ground = world.airspace.ground
    path = along(waypoints(flight), 2.0)
    within = min(sight.across, sight.along) / 2  # a disc that each photo holds
    for aside in np.linspace(-within, within, 7):
        for turn in np.linspace(0, np.pi, 8, endpoint=False):
            seen = path[:, :2] + aside * np.array([np.cos(turn), np.sin(turn)])
            assert (path[:, 2] - ground(seen)).min() > sight.least - 0.3
    below = path[:, 2] - ground(path[:, :2])
    assert below.min() > sight.least - 0.3
    assert np.ptp(path[:, 2]) > 10.0  # it follows the hill


@pytest.mark.parametrize("terrain", [{}, {"terrain": HILL}])
def test_the_smallest_overlaps_are_told(terrain: dict[str, Any]) -> None:
    """By every photo's corners: overlap with the next photo, and the next line."""
    world = scenario(PHOTOS, **terrain)
    survey = plan_survey(scenario=world)
    overlaps, ground, (flight,) = survey.plan.overlaps, world.airspace.ground, survey.flights
    assert overlaps is not None
    assert overlaps.front is not None
    assert overlaps.side is not None
    assert not [*overlaps.falls_short(0.7, 0.7)]
    assert overlaps.front.share >= 0.7 - 0.002
    assert overlaps.side.share >= 0.7 - 0.002
    path = waypoints(flight)
    legs = [leg for leg in pairwise(path) if np.linalg.norm(np.diff(leg, axis=0)[0, :2]) > 1.0]
    for smallest, wide, apart in (
        (overlaps.front, 15.6 / 16.0, survey.plan.sight.trigger),
        (overlaps.side, 23.5 / 16.0, survey.plan.sight.spacing),
    ):
        assert apart is not None
        camera = np.array(smallest.at)
        away = [shapely.Point(camera).distance(shapely.LineString(np.array(leg)[:, :2])) for leg in legs]
        begin, end = legs[int(np.argmin(away))]
        share = np.linalg.norm(camera - begin[:2]) / np.linalg.norm((end - begin)[:2])
        height = begin[2] + share * (end - begin)[2] - ground(camera[None])[0]
        level = 1 - apart / (wide * height)  # on level ground
        assert smallest.share == pytest.approx(level, abs=0.08 if terrain else 0.02)


def test_a_slope_steeper_than_the_height_allows_for_is_told() -> None:
    """Lines laid for level ground, over a ridge."""
    level = plan_survey(scenario=scenario(PHOTOS))
    sight, ridge = level.plan.sight, scenario(PHOTOS, terrain=HILL).airspace.ground
    lines = [line for flight in level.flights for line in lines_of_forecast(flight, sight.lag)]
    smallest = smallest_overlaps(lines, sight, ridge, level.plan.free)
    assert smallest.front is not None
    assert smallest.side is not None
    top = 1 - level.plan.sight.spacing / (23.5 / 16.0 * (level.plan.sight.least - 30.0))  # on the summit
    assert top - 0.02 < smallest.side.share < 0.6
    assert [words[:20] for words in smallest.falls_short(0.7, 0.7)] == ["survey.front_overlap", "survey.side_overlap:"]
    where = np.array(smallest.side.at) - (110.0, 80.0)
    assert np.linalg.norm(where) < 40.0


def test_low_obstacles_are_flown_over_and_high_ones_round() -> None:
    low = plan_survey(scenario=scenario(LINES, obstacles=[SHED])).plan
    high = plan_survey(scenario=scenario(LINES, obstacles=[TOWER])).plan
    assert low.keep_out is None
    assert low.coverage.share > 0.999
    (flight,) = high.flights
    track = flight.forecast.estimate.track.points
    beside = np.hypot(track[:, 0] - 110.0, track[:, 1] - 80.0)
    assert beside.min() > 10.0 + 1.5
    assert not flight.forecast.guarantee.forbidding


def test_survey_is_split_into_flights_that_return_with_their_reserve(tmp_path: Path) -> None:
    vehicle = {"airframe": AIRFRAME, "battery": {"capacity_wh": 16.0, "reserve": 0.2}}
    survey = plan_survey(scenario=scenario(LINES, vehicle=vehicle))
    assert len(survey.flights) > 1
    for forecast in survey.flights:
        assert forecast.energy is not None
        assert forecast.energy.energy_wh <= 0.8 * 16.0
    written = survey.write(tmp_path)
    assert {path.name for path in written} >= {"field-1.plan", "field-2.plan", "field.json"}
    document = json.loads((tmp_path / "field.json").read_text())["survey"]
    assert [flight["file"] for flight in document["flights"]] == [f"{name}.plan" for name in survey.names]
    assert document["lines"] == len(survey.plan.tour.swaths)
    assert document["covered_share"] > 0.999
    assert document["outside_m"] < 1e-6
    for name, forecast in zip(survey.names, survey.flights, strict=True):
        assert len(read_mission(tmp_path / f"{name}.plan").items) == len(forecast.mission.items)
    tour = survey.plan.tour
    first = len(survey.plan.flights[0].tour.swaths)
    assert [s.begin.tolist() for s in tour.part(0, first).swaths] == [
        s.begin.tolist() for s in survey.plan.flights[0].tour.swaths
    ]


def test_the_page_shows_the_area_and_every_flight(tmp_path: Path) -> None:
    survey = plan_survey(scenario=scenario(PHOTOS | {"flights": 2}, obstacles=[TOWER]))
    pages = [path for path in survey.write(tmp_path, report=True) if path.suffix == ".html"]
    assert [page.name for page in pages] == ["field-1.html", "field-2.html"]
    for page in pages:
        text = page.read_text(encoding="utf-8")
        assert text.count('class="verdict') == 1
        assert all(f"field-{n}.plan" in text for n in (1, 2))
        assert "Map: covered ground is shaded, gaps are red" in text


def test_survey_page_escapes_names_of_flights(tmp_path: Path) -> None:
    odd = scenario(LINES | {"flights": 2}, obstacles=[TOWER | {"name": "<b>t\x07"}])
    survey = plan_survey(scenario=odd.model_copy(update={"name": "a #1"}))
    pages = [path for path in survey.write(tmp_path, report=True) if path.suffix == ".html"]
    assert [page.name for page in pages] == ["a #1-1.html", "a #1-2.html"]
    assert "&lt;b&gt;t" in pages[0].read_text(encoding="utf-8")
    assert "\x07" not in pages[0].read_text(encoding="utf-8")


def test_so_many_flights_as_are_asked_for() -> None:
    survey = plan_survey(scenario=scenario(LINES | {"flights": 3}))
    assert survey.names == ("field-1", "field-2", "field-3")
    times = [forecast.estimate.total_s for forecast in survey.flights]
    assert max(times) < 1.5 * min(times)


def test_the_same_survey_has_the_same_bytes_of_plain_items(tmp_path: Path) -> None:
    first, second = (plan_survey(scenario=scenario(PHOTOS)).write(tmp_path / name) for name in "ab")
    assert [path.read_bytes() for path in first] == [path.read_bytes() for path in second]
    document = json.loads((tmp_path / "a" / "field.plan").read_text())
    assert {item["type"] for item in document["mission"]["items"]} == {"SimpleItem"}
    kinds = {item["command"] for item in document["mission"]["items"][2:-1]}
    assert kinds == {Command.NAV_WAYPOINT, Command.DO_SET_CAM_TRIGG_DIST}


@pytest.mark.parametrize("autopilot", [Autopilot.PX4, Autopilot.ARDUPILOT])
def test_all_that_flights_come_too_near_to_is_given_room_at_once(
    autopilot: Autopilot, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Six round towers, more than there are rounds."""
    monkeypatch.setattr("ipoa_mission.survey.survey_plan.ROUNDS", 5)
    places = [(45.0, 40.0), (95.0, 45.0), (150.0, 40.0), (50.0, 115.0), (105.0, 120.0), (160.0, 110.0)]
    towers = [
        {"kind": "cylinder", "name": f"tower {n}", "east": east, "north": north, "radius": 6.0, "height": 80.0}
        for n, (east, north) in enumerate(places)
    ]
    plan = plan_survey(scenario=scenario(LINES | {"line_spacing": 9.0}, autopilot, obstacles=towers)).plan
    assert plan.scenario.vehicle.cruise_speed == 8.0
    assert len(plan.growth) == 6
    assert plan.coverage.share >= 0.999


def test_a_corridor_is_followed() -> None:
    line = [[20.0, 20.0], [200.0, 60.0], [300.0, 200.0]]
    over = {"line": line, "width": 60.0, "line_spacing": 20.0, "height_above_ground": 40.0}
    survey = plan_survey(scenario=scenario(over))
    lines = shapely.multilinestrings([[s.begin, s.end] for s in swaths_of(survey)])
    assert shapely.hausdorff_distance(lines, shapely.LineString(line)) < 25.0
    assert survey.plan.coverage.share > 0.999
    assert survey.plan.flown is not None
    assert survey.plan.flown.outside_m == 0.0  # what flies past corners does not leave it


@pytest.mark.parametrize(
    ("tables", "error", "words"),
    [
        ({"obstacles": [TOWER | {"radius": 400.0, "base": 20.0}]}, NoPath, ("area-covered", "survey")),
        ({"survey": LINES | {"height_above_ground": 1.0}}, NoPath, ("survey-too-low", "survey")),
        ({"survey": LINES | {"flights": 500}}, BadInput, ("too-many-flights", "survey.flights")),
        ({"survey": LINES | {"line_spacing": 0.1}}, BadInput, ("lines-too-near", "survey.line_spacing")),
        ({"survey": PHOTOS | {"front_overlap": 0.999}}, BadInput, ("lines-too-near", "survey.front_overlap")),
        (
            {"vehicle": {"airframe": AIRFRAME, "battery": {"capacity_wh": 2.0}}},
            NotEnoughBattery,
            ("not-enough-battery", "battery"),
        ),
    ],
)
def test_unflyable_surveys_are_refused_with_their_place(
    tables: dict[str, Any], error: Any, words: tuple[str, ...]
) -> None:
    with refuses(*words):
        plan_survey(scenario=scenario(tables.pop("survey", LINES), **tables))


def test_a_flight_to_a_goal_does_not_pass_over_a_survey() -> None:
    with refuses("bad-input", "survey"):
        plan_flight(scenario(LINES))


def test_the_library_takes_an_area_and_a_camera() -> None:
    world = scenario(LINES)
    survey = plan_survey(np.array(FIELD), "DJI Mavic 3E", scenario=world, height_above_ground=60.0)
    assert survey.plan.photos > 10
    with refuses("unknown-name", "survey.camera", kind=BadInput):
        plan_survey(np.array(FIELD), "box brownie", scenario=world, height_above_ground=60.0)


def test_the_camera_starts_and_stops_on_each_line_even_of_no_length() -> None:
    world = scenario(PHOTOS)
    at = [np.array(place) for place in ([30.0, 20.0], [130.0, 20.0], [130.0, 60.0], [60.0, 60.0])]
    swaths = (Swath(at[0], at[1]), Swath(at[2], at[2]), Swath(at[2], at[3]))
    tour = Tour.of(swaths, (np.array(at[1:3]), np.array([at[2], at[2]])))
    mission = assemble_survey(tour, task_of(world), 0)
    triggers = [item.params[0] for item in mission.items if item.command == Command.DO_SET_CAM_TRIGG_DIST]
    assert [distance > 0 for distance in triggers] == [True, False] * 3


@pytest.mark.parametrize("autopilot", [Autopilot.PX4, Autopilot.ARDUPILOT])
def test_the_gimbal_looks_straight_down_before_the_first_photo(autopilot: Autopilot) -> None:
    """By QGroundControl's item, whose seventh param says that angles are meant."""
    (flight,) = plan_survey(scenario=scenario(PHOTOS | {"gimbal": "nadir"}, autopilot)).flights
    (quiet,) = plan_survey(scenario=scenario(PHOTOS, autopilot)).flights
    items = list(flight.mission.items)
    at = [n for n, item in enumerate(items) if item.command == Command.DO_MOUNT_CONTROL]
    triggers = [n for n, item in enumerate(items) if item.command == Command.DO_SET_CAM_TRIGG_DIST]
    assert at == [1]
    assert items[1].params[0] == -90.0
    assert items[1].altitude == 2.0
    assert triggers[0] > 1
    assert items[:1] + items[2:] == list(quiet.mission.items)
    assert flight.estimate.total_s == pytest.approx(quiet.estimate.total_s, abs=0.1)


def test_a_battery_that_is_not_quite_enough_in_wind_makes_more_flights() -> None:
    wind = {"speed": 6.0, "from_deg": 270.0}
    used = []
    for blows in ({"speed": 0.0}, wind):
        (flight,) = plan_survey(scenario=scenario(LINES, vehicle={"airframe": AIRFRAME}, wind=blows)).flights
        assert flight.energy is not None
        used.append(flight.energy.between.high)
    calm, windy = used
    assert windy > 1.02 * calm
    battery = {"airframe": AIRFRAME, "battery": {"capacity_wh": 0.993 * windy, "reserve": 0.0}}
    assert len(plan_survey(scenario=scenario(LINES, vehicle=battery)).flights) == 1
    assert len(plan_survey(scenario=scenario(LINES, vehicle=battery, wind=wind)).flights) == 2


def test_planned_returns_add_a_flight_where_the_battery_allows_no_rtl() -> None:
    """A battery for all in one flight, but not for an RTL from every second of it."""
    (whole,) = plan_survey(scenario=scenario(LINES, vehicle={"airframe": AIRFRAME})).flights
    assert whole.energy is not None
    battery = {"capacity_wh": 1.0005 * whole.energy.between.high, "reserve": 0.2}
    tight = {"airframe": AIRFRAME, "battery": battery}
    assert len(plan_survey(scenario=scenario(LINES, vehicle=tight)).flights) == 1
    survey = plan_survey(scenario=scenario(LINES, vehicle=tight, safety={"returns": "planned"}))
    assert len(survey.flights) == 2
    for forecast in survey.flights:
        budget = budget_of(forecast)
        assert budget is not None
        assert budget.no_return is None


@pytest.mark.parametrize(
    ("survey", "words"),
    [
        ({"polygon": [[0.0, 0.0], [9e5, 0.0], [9e5, 9e5]]}, ("too-far", "survey.polygon", "100")),
        ({"line": [[0.0, 0.0], [2e5, 0.0]], "width": 20.0}, ("too-far", "survey.line", "100")),
        (
            {"polygon": [[0.0, 0.0], [3e4, 0.0], [3e4, 4e4], [0.0, 4e4]], "line_spacing": 2.0},
            ("survey-too-long", "survey", "3000", "12000"),
        ),
        ({"line": [[0.0, 0.0], [9e3, 0.0]], "width": 5e3, "line_spacing": 0.5}, ("survey-too-long", "survey", "3000")),
        (
            {"polygon": [[0.0, 0.0], [19e3, 0.0], [19e3, 8e4], [0.0, 8e4]]},
            ("survey-too-long", "survey", "100", "2639", "76000"),
        ),
    ],
)
def test_more_than_can_be_planned_is_refused_at_once(survey: dict[str, Any], words: tuple[str, ...]) -> None:
    with refuses(*words):
        plan_survey(scenario=scenario({"line_spacing": 20.0, "height_above_ground": 40.0} | survey))


def test_a_remark_says_of_which_flights_it_is() -> None:
    mast = TOWER | {"east": 160.0, "north": 90.0, "radius": 4.0, "height": 70.0}
    survey = plan_survey(scenario=scenario(LINES | {"flights": 2}, obstacles=[mast]))
    hints = {finding.hint for flight in survey.plan.flights for finding in flight.findings}
    assert len(hints) == 1  # of both flights
    assert hints <= {*survey.remarks}
    for n, flight in enumerate(survey.plan.flights, 1):
        (finding,) = flight.findings
        assert f"flight {n}: {finding.message}" in survey.remarks
        (row,) = survey_as_json(survey.plan, survey.names)["flights"][n - 1]["findings"]
        assert (row["code"], row["severity"], row["message"]) == ("return-too-near", "warning", finding.message)
    assert survey.notes == ()


def test_survey_that_may_use_its_reserve_gets_a_warning() -> None:
    def planned(battery: dict[str, Any], **asked: Any) -> Survey:
        vehicle = {"airframe": AIRFRAME, **battery}
        return plan_survey(scenario=scenario(LINES | {"line_spacing": 40.0} | asked, vehicle=vehicle))

    energy = planned({}).flights[0].energy
    assert energy is not None
    tight = {"battery": {"capacity_wh": (energy.between.likely + energy.between.high) / 2 / 0.8}}
    single, two = planned(tight), planned(tight, flights=2)
    needed, hint, more = single.warnings
    assert needed.startswith(f"warning: the flight needs {energy.between.low:.0f} to {energy.between.high:.0f} Wh")
    assert "learn" in hint
    assert more == "hint: flights = 2 under [survey] leaves more in each battery"
    assert single.notes == two.notes
    assert two.warnings == ()


def test_the_page_of_a_flight_has_no_remark_on_another(tmp_path: Path) -> None:
    sheds = [SHED | {"east": 150.0, "north": north} for north in (60.0, 100.0)]
    asked = LINES | {"flights": 2, "line_spacing": 40.0, "direction_deg": 0.0}
    survey = plan_survey(scenario=scenario(asked, obstacles=sheds, safety={"returns": "planned"}))
    assert any(note.startswith(("flight 1: ", "flight 2: ")) for note in survey.notes)
    written = survey.write(tmp_path, report=True)
    pages = [path.read_text() for path in written if path.suffix == ".html"]
    for n, page in enumerate(pages, 1):
        of_it = [note.removeprefix(f"flight {n}: ") for note in survey.notes]
        before = page.partition("Before you fly")[2].partition("</section>")[0]
        assert f"flight {3 - n}: " not in before
        assert all(html.escape(note) in before for note in of_it if not note.startswith(f"flight {3 - n}: "))
