import math
from contextlib import nullcontext
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from ipoa_mission import Forecast, read_mission, read_scenario
from ipoa_mission.autopilot.failsafe import Contingency
from ipoa_mission.flight.preflight import expect_charge
from ipoa_mission.flight.procedure import ContingencyDisplay
from ipoa_mission.forecast.contingency.contingencies import Contingencies
from ipoa_mission.forecast.contingency.contingencies_now import ContingenciesNow
from ipoa_mission.forecast.contingency.energy_budget import ReserveNow, budget_of
from ipoa_mission.link.messages import BatteryStatus, Position, SystemStatus
from ipoa_mission.link.vehicle_state import VehicleState
from tests.examples import some
from tests.refused import refuses

MISSIONS = Path(__file__).parents[2] / "missions"


BATTERY = """
[vehicle.battery]
capacity_wh = 60.0
reserve = 0.25

[vehicle.airframe]
mass_kg = 2.0
rotor_diameter = 0.3
"""


def forecast_with(battery: str, folder: Path) -> Forecast:
    world = folder / "sitl.toml"
    world.write_text((MISSIONS / "sitl.toml").read_text(encoding="utf-8") + battery, encoding="utf-8")
    return Forecast(read_mission(MISSIONS / "sitl.plan"), read_scenario(world))


@pytest.fixture(scope="module")
def forecast(tmp_path_factory: pytest.TempPathFactory) -> Forecast:
    return forecast_with(BATTERY, tmp_path_factory.mktemp("world"))


@pytest.mark.parametrize(("late", "share"), some(2, [(-5.0, 0.1), (5.0, 0.9), (0.0, 0.45), (5.0, 0.1), (-5.0, 0.9)]))
def test_contingencies_begin_at_the_place_of_a_late_vehicle(forecast: Forecast, late: float, share: float) -> None:
    contingencies, now = Contingencies(forecast), ContingenciesNow(forecast)
    begin, end = contingencies.in_air
    time = begin + share * (end - begin)
    place = contingencies.stops().at(np.array([time]))[0][0]
    nearest_s, aside = now.time_at(place, time + late)
    assert aside < 1.0
    rows = {row.contingency: (row, seconds) for row, seconds in now.at(nearest_s)}
    assert set(rows) == {Contingency.RTL, Contingency.LAND}
    for contingency, (row, seconds) in rows.items():
        assert row.from_s - 0.3 <= time <= row.to_s + 0.3
        predicted = contingencies.predicted(contingency, time)
        assert predicted is not None
        assert seconds == pytest.approx(sum(predicted.duration_s) / 2, rel=0.25, abs=3.0)


def test_duration_is_given_also_where_it_jumps() -> None:
    """It climbs by 45 m before it returns: 37 s become 98."""
    forecast = Forecast(read_mission(MISSIONS / "campus.plan"), read_scenario(MISSIONS / "campus.toml"))
    contingencies, now = forecast.cached(Contingencies), ContingenciesNow(forecast)
    took = []
    for time in np.linspace(12.0, 26.0, 29):
        predicted = contingencies.predicted(Contingency.RTL, float(time))
        assert predicted is not None
        ((_, seconds),) = [row for row in now.at(float(time)) if row[0].contingency is Contingency.RTL]
        took.append(sum(predicted.duration_s) / 2)
        assert seconds == pytest.approx(took[-1], abs=6.0)
    assert max(took) - min(took) > 40.0


@pytest.mark.parametrize(("climb", "nearer"), [(0.0, 0.0), (-1.5, 1.09), (3.0, 0.0)])
def test_a_hold_off_the_path_counts_its_run_on_in_height(climb: float, nearer: float) -> None:
    now = ContingenciesNow(Forecast(read_mission(MISSIONS / "sitl.plan"), read_scenario(MISSIONS / "sitl.toml")))
    over_hangar = np.array([80.0, 75.0, 30.0])
    still, moving = (
        now.from_here(Contingency.HOLD, over_hangar, np.array([0.0, 0.0, up])).least_m for up in (0.0, climb)
    )
    assert still - moving == pytest.approx(nearer, abs=0.01)


def test_one_that_is_held_for_long_is_looked_for_where_it_is(forecast: Forecast) -> None:
    contingencies, now = (
        Contingencies(forecast),
        ContingenciesNow(forecast, (Contingency.HOLD, Contingency.RTL, Contingency.LAND)),
    )
    begin, end = contingencies.in_air
    times = np.arange(begin + 5.0, end - 5.0)
    held_s, at = 60.0, len(times) // 2
    clock = [*times[:at], *(times[at] + np.arange(held_s)), *(times[at:] + held_s)]
    flown = [*times[:at], *([times[at]] * int(held_s)), *times[at:]]
    for clock_s, time in zip(clock, flown, strict=True):
        nearest_s, aside = now.time_at(contingencies.stops().at(np.array([time]))[0][0], clock_s)
        assert abs(nearest_s - time) < 1.5
        assert aside < 1.0
    assert now.time_at(contingencies.stops().places[-1] + 300.0, clock[-1])[1] > 300.0  # it has been sent elsewhere
    assert [(row.contingency, seconds is None) for row, seconds in now.at(float(times[at]))] == [
        (Contingency.HOLD, True),
        (Contingency.RTL, False),
        (Contingency.LAND, False),
    ]


def test_the_command_line_tells_it_beside_what_is_done(forecast: Forecast) -> None:
    contingencies, printed, reserves = Contingencies(forecast), list[str](), list[ReserveNow]()
    time = sum(contingencies.in_air) / 2
    there = forecast.frame.geodetic(contingencies.stops().at(np.array([time]))[0][0])
    record = SimpleNamespace(path=[SimpleNamespace(time_s=time)])
    vehicle: Any = SimpleNamespace(record=lambda: record, state=SimpleNamespace(in_air=True, battery_left=None))
    teller = ContingencyDisplay(
        forecast, vehicle, lambda _, words: printed.append(words), reserves, ContingenciesNow(forecast)
    )
    teller.show(0.5, "item 3 of 6")
    at = (there.latitude_deg, there.longitude_deg, there.altitude, 20.0)
    for later, left in ((0.0, None), (0.4, 0.8), (1.2, 0.8), (2.4, 0.8), (3.6, 0.2)):  # by the vehicle's clock
        vehicle.state.battery_left = left
        teller.hear(Position(time + later, *at))
    assert printed[0] == "item 3 of 6"
    assert len(printed) == 5
    assert all(words.startswith("item 3 of 6  now: rtl ") and "; land " in words for words in printed[1:])
    assert ["; battery " in words for words in printed[1:]] == [False, True, True, True]
    assert "battery 80%, " in printed[2]
    assert printed[4].endswith("NOT the 25% required")
    assert [reserve.left for reserve in reserves] == [0.8, 0.2]
    far = forecast.frame.geodetic(contingencies.stops().at(np.array([time]))[0][0] + np.array([40.0, 40.0, 0.0]))
    teller.hear(Position(time + 5.0, far.latitude_deg, far.longitude_deg, far.altitude, 20.0))
    assert printed[-1].startswith("item 3 of 6  now: off its path: not forecast from here")


def test_a_vehicle_that_says_its_battery_is_not_enough_is_not_flown(forecast: Forecast) -> None:
    state = VehicleState(forecast.mission.autopilot)
    vehicle: Any = SimpleNamespace(state=state)
    assert expect_charge(vehicle, forecast) == (
        "the battery was not compared with this flight: the vehicle reports no charge",
    )
    for message in (SystemStatus(0, 0, 0, battery_remaining=-1), BatteryStatus(1, 12.0, -1.0, 10)):
        state.note(message)  # not measured; of another battery
        expect_charge(vehicle, forecast)
    budget = budget_of(forecast)
    assert budget is not None
    assert budget.battery is not None
    takes = budget.used.between.likely / budget.battery.capacity_wh
    enough = math.ceil(100 * (takes + budget.battery.reserve))
    for left, is_flown in ((enough, True), (enough - 2, False), (97, True)):
        state.note(BatteryStatus(0, 12.0, -1.0, left))
        with nullcontext() if is_flown else refuses("low-battery", "", f"{left}%"):
            expect_charge(vehicle, forecast)
    state.note(BatteryStatus(0, 12.0, -1.0, enough - 2))
    expect_charge(vehicle, forecast, first=len(forecast.mission.items) - 1)  # what is left out takes nothing
    expect_charge(vehicle, Forecast(forecast.mission_as_read))  # whose battery nobody knows


@pytest.mark.parametrize(("left", "is_flown"), [(100, True), (99, False), (95, False)])
def test_a_flight_that_needs_all_but_its_reserve_needs_a_full_battery(
    forecast: Forecast, tmp_path: Path, left: int, is_flown: bool
) -> None:
    budget = budget_of(forecast)
    assert budget is not None
    capacity = budget.used.between.likely / 0.75
    exact = forecast_with(BATTERY.replace("60.0", f"{capacity!r}"), tmp_path)
    state = VehicleState(exact.mission.autopilot)
    state.note(BatteryStatus(0, 12.0, -1.0, left))
    with nullcontext() if is_flown else refuses("low-battery", "", f"{left}%", "25% must be left"):
        expect_charge(SimpleNamespace(state=state), exact)  # type: ignore[arg-type]
