"""Hover power, energy and drag by tilt in real logs.

`other_vehicle-*` are cut from flights of `test_learning` by `tools.fly.trim_log`: ArduCopter's missions 0 and 4 (22 A
at 12.09 V in hover, 266 W; 0 also by the ground station, and in a wind of 5 m/s), and PX4's mission 0, whose battery
measures no current.
"""

import math
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from ipoa_mission.autopilot.autopilot import Autopilot
from ipoa_mission.autopilot.learned import Learned, LearnedVehicle, read_vehicle
from ipoa_mission.cli.app import app
from ipoa_mission.learn.fit import Evidence, cross_validate, energy_error, fit, flights_in, median_errors, timed
from ipoa_mission.learn.flight_measurements import FlightMeasurements, hover_power
from ipoa_mission.mission.mission_io import write_mission
from tests.logs.test_learning import ARDUPILOT, PX4, recorded
from tests.refused import refuses

HERE = Path(__file__).parent
LOGS = [HERE.parents[1] / "missions" / "logs" / f"copter-{speed}.bin" for speed in (6, 8)]  # [m/s]


def evidence_of(path: Path) -> Evidence:
    flights, _, _, _ = flights_in(path)
    assert len(flights) == 1
    return flights[0]


def drag(path: Path, autopilot: Autopilot = ARDUPILOT) -> float:
    mission = recorded(autopilot)[0].mission
    flights, _, _, _ = flights_in(path, lambda _: mission)
    assert flights[0].measured.log_drag is not None
    return math.exp(flights[0].measured.log_drag[0])


def test_slow_flights_tell_by_their_tilt_how_long_fast_ones_take() -> None:
    slow, fast = (
        [evidence_of(path) for path in LOGS],
        [recorded(ARDUPILOT)[n] for n in (2, 3, 5, 6)],
    )  # at 12 and 14 m/s
    before, after = median_errors(timed(fast, fit(slow)))
    assert before > 0.09
    assert after < 0.005
    times_only = [replace(flight, measured=FlightMeasurements()) for flight in slow]
    assert median_errors(timed(fast, fit(times_only)))[1] > 3 * after


def test_the_tilt_gives_the_drag_in_wind_and_of_px4() -> None:
    calm = [drag(path) for path in LOGS]
    assert calm == pytest.approx([1.48, 1.53], abs=0.01)
    assert drag(HERE / "other_vehicle_in_wind-0.bin") == pytest.approx(np.mean(calm), rel=0.03)
    assert drag(HERE / "other_vehicle-0.ulg", PX4) == pytest.approx(1.6, rel=0.03)  # SIH_KDV


def test_hovering_takes_what_the_battery_measured() -> None:
    flights = [evidence_of(path) for path in LOGS]
    vehicle = fit(flights)
    assert vehicle.hover_power is not None
    assert vehicle.hover_power.low < 22 * 12.09 < vehicle.hover_power.high
    assert vehicle.hover_power.value == pytest.approx(22 * 12.09, rel=0.01)
    for flight in flights:
        measured, predicted = flight.measured.energy_wh, flight.energy(vehicle)
        assert measured is not None
        assert predicted == pytest.approx(measured, rel=0.05)
    station, _, _, _ = flights_in(HERE / "other_vehicle-0.tlog", lambda _: recorded(ARDUPILOT)[0].mission)
    assert station[0].measured.hover_w == pytest.approx(flights[0].measured.hover_w, rel=0.02)
    assert station[0].measured.energy_wh == pytest.approx(flights[0].measured.energy_wh, rel=0.01)


def test_the_energy_of_a_flight_is_judged_by_the_others() -> None:
    flights = [evidence_of(path) for path in (*LOGS, LOGS[0])]
    error = energy_error(cross_validate(flights))
    assert error is not None
    assert error < 0.05
    without = [replace(flight, measured=replace(flight.measured, hover_w=None, powers=None)) for flight in flights]
    assert energy_error(cross_validate(without)) is None


def test_hover_power_is_the_mean_with_its_interval() -> None:
    power = hover_power([FlightMeasurements(hover_w=watts) for watts in (264.0, 266.0, 268.0)])
    assert power is not None
    assert (round(power.low), power.value, round(power.high)) == (263, 266.0, 269)


def test_powers_that_differ_too_much_or_are_one_tell_no_hover_power() -> None:
    assert hover_power([FlightMeasurements(hover_w=200.0)]) is None
    assert hover_power([FlightMeasurements(hover_w=200.0), FlightMeasurements(hover_w=260.0)]) is None
    assert (
        hover_power([FlightMeasurements(hover_w=200.0), FlightMeasurements(hover_w=202.0), FlightMeasurements()])
        is not None
    )


def test_missing_measurements_of_a_log_are_named() -> None:
    mission = recorded(PX4)[0].mission
    flights, _, _, _ = flights_in(HERE / "other_vehicle-0.ulg", lambda _: mission)
    assert "no current sensor" in flights[0].measured.reasons["hover_power"]
    old, _, _, _ = flights_in(HERE.parent / "logs" / "twice-ardupilot.bin")
    assert old[0].measured.reasons == {
        "drag": "it has no attitudes",
        "hover_power": "it has no battery's voltage and current",
    }


def test_a_log_of_a_firmware_before_the_model_says_so(tmp_path: Path) -> None:
    data = (HERE.parent / "logs" / "sitl-ardupilot.bin").read_bytes()
    (tmp_path / "old.bin").write_bytes(data.replace(b"ArduCopter V4.7.0", b"ArduCopter V3.7.0"))
    (tmp_path / "new.bin").write_bytes(data)
    words = "flown by ArduCopter 3.7.0-dev, which was not measured: its times may be off"
    remarks = [" ".join(flights_in(tmp_path / name)[1]) for name in ("old.bin", "new.bin")]
    assert [words in remark for remark in remarks] == [True, False]


def test_flights_without_a_time_tell_their_power_and_nothing_tells_nothing() -> None:
    flights = [replace(evidence_of(path), visits=(), seconds=np.empty(0), scatter=np.empty(0)) for path in LOGS]
    vehicle = fit(flights)
    assert vehicle.drag is not None
    assert vehicle.drag.low < 1.5 < vehicle.drag.high
    assert vehicle.hover_power is not None
    assert median_errors(cross_validate(flights)) == (0.0, 0.0)
    with refuses("log-useless"):
        fit([replace(flight, measured=FlightMeasurements()) for flight in flights])


def test_learn_writes_the_power_and_estimate_reckons_with_it(tmp_path: Path) -> None:
    vehicle, plan = tmp_path / "vehicle.toml", tmp_path / "mission.plan"
    write_mission(recorded(ARDUPILOT)[0].mission, plan)
    done = CliRunner().invoke(app, ["learn", *map(str, LOGS), "--out", str(vehicle)])
    assert done.exit_code == 0, done.output
    assert "hover_power: 26" in done.output
    assert read_vehicle(vehicle, ARDUPILOT).hover_power is not None
    ended = CliRunner().invoke(app, ["estimate", str(plan), "--vehicle", str(vehicle)])
    energy = re.search(r"energy ([\d.]+) Wh \(([\d.]+) to ([\d.]+)\)", ended.output)
    assert energy is not None
    assert float(energy[1]) == pytest.approx(7.76, rel=0.01)  # as was measured
    assert float(energy[2]) < 7.76 < float(energy[3])
    assert "energy" not in CliRunner().invoke(app, ["estimate", str(plan)]).output


def test_only_the_power_is_written_if_times_get_no_better(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    vehicle = LearnedVehicle(ARDUPILOT, drag=Learned(0.5, 0.4, 0.6), hover_power=Learned(266.0, 260.0, 272.0))
    monkeypatch.setattr("ipoa_mission.learn.fit.fit", lambda *_: vehicle)
    monkeypatch.setattr("ipoa_mission.learn.fit.fit", lambda *_: vehicle)
    out = tmp_path / "vehicle.toml"
    done = CliRunner().invoke(app, ["learn", *map(str, LOGS), "--out", str(out)])
    assert "do not improve other flights' times" in done.output
    assert (read_vehicle(out).drag, read_vehicle(out).hover_power) == (None, vehicle.hover_power)
