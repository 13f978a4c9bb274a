"""Power by airspeed and climb, learned from one flight.

docs/data/energy.csv: flights of simulated ArduCopter 4.8.0-dev. `survey_battery`, the only one that is learned from,
is cut by `tools.fly.trim_log`.
"""

import csv
import json
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from ipoa_mission.autopilot.autopilot import Autopilot
from ipoa_mission.autopilot.energy import Interval, PowerCurve
from ipoa_mission.autopilot.learned import LearnedVehicle, read_vehicle
from ipoa_mission.cli.app import app
from ipoa_mission.forecast.forecast import Forecast
from ipoa_mission.learn.fit import fit, flights_in
from ipoa_mission.learn.flight_measurements import PowerSeconds, learned_powers
from ipoa_mission.mission.mission_io import read_mission
from ipoa_mission.wind import CALM, Wind
from tests.recorded_flights import FLOWN_ON

HERE = Path(__file__).parent
REPOSITORY = HERE.parents[1]
LOG = HERE / "survey_battery-ardupilot.bin"
FAR_UP = 50.0  # [m]: a wind that grows so far
NAMES = ("hover_power", "square_power", "cube_power", "climb_power", "descent_power")
RECORDED = (REPOSITORY / "docs" / "data" / "energy.csv").read_text(encoding="utf-8").splitlines()
FLOWN = [row for row in csv.DictReader(RECORDED) if row["likely_wh"]]


@cache
def learned() -> LearnedVehicle:
    flights, _, _, _ = flights_in(LOG)
    return LearnedVehicle(Autopilot.ARDUPILOT).with_numbers(learned_powers([flights[0].measured.powers]))  # type: ignore[list-item]


def wind_of(row: dict[str, str]) -> Wind:
    """In the simulator it grows with the root of the height."""
    height = float(row["gradient_height_m"])
    law = Wind(float(row["wind_m_s"]), float(row["from_deg"]), 0.5 if height else 0.0, height)
    if height < FAR_UP or not law.speed:
        return law if law.speed else CALM
    heights = [0.0, 2.0, 6.0, 12.0, 20.0, 30.0, 45.0, 60.0]
    return Wind.of_profile(heights, [law.speed_at(up) for up in heights], [law.from_deg] * len(heights))


def forecast(row: dict[str, str], wind: Wind | None = None) -> Interval:
    path = REPOSITORY / row["mission"]
    mission = read_mission(path if path.suffix else path / "mission.waypoints", Autopilot.ARDUPILOT)
    version = FLOWN_ON[mission.autopilot]
    flown = replace(mission, vehicle=learned(), landing_ground=None, firmware_version=version)  # level ground
    used = Forecast(flown, wind=wind or wind_of(row)).energy
    assert used is not None
    return used.between


@pytest.mark.parametrize("row", FLOWN[1::3], ids=lambda row: f"{row['mission']}-{row['wind_m_s']}@{row['from_deg']}")
def test_energy_of_flights_in_wind_is_predicted_after_one_flight(row: dict[str, str]) -> None:
    measured, predicted = float(row["measured_wh"]), forecast(row)
    assert predicted.likely == pytest.approx(measured, rel=0.03)
    assert predicted.low < measured < predicted.high
    assert predicted.likely == pytest.approx(float(row["likely_wh"]), abs=0.02)


def test_a_profile_tells_what_one_wind_for_all_heights_does_not() -> None:
    grown = [row for row in FLOWN if float(row["gradient_height_m"]) >= FAR_UP]
    assert len(grown) == 2
    for row in grown:
        measured, level = float(row["measured_wh"]), Wind(float(row["wind_m_s"]), float(row["from_deg"]))
        assert forecast(row).likely == pytest.approx(measured, rel=0.015)
        assert forecast(row, level).likely > 1.05 * measured


def test_energy_of_recorded_flights_within_five_per_cent() -> None:
    errors = [abs(float(row["likely_wh"]) / float(row["measured_wh"]) - 1.0) for row in FLOWN[1:]]
    assert len(errors) > 20
    assert max(errors) < 0.05
    assert all(float(row["low_wh"]) < float(row["measured_wh"]) < float(row["high_wh"]) for row in FLOWN)


def test_numbers_that_made_the_seconds_are_found_again() -> None:
    """A vehicle with a bucket in its curve, as real ones have, and noise on every second."""
    rng = np.random.default_rng(3)
    curve = PowerCurve(300.0, -1.2, 0.16, 25.0, -8.0)
    airspeed, climb = rng.uniform(0.0, 14.0, 900), rng.uniform(-2.0, 2.5, 900)
    watts = curve.power(airspeed, climb) * rng.normal(1.0, 0.03, 900)
    numbers = learned_powers([PowerSeconds(watts, airspeed, climb)])
    fitted = PowerCurve(*(numbers[name].value for name in NAMES))
    speeds = np.linspace(0.0, 14.0, 8)
    assert fitted.level(speeds) == pytest.approx(curve.level(speeds), rel=0.03)
    assert numbers["climb_power"].low < 25.0 < numbers["climb_power"].high


def test_slow_flights_give_no_power_curve_and_no_hover_widens_its_range() -> None:
    slow = PowerSeconds(np.full(300, 200.0), np.full(300, 2.0), np.zeros(300))
    assert learned_powers([slow]) == {}
    assert learned_powers([]) == {}
    fast = PowerSeconds(np.full(300, 200.0), np.linspace(6.0, 9.0, 300), np.zeros(300))
    both = np.concatenate([np.zeros(100), np.linspace(0.0, 9.0, 200)])
    seen = PowerSeconds(np.full(300, 200.0), both, np.zeros(300))
    assert learned_powers([fast])["energy_ratio"].high > 1.09 > learned_powers([seen])["energy_ratio"].high


def test_learn_takes_one_flight_for_its_power_alone(tmp_path: Path) -> None:
    out = tmp_path / "vehicle.toml"
    done = CliRunner().invoke(app, ["learn", str(LOG), "--out", str(out)])
    assert done.exit_code == 0, done.output
    assert "one flight gives the hover power" in " ".join(done.output.split())
    vehicle = read_vehicle(out)
    assert vehicle.drag is None
    assert vehicle.hover_power is not None
    assert vehicle.hover_power.value == pytest.approx(352.0, rel=0.03)  # 29.3 A at 12.09 V in the simulator
    assert fit(flights_in(LOG)[0]).square_power is not None
    document = json.loads(CliRunner().invoke(app, ["learn", str(LOG), "--out", str(out), "--force", "--json"]).output)
    assert document["vehicle"]["autopilot"] == vehicle.autopilot.name
    assert document["vehicle"]["hover_power"]["value"] == pytest.approx(vehicle.hover_power.value, rel=1e-3)
    assert document["undetermined"].keys() == {name for name, value in document["vehicle"].items() if value is None}
    assert "drag" in document["undetermined"]


def test_real_flights_are_foretold_by_the_others(samples: Path) -> None:
    """Five flights of a real quadrotor in dronekit's replay log, each by the others."""
    flights, _, _, _ = flights_in(samples / "dronekit+dronekit-python" / "examples" / "flight_replay" / "flight.tlog")
    seconds = [flight.measured.powers for flight in flights if flight.measured.powers is not None]
    errors = []
    for n, second in enumerate(seconds):
        numbers = learned_powers([*seconds[:n], *seconds[n + 1 :]])
        predicted = PowerCurve(*(numbers[name].value for name in NAMES)).power(second.airspeed, second.climb)
        errors.append(abs(float(predicted.sum() / second.watts.sum()) - 1.0))
    assert len(errors) == 5
    assert float(np.median(errors)) < 0.08
