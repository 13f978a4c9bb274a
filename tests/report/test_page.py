import json
import re
from collections.abc import Callable
from dataclasses import replace
from functools import cache
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest

from ipoa_mission.autopilot.commands import Command
from ipoa_mission.centimeters import floor_cm
from ipoa_mission.flight.flight import write_report
from ipoa_mission.forecast.flight_energy import flight_energy
from ipoa_mission.forecast.forecast import Forecast
from ipoa_mission.forecast.itinerary.flown_legs import join
from ipoa_mission.mission.items import return_to_launch
from ipoa_mission.mission.mission_io import read_mission
from ipoa_mission.report.chart import GraphAxis, axis_over
from ipoa_mission.report.drawn_flight import find_dangers, item_legs, sample_track
from ipoa_mission.report.panels.headline import verdict, warnings
from ipoa_mission.report.panels.profile import near_track
from ipoa_mission.report.panels.tables import number, seconds, signed
from ipoa_mission.scenario import Scenario, read_scenario
from ipoa_mission.world.obstacles import Prism
from tests.report.conftest import Bowed, Foreseen, Planned
from tests.report_pages import page_of

VOID = {"meta", "br", "i", "path", "rect"}  # without an end, or closed at once


def _data(page: str) -> str:
    match = re.search(r'id="data">(.*?)</script>', page)
    assert match is not None
    return match[1]


class Reader(HTMLParser):
    """Expects tags to pair."""

    def __init__(self, page: str) -> None:
        super().__init__()
        self.elements: list[tuple[str, dict[str, str]]] = []
        self.texts: dict[str, str] = {}
        self.open: list[str] = []
        self.feed(page)
        self.close()
        assert self.open == []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.elements.append((tag, {name: value or "" for name, value in attrs}))
        if tag != "meta":
            self.open.append(tag)

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.elements.append((tag, {name: value or "" for name, value in attrs}))

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        where = self.open[-1] if self.open else ""
        self.texts[where] = self.texts.get(where, "") + data

    def having(self, name: str, value: str) -> list[dict[str, str]]:
        return [attrs for _, attrs in self.elements if value in attrs.get(name, "").split()]


@pytest.fixture(scope="module")
def planned_page(planned: Planned) -> Callable[[str], str]:
    return cache(lambda name: page_of(*planned(name)))


@pytest.fixture(scope="module")
def bowed_page(forecast: Foreseen) -> Callable[[str], str]:
    return cache(lambda name: page_of(forecast(name)))


@pytest.mark.parametrize("name", ["campus.toml", "downtown.toml", "sitl.toml"])
def test_the_page_is_whole_and_asks_for_nothing_from_outside(planned_page: Callable[[str], str], name: str) -> None:
    page = planned_page(name)
    read = Reader(page)
    for _, attrs in read.elements:
        assert not {"src", "href", "action", "srcset"} & set(attrs), attrs
    assert not re.search(r"https?://|@import|url\((?!#hatch)|fetch\(|XMLHttpRequest", page)
    assert "$" not in page.replace("${", "")  # no blank of the template is left
    assert "NaN" not in page
    assert "Infinity" not in read.texts["body"]


def test_the_same_mission_gives_the_same_page(planned: Planned, tmp_path: Path) -> None:
    for name in "ab":
        forecast, plan = planned("sitl.toml")
        write_report(forecast, tmp_path / name, plan)
    assert (tmp_path / "a").read_bytes() == (tmp_path / "b").read_bytes()


def test_names_from_files_cannot_become_markup(bowed: Bowed) -> None:
    scenario, mission, _ = bowed("sitl.toml")
    evil = '\x1b[31m</script><script>alert(1)</script><b title="x" on=\''
    text = scenario.model_dump(mode="json")
    text["obstacles"][0]["name"] = evil
    page = page_of(Forecast(mission, Scenario.model_validate(text)), remarks=[evil])
    assert "<script>alert" not in page
    assert "\x1b" not in page
    assert sum(tag == "script" for tag, _ in Reader(page).elements) == 2


def test_waypoints_stand_on_the_map_where_they_are(bowed: Bowed, bowed_page: Callable[[str], str]) -> None:
    scenario, mission, _ = bowed("campus.toml")
    read = Reader(bowed_page("campus.toml"))
    box = read.having("class", "map")[0]
    west, south, width, height = (float(box[f"data-{key}"]) for key in ("west", "south", "width", "height"))
    shown = []
    for button in read.having("class", "stop"):
        left, top = (float(v) / 100 for v in re.findall(r"([\d.]+)%", button["style"]))
        shown.append((west + left * width, south + (1 - top) * height))
    flown_to = [item for item in mission.items if item.has_position]
    latitude, longitude = (
        np.array([getattr(item, key) for item in flown_to]) for key in ("latitude_deg", "longitude_deg")
    )
    places = scenario.frame.to_local(latitude, longitude, mission.home.altitude)
    on_the_map = np.array(shown)[: len(places)]
    assert np.abs(on_the_map - places[:, :2]).max() < 1e-4 * width


def test_the_table_has_every_item_with_its_own_time(bowed: Bowed, bowed_page: Callable[[str], str]) -> None:
    *_, timed = bowed("campus.toml")
    rows = re.findall(r'<tr data-stop="(\d+)".*?<i>(\d+)</i>.*?<b>([\d.]+)</b>', bowed_page("campus.toml"))
    assert [(int(seq), float(done)) for _, seq, done in rows] == [
        (item.seq, round(item.done_s, 1)) for item in timed.items
    ]


def test_the_page_shows_obstacles_and_item_times(bowed: Bowed, bowed_page: Callable[[str], str]) -> None:
    *_, timed = bowed("sitl.toml")
    page = bowed_page("sitl.toml")
    roofs = re.findall(r'<path class="roof\d" d="([^"]*)"><title>(.*?)</title>', page)
    heights = ["hangar: 0 to 18", "balloon: 10 to 34", "mast: 0 to 60"]
    assert [words for _, words in roofs] == [f"{height} m above home" for height in heights]
    assert roofs[0][0].count("L") == 3  # four corners
    data = json.loads(_data(page))
    course = data["course"]
    assert len({len(series) for series in course.values()}) == 1
    for stop, item in zip(data["stops"], timed.items, strict=True):
        assert course["times"][stop["index"]] == pytest.approx(item.done_s, abs=0.3)


def test_a_mission_that_comes_too_close_is_called_so_first_of_all(bowed: Bowed, forecast: Foreseen) -> None:
    scenario, _, _ = bowed("downtown.toml")
    legs = item_legs(forecast("downtown.toml"))
    least = scenario.airspace.polyline_clearance(join(forecast("downtown.toml").cruise)[0])
    assert least.distance < 0  # an arc through a city hits towers
    page = page_of(forecast("downtown.toml"))
    assert re.search(rf'class="verdict bad".*Not to be flown: {-least.distance:.2f} m inside {least.what} at', page)
    assert f'title="{-least.distance:.2f} m inside {least.what}' in page  # in the table, at the leg
    hits = [stop.time.seq for stop in legs if stop.proof is not None and not stop.proof.is_proved]
    assert page.count('<span class="bad" title=') == len(hits) > 3


def test_a_mission_that_keeps_its_distance_is_called_clear(bowed: Bowed) -> None:
    scenario, mission, _ = bowed("campus.toml")
    kept = Forecast(mission.assuming(scenario.vehicle.autopilot_parameters()), scenario).guarantee.clearance
    assert kept is not None
    page = page_of(Forecast(mission.with_parameters({"RTL_ALT": 6500.0}), scenario))
    words = f"Clear of teaching block A: 99 % of flights keep {floor_cm(kept.guaranteed):.2f} m"
    assert f'class="verdict good"><b aria-hidden="true">✓</b> {words}' in page
    assert 'class="bad"' not in page
    assert "Before you fly" not in page
    figure = f"99\N{NO-BREAK SPACE}% of flights keep</dt><dd>{floor_cm(kept.guaranteed):.2f}\N{NO-BREAK SPACE}m<small>"
    assert figure in page  # the same number, and no other beside it
    assert "least clearance" not in page


def test_a_return_through_a_building_is_listed_before_you_fly_in_amber(bowed: Bowed) -> None:
    scenario, mission, _ = bowed("campus.toml")
    page = page_of(Forecast(mission.with_parameters({"RTL_ALT": 1500.0}), scenario))
    assert re.search(
        r'class="verdict amber"><b aria-hidden="true">!</b> Clear of .* an RTL ordered there would pass', page
    )
    assert re.search(r'<h2>Before you fly</h2><ul><li class="amber">items 9 to 11: an RTL ordered there', page)


def test_a_way_home_through_a_hill_is_a_warning(bowed: Bowed) -> None:
    scenario, mission, _ = bowed("campus.toml")
    hill = scenario.model_dump(mode="json") | {
        "obstacles": [],
        "terrain": {"kind": "analytic", "peaks": [{"height": 70, "east": 115, "north": 80, "a": 20, "b": 20}]},
    }
    home = replace(mission, items=(*mission.items[:-1], return_to_launch()))
    over_it = page_of(Forecast(home, Scenario.model_validate(hill)))
    assert re.search(r'class="verdict bad".*Not to be flown: the path as predicted runs into the ground after', over_it)


def test_a_corner_cut_into_the_safety_distance_takes_the_tick_away(bowed: Bowed, forecast: Foreseen) -> None:
    scenario, _, timed = bowed("campus.toml")
    proof = forecast("campus.toml").proof
    course = sample_track(timed.track, scenario.airspace)
    text = scenario.model_dump(mode="json")
    beside = scenario.airspace.obstacle_distance(course.points).min()
    text["safety_distance"] = float(beside) - scenario.vehicle.radius + 0.5
    stricter = Scenario.model_validate(text)
    danger = find_dangers(course, stricter)
    assert [each.touching for each in danger] == [False]
    assert f"comes within {floor_cm(beside):.2f} m" in danger[0].words
    numbers = [float(v) for v in re.findall(r"(?:east|north|up) (-?\d+)", danger[0].words)]
    near = course.points[int(np.argmin(course.apart))]
    assert numbers == pytest.approx(near.tolist(), abs=1.5)
    assert 'class="verdict bad"><b aria-hidden="true">!</b> Clear by' in verdict(proof, None, danger)


def test_obstacles_of_the_profile_are_those_under_the_path(bowed: Bowed) -> None:
    scenario, _, timed = bowed("campus.toml")
    course = sample_track(timed.track, scenario.airspace)
    below = [
        (one.name, (one.begins, one.ends)) for one in near_track(course, scenario.airspace, 2.6) if one.look == "below"
    ]
    assert len(below) == 5
    for name, (first, last) in below:
        body = next(o for o in scenario.airspace.obstacles if o.name == name)
        inside = (course.along > first) & (course.along < last)
        assert isinstance(body, Prism)
        assert body.footprint.distance(course.points[inside, :2]).max() < 2.6


def test_a_followed_track_keeps_its_length_time_and_speed(bowed: Bowed) -> None:
    scenario, _, timed = bowed("campus.toml")
    track = timed.track
    course = sample_track(track, scenario.airspace)
    assert course.times[[0, -1]] == pytest.approx(track.times[[0, -1]])
    assert course.along[-1] == pytest.approx(np.hypot(*np.diff(track.points[:, :2], axis=0).T).sum(), rel=1e-3)
    assert (np.diff(course.times) >= 0).all()


@pytest.mark.parametrize(
    ("low", "high", "expected"),
    [(0, 10, [0, 2, 4, 6, 8, 10]), (-0.3, 1.2, [0.0, 0.5, 1.0]), (98, 103, [98, 99, 100, 101, 102, 103])],
)
def test_ticks_are_round_numbers_within_the_axis(low: float, high: float, expected: list[float]) -> None:
    assert GraphAxis(low, high, "").ticks(6) == pytest.approx(expected)


def test_an_axis_over_one_value_still_has_a_length() -> None:
    axis = axis_over("", np.array([5.0, 5.0]))
    assert axis.low < 5 < axis.high


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        (seconds(43.14), "43.1 s"),
        (seconds(103.4), "103 s"),
        (seconds(725.2), "12 min 05 s"),
        (seconds(599.6), "10 min 00 s"),
        (number(-0.5, 2), "−0.50"),
        (number(float("inf"), 2), ""),
        (number(-0.04, 1), "0.0"),
        (signed(100 * (29.0 / 103.0 - 1), 1, "%"), "−71.8 %"),
        (signed(100 * (102.99 / 103.0 - 1), 1, "%"), "+0.0 %"),
    ],
)
def test_numbers_are_written_for_people(words: str, expected: str) -> None:
    assert words.replace("\N{NO-BREAK SPACE}", " ") == expected


def test_the_energy_stands_beside_the_reserve_and_too_little_is_marked(
    bowed: Bowed, bowed_page: Callable[[str], str]
) -> None:
    scenario, mission, timed = bowed("sitl.toml")
    assert "energy" not in bowed_page("sitl.toml")
    text = scenario.model_dump(mode="json")
    text["vehicle"]["airframe"] = {"mass_kg": 2.4, "rotor_diameter": 0.33}
    flown = Scenario.model_validate(text)
    consumed = flight_energy(flown, timed.track)
    assert consumed is not None
    used = consumed.energy_wh
    assert f"{used:.1f}\N{NO-BREAK SPACE}Wh" in page_of(Forecast(mission, flown))
    for capacity, look in ((4 * used, ""), (1.1 * used, "bad")):
        text["vehicle"]["battery"] = {"capacity_wh": capacity, "reserve": 0.25}
        page = page_of(Forecast(mission, Scenario.model_validate(text)))
        left = 1 - used / capacity
        assert f'<div class="{look}"><dt>energy</dt>' in page
        assert f"{left:.0%} of {capacity:.4g} Wh left, 25% required" in page


def test_page_has_the_time_of_the_route(bowed: Bowed, bowed_page: Callable[[str], str]) -> None:
    scenario, mission, timed = bowed("sitl.toml")
    page = bowed_page("sitl.toml").replace("\N{NO-BREAK SPACE}", " ")
    done = {item.seq: item.done_s for item in timed.items}
    last = max(n for n, item in enumerate(mission.items, 1) if item.command == Command.NAV_WAYPOINT)
    shown = re.search(r"first place to last waypoint</dt><dd>([\d.]+) s<small>", page)
    assert shown is not None
    assert float(shown[1]) == pytest.approx(done[last] - done[1], abs=0.06)
    grounded = replace(mission, items=(mission.items[0], mission.items[-1]))
    assert "first place" not in page_of(Forecast(grounded, scenario))


def test_a_zone_is_no_building(missions: Path) -> None:
    pytest.importorskip("rasterio")
    scenario, mission = read_scenario(missions / "oldtown.toml"), read_mission(missions / "oldtown.plan")
    page = page_of(Forecast(mission, scenario))
    assert page.count('<path class="zone"') == 2


def test_remarks_on_the_map_are_folded_and_none_is_lost() -> None:
    page = warnings(
        [],
        [],
        ["a note", "walls raised by 0.01 m", "ground at home -0.05 m"],
        ("walls raised by 0.01 m", "ground at home -0.05 m"),
    )
    assert "<summary>2 remarks on the map</summary>" in page
    assert page.index("a note") > page.index("</details>") or page.index("a note") < page.index("<details>")
    assert all(words in page for words in ("walls raised by 0.01 m", "ground at home -0.05 m"))
    assert "<details>" not in warnings([], [], ["a note", "one of the map"], ("one of the map",))
