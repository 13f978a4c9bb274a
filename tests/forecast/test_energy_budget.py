from functools import cache

import numpy as np
import pytest

from ipoa_mission.autopilot.autopilot import Autopilot
from ipoa_mission.autopilot.failsafe import Contingency
from ipoa_mission.autopilot.learned import Learned, LearnedVehicle
from ipoa_mission.checks.check import check_mission
from ipoa_mission.finding import Severity
from ipoa_mission.forecast.contingency.contingencies import predict_contingency
from ipoa_mission.forecast.contingency.energy_budget import Budget, budget_of
from ipoa_mission.forecast.forecast import Forecast
from ipoa_mission.mission.items import Mission, change_speed, land, takeoff, waypoint
from ipoa_mission.scenario import Scenario
from ipoa_mission.wind import CALM, Wind

HOME = {"latitude_deg": 47.397742, "longitude_deg": 8.545594, "altitude_amsl": 488.0}
AWAY = 400.0  # to the east [m]
LEARNED = LearnedVehicle(
    Autopilot.ARDUPILOT,
    hover_power=Learned(350.0, 345.0, 355.0),
    square_power=Learned(0.3, 0.2, 0.4),
    airspeed=Learned(10.0, 9.5, 10.5),
    energy_ratio=Learned(1.0, 0.95, 1.05),
)


@cache
def budget(capacity: float | None = None, wind: Wind = CALM, learned: bool = True) -> Budget:
    vehicle: dict[str, object] = {"autopilot": "ardupilot", "airframe": {"mass_kg": 3.0, "rotor_diameter": 0.35}}
    if capacity is not None:
        vehicle["battery"] = {"capacity_wh": capacity}
    ends = {"start": {"east": 0.0, "north": 0.0, "up": 15.0}, "goal": {"east": AWAY, "north": 0.0, "up": 15.0}}
    scenario = Scenario.from_dict({"name": "away", "home": HOME, **ends, "vehicle": vehicle})
    home, there = scenario.frame.home, scenario.frame.geodetic(np.array([AWAY, 0.0, 15.0]))
    half = scenario.frame.geodetic(np.array([AWAY / 2, 0.0, 15.0]))
    items = (takeoff(home, 15.0), change_speed(8.0), waypoint(half, 15.0), waypoint(there, 15.0), land(there))
    mission = Mission(home, items, Autopilot.ARDUPILOT, vehicle=LEARNED if learned else None)
    energy = budget_of(Forecast(mission, scenario, wind))
    assert energy is not None
    return energy


def planning(forecast: Forecast) -> Forecast:
    """The same in a scenario whose returns are to be planned."""
    safety = forecast.world.safety.model_copy(update={"returns": "planned"})
    return Forecast(forecast.mission_as_read, forecast.world.model_copy(update={"safety": safety}), forecast.wind)


def codes(capacity: float, planned: bool = False) -> dict[str, Severity]:
    forecast = budget(capacity).forecast
    forecast = planning(forecast) if planned else forecast
    return {finding.code: finding.severity for finding in check_mission(forecast.mission, forecast.scenario)}


@pytest.mark.parametrize("missing", [0.0, 0.1, 0.7])
def test_the_reserve_in_flight_is_the_measured_one_less_the_remaining_use(missing: float) -> None:
    energy = budget(20.0)
    middle, left = float(energy.used.times[-1]) / 2, energy.left(energy.used.between)
    now = energy.against_plan(1.0 - energy.used.until(middle).likely / 20.0 - missing, middle)
    assert now is not None
    assert left is not None
    assert now.planned - now.left == pytest.approx(missing)
    assert now.lands.likely == pytest.approx(left.likely - missing)
    assert left.low - missing < now.lands.low < now.lands.likely < now.lands.high < left.high - missing
    assert ("NOT the 20% required" in str(now)) == (left.likely - missing < 0.2)
    assert budget().against_plan(1.0, middle) is None


def test_items_come_to_the_whole_and_the_share_left_falls() -> None:
    energy = budget(20.0)
    assert sum(item.takes.likely for item in energy.items) == pytest.approx(energy.used.energy_wh)
    left = [item.left.likely for item in energy.items if item.left is not None]
    assert left == sorted(left, reverse=True)
    assert left[-1] == pytest.approx(1.0 - energy.used.energy_wh / 20.0)
    assert budget().items[0].left is None


def test_learned_power_is_surer_than_that_of_an_airframe() -> None:
    known, reckoned = budget().used.between, budget(learned=False).used.between
    assert known.low < known.likely < known.high
    assert known.high / known.low < 1.25
    assert reckoned.high / reckoned.low > 1.7


def test_a_headwind_raises_the_mean_power_by_the_airspeed() -> None:
    """Both ways take 8 m/s over ground; the airspeed is 13 and 3 m/s."""
    against, with_it = budget(wind=Wind(5.0, from_deg=90.0)).used, budget(wind=Wind(5.0, from_deg=270.0)).used
    assert against.mean_w > with_it.mean_w + 10.0


def test_no_return_begins_where_a_return_takes_more_than_remains() -> None:
    enough, scarce = budget(60.0), budget(14.2)
    assert enough.no_return is None
    assert enough.shortage is None
    assert scarce.shortage is None
    late = scarce.no_return
    assert late is not None
    assert late.takes is not None
    usable = 14.2 * 0.8
    taken = [scarce.used.until(time).likely + _return(time) for time in (late.time - 2.0, late.time)]
    assert taken[0] <= usable < taken[1] + 0.2
    assert late.seq in (3, 4)


def _return(time: float) -> float:
    used = predict_contingency(budget().forecast, Contingency.RTL, time).used
    assert used is not None
    return used.energy_wh


def test_a_planned_return_beyond_the_battery_is_refused() -> None:
    late = budget(14.2)
    assert late.refusal is None
    assert late.no_return is not None
    refused = budget_of(planning(late.forecast))
    assert refused is not None
    assert str(refused.refusal) == f"battery: {late.no_return}"
    assert "item 4: not enough for an RTL from" in str(late.no_return)
    enough = budget_of(planning(budget(60.0).forecast))
    assert enough is not None
    assert enough.refusal is None


def test_check_reports_energy_shortage_uncertainty_and_late_return() -> None:
    assert not [code for code in codes(60.0) if code.startswith("battery")]
    assert codes(14.2)["battery-no-return"] is Severity.WARNING
    assert codes(14.2, planned=True)["battery-no-return"] is Severity.ERROR
    takes = budget().used.between
    tight = (takes.likely + takes.high) / 2 / 0.8
    assert codes(tight)["battery-unsure"] is Severity.WARNING
    assert codes(takes.likely / 0.81)["battery-short"] is Severity.ERROR
