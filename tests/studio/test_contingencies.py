from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("tomlkit")

from ipoa_mission import Forecast, read_mission, read_scenario
from ipoa_mission.autopilot.failsafe import Contingency
from ipoa_mission.forecast.contingency.contingencies import Contingencies, Grade
from ipoa_mission.forecast.contingency.energy_budget import budget_of
from ipoa_mission.studio.answers import ContingencyStrip, StripCost
from ipoa_mission.studio.plan_answers import course_of, strips_of
from tests.forecast.test_contingencies_now import BATTERY
from tests.report_pages import page_of

MISSIONS = Path(__file__).parents[2] / "missions"


@pytest.fixture(scope="module")
def forecast(tmp_path_factory: pytest.TempPathFactory) -> Forecast:
    world = tmp_path_factory.mktemp("world") / "sitl.toml"
    world.write_text((MISSIONS / "sitl.toml").read_text(encoding="utf-8") + BATTERY, encoding="utf-8")
    return Forecast(read_mission(MISSIONS / "sitl.plan"), read_scenario(world))


@pytest.fixture(scope="module")
def strips(forecast: Forecast) -> tuple[ContingencyStrip, ...]:
    return tuple(strips_of(forecast, 2))


def test_the_strip_has_the_rows_of_the_forecast_as_the_report_has(
    forecast: Forecast, strips: tuple[ContingencyStrip, ...]
) -> None:
    strip, page, course = strips[0], page_of(forecast), course_of(forecast)
    assert [strip.flight for strip in strips] == [2] * 2
    rows = Contingencies(forecast).all_rows(timed=False)
    stretches = [(bar.contingency, stretch) for bar in strip.bars for stretch in bar.stretches]
    assert len(stretches) == len(rows) > len(strip.bars) == 3
    for (contingency, stretch), row in zip(stretches, rows, strict=True):
        assert (contingency, stretch.words) == (str(row.contingency), row.in_full)
        assert row.keeps in stretch.words
        assert "2.50 m required" in stretch.words
        looks = {Grade.CLEAR: "clear", Grade.POSSIBLY_UNCLEAR: "perhaps", Grade.UNCLEAR: "not clear"}
        assert stretch.look == looks[row.grade]
        assert (stretch.from_s, stretch.to_s) == pytest.approx((row.from_s, row.to_s), abs=0.006)
        there = np.interp([row.from_s, row.to_s], course.times, course.along)
        assert (stretch.begins, stretch.ends) == pytest.approx(there, abs=0.06)
        assert f'data-contingency="{contingency}" data-from="{stretch.from_s:.2f}" data-to="{stretch.to_s:.2f}"' in page


def between(costs: tuple[StripCost, ...], time: float) -> list[float]:
    """What the page makes of the costs beside a moment."""
    shares = [(*cost.seconds, *(cost.energy_wh or ()), cost.lands, cost.least, cost.most) for cost in costs]
    return [float(np.interp(time, [cost.at_s for cost in costs], column)) for column in zip(*shares, strict=True)]


@pytest.mark.parametrize("contingency", [Contingency.RTL, Contingency.LAND])
def test_the_energy_of_a_contingency_lies_between_its_neighbors(
    forecast: Forecast, strips: tuple[ContingencyStrip, ...], contingency: Contingency
) -> None:
    contingencies, budget = Contingencies(forecast), budget_of(forecast)
    assert budget is not None
    assert not any(bar.costs for bar in strips[0].bars)
    assert strips[1].reserve == 0.25
    (bar,) = (bar for bar in strips[1].bars if bar.contingency == contingency)
    begin, end = contingencies.in_air
    for time in np.linspace(begin + 1.0, end - 1.0, 7).tolist():
        taken = contingencies.predicted(contingency, time)
        assert taken is not None
        assert taken[1] is not None
        used, left = taken[1].between, budget.left(budget.taken(time, taken[1]))
        assert left is not None
        low, high, least_wh, most_wh, lands, least, most = between(bar.costs, time)
        assert (low, high) == pytest.approx(taken[0], rel=0.15, abs=4.0)
        assert (least_wh, most_wh) == pytest.approx((used.low, used.high), rel=0.15, abs=0.5)
        assert (least, lands, most) == pytest.approx(left, abs=0.01)
    assert min(value for cost in bar.costs for value in cost.seconds) >= 0.0


def test_one_that_does_not_land_has_no_cost(strips: tuple[ContingencyStrip, ...]) -> None:
    assert {bar.contingency: bool(bar.costs) for bar in strips[1].bars} == {"rtl": True, "land": True, "hold": False}


def test_unknown_destination_is_told(forecast: Forecast) -> None:
    elsewhere = replace(forecast.mission_as_read, parameters={**forecast.mission_as_read.parameters, "RTL_TYPE": 1.0})
    *_, strip = strips_of(Forecast(elsewhere, forecast.scenario), 0)
    bar = strip.bars[0]
    assert (bar.contingency, [stretch.look for stretch in bar.stretches], bar.costs) == ("rtl", ["unknown"], ())
    assert "goal unknown: not clear: returns to the mission's landing" in bar.stretches[0].words


def test_mission_without_a_world_has_no_bar(forecast: Forecast) -> None:
    (strip,) = strips_of(Forecast(forecast.mission_as_read), 0)
    assert strip.bars == ()
    assert strip.reserve is None
