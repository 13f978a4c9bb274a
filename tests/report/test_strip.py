import re
from dataclasses import replace
from html import unescape

import numpy as np
import pytest

from ipoa_mission.forecast.contingency.contingencies import Contingencies, Grade
from ipoa_mission.forecast.forecast import Forecast
from ipoa_mission.report.drawn_flight import SampledTrack, sample_track
from ipoa_mission.report.panels.contingency_panel import contingency_strip
from ipoa_mission.report.panels.profile import along_axis
from ipoa_mission.scenario import Scenario
from tests.examples import some
from tests.report.conftest import Bowed, Foreseen
from tests.report_pages import page_of

WAY = re.compile(
    r'<span class="way (not-clear|perhaps|clear)" role="img" aria-label="([^"]*)" title="([^"]*)" '
    r'data-contingency="(\w+)" data-from="([\d.]+)" data-to="([\d.]+)" '
    r'data-keeps="([^"]*)" style="left:([\d.]+)%;width:([\d.]+)%">([^<]*)<'
)


def strip_of(forecast: Forecast) -> tuple[SampledTrack, list[tuple[str, ...]]]:
    assert forecast.scenario is not None
    course = sample_track(forecast.estimate.track, forecast.scenario.airspace)
    return course, WAY.findall(contingency_strip(forecast, course))


@pytest.mark.parametrize("name", some(2, ["campus.toml", "sitl.toml", "downtown.toml"]))
def test_the_bars_are_the_rows_of_the_forecast(forecast: Foreseen, name: str) -> None:
    _, ways = strip_of(forecast(name))
    rows = {str(row): row for row in Contingencies(forecast(name)).all_rows(timed=False)}
    assert sorted(unescape(title) for _, _, title, *_ in ways) == sorted(rows)
    for look, label, title, contingency, begin, end, keeps, *_, words in ways:
        row = rows[unescape(title)]
        assert (label, contingency, unescape(keeps)) == (title, str(row.contingency), row.keeps)
        assert (float(begin), float(end)) == pytest.approx((row.from_s, row.to_s), abs=0.006)
        assert look == {Grade.CLEAR: "clear", Grade.POSSIBLY_UNCLEAR: "perhaps", Grade.UNCLEAR: "not-clear"}[row.grade]
        assert words in ("", look.replace("-", " "))
    assert any(look == "not-clear" for look, *_ in ways)


def test_bars_lie_under_the_profile_where_the_vehicle_is_then(forecast: Foreseen) -> None:
    course, ways = strip_of(forecast("sitl.toml"))
    axis = along_axis(course)
    for _, _, _, _, begin, end, _, left, width, _ in ways:
        first, last = axis.place(np.interp([float(begin), float(end)], course.times, course.along))
        assert float(left) == pytest.approx(100 * first, abs=0.1)
        assert float(width) == pytest.approx(max(100 * (last - first), 0.4), abs=0.1)


def test_unclear_contingencies_are_listed_below_in_words(forecast: Foreseen) -> None:
    unclear = [str(row) for row in Contingencies(forecast("sitl.toml")).all_rows(timed=False) if not row.clear]
    (listed,) = re.findall(r'<ul class="ways-not-clear">(.*?)</ul>', page_of(forecast("sitl.toml")))
    assert [unescape(line) for line in re.findall("<li>(.*?)</li>", listed)] == unclear != []


def test_strip_says_that_every_contingency_is_clear(bowed: Bowed) -> None:
    scenario, mission, _ = bowed("sitl.toml")
    text = scenario.model_dump(mode="json") | {"obstacles": []}
    page = page_of(Forecast(mission, Scenario.model_validate(text)))
    assert '<p class="note">Every contingency is clear.</p>' in page
    assert "ways-not-clear" not in page[page.index("</style>") :]


def test_a_name_in_the_way_cannot_become_markup(bowed: Bowed) -> None:
    scenario, mission, _ = bowed("sitl.toml")
    text = scenario.model_dump(mode="json")
    for obstacle in text["obstacles"]:
        obstacle["name"] = '"><b onclick="x">\'&'
    _, ways = strip_of(Forecast(mission, Scenario.model_validate(text)))
    assert any(unescape(title).endswith('m inside "><b onclick="x">\'&') for _, _, title, *_ in ways)


def test_only_what_the_vehicle_has_is_drawn(forecast: Foreseen) -> None:
    drawn = {name: {row[3] for row in strip_of(forecast(name))[1]} for name in ("campus.toml", "sitl.toml")}
    assert drawn == {"campus.toml": {"rtl", "land", "smart_rtl", "hold"}, "sitl.toml": {"rtl", "land", "hold"}}


def test_unknown_flight_has_no_strip(bowed: Bowed) -> None:
    scenario, mission, timed = bowed("sitl.toml")
    course = sample_track(timed.track, scenario.airspace)
    assert contingency_strip(Forecast(replace(mission, items=()), scenario), course) == ""
