"""Contingencies ordered at random seconds on real autopilots, against the forecast of each second.

docs/data/returns.csv has every order (tools/fly/endings_judge.py of commit b6e82bdb).
`flown_contingencies/` has some missions.
"""

import csv
import math
import re
from collections.abc import Iterator
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from ipoa_mission import Forecast, read_mission, read_scenario
from ipoa_mission.autopilot.autopilot import Autopilot, autopilot_named
from ipoa_mission.autopilot.failsafe import Contingency, FlightStage
from ipoa_mission.autopilot.version import Version
from ipoa_mission.forecast.contingency.contingencies import Contingencies, ContingencyRow, predict_contingency
from ipoa_mission.forecast.timing.flight_model import FlightModel
from ipoa_mission.geodesy import Geodetic
from ipoa_mission.mission.items import Mission, land, takeoff, waypoint

Row = dict[str, str]
ROWS: list[Row] = list(csv.DictReader(Path("docs/data/returns.csv").read_text(encoding="utf-8").splitlines()))
MISSIONS = Path(__file__).with_name("flown_contingencies")
BOTH_AT_ONCE = "where the voltage falls through both at once"
NOT_A_CONTINGENCY = {"ALT_HOLD": "alt_hold", "LOITER": "loiter", "flies aside": "aside"}
FAR_OUTSIDE = "100 m outside it lands"
AUTOPILOTS = sorted({row["autopilot"] for row in ROWS})
FLOWN_ON = {"ardupilot": Version(4, 8, 0, "dev"), "px4": Version(1, 17)}
LEAST_ORDERS, LEAST_KINDS, LEAST_PLANNED = 400, 12, 60
#: Impossible in simulation.
NOT_MADE = ("propeller out of balance", "attitude or motor failure (SYS_FAILURE_EN")
LIKELY, FALSE_ALARMS = 20, 0.1  # least number called not clear; greatest share of these that keep the distance
SHORT = 10.0  # of shorter contingencies no share is counted [s]
#: Relative errors: median, and nine of ten.
TIMES = {
    ("ardupilot", Contingency.RTL): (0.015, 0.03),
    ("ardupilot", Contingency.LAND): (0.01, 0.04),
    ("px4", Contingency.RTL): (0.025, 0.10),
    ("px4", Contingency.LAND): (0.07, 0.17),
}
WITHIN = 0.86  # the interval of nine in ten
#: PX4's from this number on were flown later, against the interval.
LATER, WITHIN_LATER = 1000, 0.8
#: The same until touchdown, in the median; least number of orders; time on the ground.
TOUCHES = [
    ("ardupilot", Contingency.RTL, 0.015),
    ("ardupilot", Contingency.LAND, 0.015),
    ("px4", Contingency.RTL, 0.03),
    ("px4", Contingency.LAND, 0.05),
]
LEAST_TOUCHES, LEAST_STANDING = 9, 1.0  # the second in [s]
OFF = {"ardupilot": (0.04, 1.5), "px4": (0.12, 6.0)}  # the most that one flight is, share or seconds


def flown(autopilot: str) -> list[Row]:
    return [row for row in ROWS if row["autopilot"] == autopilot]


def by_obstacles(autopilot: str) -> Iterator[tuple[Row, bool, bool]]:
    """Return rows in which obstacles decide: called clear, kept the required distance."""
    for row in flown(autopilot):
        if row["ending"] in list(Contingency) and math.isfinite(float(row["least"])) and row["to"] != "the ground":
            kept = float(row["flown_least"]) >= float(row["required"])
            yield row, row["clear"] == "True", kept


@pytest.mark.parametrize("autopilot", AUTOPILOTS)
def test_enough_was_flown(autopilot: str) -> None:
    rows = flown(autopilot)
    assert len(rows) >= LEAST_ORDERS
    assert len({row["mission"] for row in rows}) >= 20
    assert len({row["trigger"] for row in rows if row["trigger"]}) >= LEAST_KINDS


@pytest.mark.parametrize("autopilot", AUTOPILOTS)
def test_flights_nearer_than_required_were_predicted(autopilot: str) -> None:
    unforetold = [(row["mission"], row["second"]) for row, clear, kept in by_obstacles(autopilot) if clear and not kept]
    assert unforetold == []


def test_unclear_returns_come_nearer_and_most_that_come_nearer_are_unclear() -> None:
    """PX4's spread is wide: some is perhaps not clear."""
    graded = [(row["grade"], kept) for row, _, kept in by_obstacles("px4") if row["grade"]]
    unclear = [kept for grade, kept in graded if grade == "unclear"]
    nearer = [grade for grade, kept in graded if not kept]
    assert len(unclear) >= LIKELY
    assert sum(unclear) <= FALSE_ALARMS * len(unclear)
    assert nearer.count("unclear") >= (1.0 - FALSE_ALARMS) * len(nearer)
    assert set(nearer) <= {"unclear", "possibly_unclear"}


@pytest.mark.parametrize("autopilot", AUTOPILOTS)
def test_no_planned_return_came_nearer_than_required(autopilot: str) -> None:
    planned = [(row, kept) for row, _, kept in by_obstacles(autopilot) if row["planned"] == "returns"]
    returns = [(row, kept) for row, kept in planned if row["ending"] != Contingency.LAND]
    assert len(returns) >= LEAST_PLANNED
    assert all(row["clear"] == "True" for row, _ in returns)
    assert [row["number"] for row, kept in returns if not kept] == []


def timed(autopilot: str, contingency: Contingency) -> list[Row]:
    ordered = (row for row in flown(autopilot) if row["ending"] == row["did"] == contingency and not row["trigger"])
    return [row for row in ordered if math.isfinite(float(row["expected_s"]))]


@pytest.mark.parametrize("autopilot", AUTOPILOTS)
@pytest.mark.parametrize("contingency", [Contingency.RTL, Contingency.LAND])
def test_contingencies_last_as_long_as_expected(autopilot: str, contingency: Contingency) -> None:
    rows = [row for row in timed(autopilot, contingency) if int(row["number"]) < LATER]
    lasted, expected = (np.array([float(row[name]) for row in rows]) for name in ("flown_s", "expected_s"))
    off = np.abs(expected / lasted - 1.0)[lasted > SHORT]
    median, most = TIMES[autopilot, contingency]
    assert np.median(off) <= median
    assert np.quantile(off, 0.9) <= most


@pytest.mark.parametrize("autopilot", AUTOPILOTS)
@pytest.mark.parametrize("contingency", [Contingency.RTL, Contingency.LAND])
def test_contingencies_last_as_long_as_their_intervals_say(autopilot: str, contingency: Contingency) -> None:
    rows = timed(autopilot, contingency)
    within = [float(row["low_s"]) <= float(row["flown_s"]) <= float(row["high_s"]) for row in rows]
    later = [is_within for row, is_within in zip(rows, within, strict=True) if int(row["number"]) >= LATER]
    assert sum(within) >= WITHIN * len(within)
    assert sum(later) >= WITHIN_LATER * len(later)


@pytest.mark.parametrize(("autopilot", "contingency", "median"), TOUCHES)
def test_the_ground_is_touched_when_it_was_forecast(autopilot: str, contingency: Contingency, median: float) -> None:
    """PX4 then stays armed for a time of its own."""
    rows = [row for row in timed(autopilot, contingency) if math.isfinite(float(row["touched_s"]))]
    names = ("touch_low_s", "touch_expected_s", "touch_high_s", "touched_s", "flown_s")
    low, expected, high, touched, lasted = (np.array([float(row[name]) for row in rows]) for name in names)
    assert len(rows) >= LEAST_TOUCHES
    assert (touched < lasted - LEAST_STANDING).all()
    assert ((low <= touched) & (touched <= high)).mean() >= WITHIN_LATER
    assert np.median(np.abs(expected / touched - 1.0)[lasted > SHORT]) <= median


def said_of(row: Row) -> str:
    match = re.fullmatch(r"(.+) \(([^()]*)\)", row["trigger"])
    assert match
    cause, settings = match.groups()
    parameters = {name: float(value) for name, value in (each.split() for each in settings.split(", ") if each)}
    autopilot, version = autopilot_named(row["autopilot"]), FLOWN_ON[row["autopilot"]]
    stage = FlightStage(row["stage"])
    route = next(failsafe for failsafe in autopilot.failsafes(parameters, version) if failsafe.cause == cause).at(stage)
    if BOTH_AT_ONCE in route.words:  # so it was made to fall
        failsafes = autopilot.failsafes({**parameters, "BATT_LOW_VOLT": 0.0}, version)
        route = next(failsafe for failsafe in failsafes if failsafe.cause == cause).at(stage)
    if route.contingency is Contingency.LAND_START:  # none of the missions has one
        return str(route.fallbacks[0])
    if route.contingency is Contingency.UNKNOWN:
        known = (does for words, does in NOT_A_CONTINGENCY.items() if route.words.startswith(words))
        return next(known, None) or f"unknown or {route.fallbacks[0]}"
    may_land = route.words == FAR_OUTSIDE or (
        route.contingency is Contingency.CONTINUE and Contingency.LAND in route.fallbacks
    )
    return f"{route.contingency} or land" if may_land else str(route.contingency)


@pytest.mark.parametrize("autopilot", AUTOPILOTS)
def test_failsafes_do_what_is_said_of_them(autopilot: str) -> None:
    otherwise = []
    for row in flown(autopilot):
        did = (row["did"].split() or ["continue"])[-1]
        if row["trigger"] and did not in said_of(row).split(" or "):
            otherwise.append((row["trigger"].startswith(NOT_MADE), did))
    assert otherwise == [(True, "continue")] * len(otherwise)


@pytest.mark.parametrize(("autopilot", "least"), [("ardupilot", 14), ("px4", 12)])
def test_so_many_causes_were_made(autopilot: str, least: int) -> None:
    triggered = [row for row in flown(autopilot) if row["trigger"] and not row["trigger"].startswith(NOT_MADE)]
    made = [(row["trigger"].split(" (")[0], row["ending"]) for row in triggered]
    assert len({cause for cause, _ in made}) >= least
    assert len(set(made)) >= 2 * LEAST_KINDS


@cache
def contingencies_of(mission: str) -> Contingencies:
    path = MISSIONS / f"{mission}.plan"
    scenario = read_scenario(path.with_suffix(".toml"))
    flown = read_mission(path, scenario.vehicle.autopilot)
    return Contingencies(Forecast(replace(flown, firmware_version=FLOWN_ON[str(flown.autopilot)]), scenario))


def row_at(contingencies: Contingencies, contingency: Contingency, time: float) -> ContingencyRow:
    rows = contingencies.rows(contingency, timed=False)
    return next((row for row in rows if time < row.to_s), rows[-1])


def ordered_here() -> list[Row]:
    here = {path.stem for path in MISSIONS.glob("*.plan")}
    return [row for row in ROWS if row["mission"] in here and not row["trigger"]]


@pytest.mark.parametrize("row", ordered_here(), ids=lambda row: f"{row['mission']}-{row['number']}-{row['ending']}")
def test_the_model_still_foretells_what_was_flown(row: Row) -> None:
    contingencies, contingency, second = (
        contingencies_of(row["mission"]),
        Contingency(row["ending"]),
        float(row["second"]),
    )
    second = float(np.clip(second, *contingencies.in_air))
    predicted = row_at(contingencies, contingency, second)
    if float(row["flown_least"]) < float(row["required"]):
        assert not predicted.clear
    elif row["clear"] == "True":
        assert predicted.clear
    assert predicted.grade.name.lower() == (row["grade"] or predicted.grade.name.lower())
    if contingency in (Contingency.RTL, Contingency.LAND) and row["did"] == contingency:
        forecast = contingencies.forecast
        model = forecast.mission.autopilot.part(FlightModel)
        prediction = model.predict_contingency(forecast.itinerary, forecast.wind, contingency, second)
        share, seconds = OFF[row["autopilot"]]
        assert float(prediction.done[-1]) - second == pytest.approx(float(row["flown_s"]), rel=share, abs=seconds)


#: RTL during the take-off at home, on ArduCopter 4.8.0-dev: height of the take-off, second of the order, duration.
AT_HOME = [(45.0, 11.03, 38.75), (19.0, 10.09, 37.19), (15.0, 7.34, 27.35), (12.0, 9.75, 33.87)]


@pytest.mark.parametrize(("up", "second", "flown_s"), AT_HOME)
def test_returns_from_a_takeoff_last_as_long_as_flown(up: float, second: float, flown_s: float) -> None:
    home = Geodetic(47.397742, 8.545594, 488.0)
    away = Geodetic(47.3987, 8.5456, 488.0)
    items = (takeoff(home, up), waypoint(away, up), land(away))
    forecast = Forecast(Mission(home, items, Autopilot.ARDUPILOT, firmware_version=FLOWN_ON["ardupilot"]))
    predicted = predict_contingency(forecast, Contingency.RTL, second)
    low, high = predicted.duration_s
    assert low <= flown_s <= high
    assert high - low < 2.5
