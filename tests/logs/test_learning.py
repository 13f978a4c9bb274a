"""Learn half of the flights of other vehicles, judge the rest.

`other_vehicle_*.json`: missions, parameters, times of items. ArduCopter 4.7.0-dev flew with a drag that holds 11 m/s at
a tilt of 45 degrees (default 15.08); PX4 1.17.0-beta1 flew SIH with SIH_KDV 1.6 (1) and SIH_T_TAU 0.12 s (0.05).
"""

import json
import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from ipoa_mission.autopilot.autopilot import Autopilot
from ipoa_mission.autopilot.learned import Learned, LearnedVehicle, read_vehicle, write_vehicle
from ipoa_mission.errors import BadInput
from ipoa_mission.forecast.forecast import estimate
from ipoa_mission.geodesy import Geodetic, LocalFrame
from ipoa_mission.learn.fit import Evidence, cross_validate, errors, evidence_between, fit, median_errors, timed
from ipoa_mission.mission.items import Item, Mission, land, takeoff, waypoint
from ipoa_mission.simulator.fly import fly_built_in
from tests.examples import vehicles
from tests.recorded_flights import FLOWN_ON
from tests.refused import refuses

HERE = Path(__file__).parent
HOME = Geodetic(47.397742, 8.545594, 488.0)
ARDUPILOT, PX4 = Autopilot.ARDUPILOT, Autopilot.PX4


def recorded(autopilot: Autopilot) -> list[Evidence]:
    rows = json.loads((HERE / f"other_vehicle_{autopilot}.json").read_text())
    return [_flight(f"flight {n}", row, autopilot) for n, row in enumerate(rows)]


def _four(params: list[float | None]) -> tuple[float, float, float, float]:
    one, two, three, four = (math.nan if value is None else value for value in params)
    return one, two, three, four


def _flight(name: str, row: dict[str, Any], autopilot: Autopilot) -> Evidence:
    items = tuple(Item(command, frame, _four(params), *place) for command, frame, params, *place in row["items"])
    flown_on = FLOWN_ON[autopilot]
    mission = Mission(Geodetic(*row["home"]), items, autopilot, parameters=row["parameters"], firmware_version=flown_on)
    return evidence_between(name, mission, {int(index): at for index, at in row["done_s"].items()})


@pytest.mark.parametrize(
    ("autopilot", "drag", "before", "after"),
    [(ARDUPILOT, (1.40, 1.53), 0.05, 0.01), pytest.param(PX4, (1.5, 1.66), 0.10, 0.04, marks=pytest.mark.long)],
)
def test_half_of_a_vehicles_flights_predict_the_times_of_the_others(
    autopilot: Autopilot, drag: tuple[float, float], before: float, after: float
) -> None:
    flights = recorded(autopilot)
    vehicle = fit(flights[::2])
    assert vehicle.drag is not None
    assert drag[0] < vehicle.drag.low < vehicle.drag.value < vehicle.drag.high < drag[1]
    errors = median_errors(timed(flights[1::2], vehicle))
    assert errors[0] > before
    assert errors[1] < after


def test_each_flight_is_judged_by_the_others() -> None:
    flights = recorded(ARDUPILOT)[:4]
    judged = cross_validate(flights)
    assert [row.name for row in judged] == [flight.name for flight in flights]
    assert median_errors(judged)[1] < 0.01 < median_errors(judged)[0]
    with refuses("log-useless"):
        cross_validate(flights[:1])


def test_slow_flights_do_not_tell_the_drag() -> None:
    slow = recorded(ARDUPILOT)[0]  # at 6 m/s
    with refuses("log-useless") as refused:
        fit([slow, slow])
    assert refused.value.hint is not None
    assert "fly faster" in refused.value.hint


def test_a_forecast_of_the_vehicle_that_flew_is_right_in_every_item() -> None:
    vehicle = LearnedVehicle(ARDUPILOT, drag=Learned(1.3, 1.2, 1.4), landing_delay=Learned(3.0, 2.0, 4.0))
    asked = [replace(flight, seconds=flight.forecast(vehicle)) for flight in recorded(ARDUPILOT)[:6:2]]
    assert np.abs(errors(asked, vehicle)).max() < 1e-9
    learned = fit(asked)
    assert learned.drag is not None
    assert learned.landing_delay is not None
    assert learned.drag.value == pytest.approx(1.3, abs=0.02)
    assert learned.landing_delay.value == pytest.approx(3.0, abs=0.1)


@pytest.mark.parametrize("autopilot", vehicles(Autopilot.ARDUPILOT))
def test_the_built_in_autopilot_flies_the_learned_vehicle(autopilot: Autopilot) -> None:
    there = LocalFrame(HOME).geodetic(np.array([0.0, 250.0, 0.0]))
    fast = {"WPNAV_SPEED": 1500.0} if autopilot is ARDUPILOT else {"MPC_XY_CRUISE": 12.0}
    same = Mission(HOME, (takeoff(HOME, 15.0), waypoint(there, 15.0), land(there)), autopilot, parameters=fast)
    vehicle = LearnedVehicle(autopilot, drag=Learned(1.8, 1.7, 1.9), landing_delay=Learned(4.0, 3.0, 5.0))
    learned = replace(same, vehicle=vehicle)
    flown, predicted = fly_built_in(learned), estimate(learned)
    assert flown.total_s == pytest.approx(predicted.total_s, rel=0.05)
    assert flown.total_s > fly_built_in(same).total_s + 10.0


def test_vehicle_file_names_its_quantities() -> None:
    text = write_vehicle(LearnedVehicle(PX4, drag=Learned(1.6, 1.5, 1.7), flights=4))
    assert text.splitlines() == [
        'autopilot = "px4"',
        "flights = 4",
        "",
        "[drag]  # times that of the simulated vehicle",
        "value = 1.6",
        "low = 1.5",
        "high = 1.7",
    ]


def test_a_vehicle_file_is_read_as_it_was_written(tmp_path: Path) -> None:
    vehicle = LearnedVehicle(
        ARDUPILOT,
        drag=Learned(1.5, 1.25, 1.75),
        lift_delay=Learned(-0.5, -1.0, 0.5),
        hover_power=Learned(266.0, 260.0, 272.0),
        version="4.5.7",
        flights=11,
    )
    path = tmp_path / "vehicle.toml"
    path.write_text(write_vehicle(vehicle))
    assert read_vehicle(path) == vehicle
    with refuses("other-autopilot", "vehicle.toml", "px4", kind=BadInput):
        read_vehicle(path, PX4)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", 'autopilot: expected "ardupilot" or "px4", not None'),
        ("autopilot = 'px4'\nmass = 3", "mass: expected one of airspeed, autopilot, climb_power"),
        ("autopilot = 'px4'\ndrag = 3", "drag: expected value, low, high"),
        ("autopilot = 'px4'\n[drag]\nvalue = 0\nlow = 0\nhigh = 1", "drag.value: expected a number up to 50, not 0"),
        (
            f"autopilot = 'px4'\n[drag]\nvalue = 1{'0' * 400}\nlow = 0\nhigh = 1",
            "drag.value: expected a number up to 50, not 1000",
        ),
        (
            "autopilot = 'px4'\n[drag]\nvalue = nan\nlow = 0\nhigh = 1",
            "drag.value: expected a number up to 50, not nan",
        ),
        ("autopilot = 'px4'\n[drag]\nvalue = 2\nlow = 3\nhigh = 4", "drag: expected low, value and high in this order"),
        (f"autopilot = 'px4'\n[drag]\nvalue = {'9' * 6000}\nlow = 3\nhigh = 4", ""),
        ("autopilot = 'px4'\nflights = 'many'", "flights: expected int, not many"),
        ("#" * 100_001, "expected a vehicle.toml of at most"),
        ("a = " + "[" * 50_000, "expected TOML"),
    ],
)
def test_a_wrong_vehicle_file_is_an_error_with_the_place(text: str, words: str, tmp_path: Path) -> None:
    path = tmp_path / "vehicle.toml"
    path.write_text(text)
    with pytest.raises(BadInput) as refused:
        read_vehicle(path)
    assert str(refused.value).startswith(f"{path}: ")
    assert words in str(refused.value)
    assert len(str(refused.value)) < 400 + len(str(path))
