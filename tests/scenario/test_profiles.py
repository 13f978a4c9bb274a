from pathlib import Path

import numpy as np
import pytest

from ipoa_mission.autopilot.autopilot import Autopilot
from ipoa_mission.autopilot.energy import NotEnoughBattery, power, shortage
from ipoa_mission.autopilot.learned import Learned, LearnedVehicle
from ipoa_mission.errors import BadInput
from ipoa_mission.forecast.flight_energy import battery_of, flight_energy
from ipoa_mission.forecast.timing.track import Track
from ipoa_mission.scenario import Scenario, parse_scenario
from ipoa_mission.scenario.model import PROFILES
from tests.refused import refuses

FLIGHT = """
home = { latitude_deg = 47.0, longitude_deg = 8.0 }
start = { east = 0, north = 0, up = 10 }
goal = { east = 100, north = 0, up = 10 }
"""


def read(text: str) -> Scenario:
    return parse_scenario(FLIGHT + text, Path("here.toml"))


def test_the_schema_names_the_profiles_that_there_are() -> None:
    choices = Scenario.model_json_schema()["properties"]["profile"]["anyOf"][0]["enum"]
    assert choices == list(PROFILES)


@pytest.mark.parametrize("name", PROFILES)
def test_a_profile_sets_only_what_it_says(name: str) -> None:
    plain, profiled = read("").model_dump(), read(f"profile = '{name}'").model_dump()
    assert profiled.pop("profile") == name
    for key, value in PROFILES[name].items():
        expected = plain[key] | dict(value) if isinstance(value, dict) else value
        assert profiled[key] == expected != plain[key]
    rest = [key for key in profiled if key not in PROFILES[name]]
    assert {key: profiled[key] for key in rest} == {key: plain[key] for key in rest}


@pytest.mark.parametrize("name", PROFILES)
def test_values_of_the_file_go_before_the_profile(name: str) -> None:
    scenario = read(f"profile = '{name}'\nsafety_distance = 0.5\ncost = {{ omega = [0.2, 0.3, 0.5] }}")
    assert scenario.safety_distance == 0.5
    assert scenario.cost.omega == (0.2, 0.3, 0.5)
    d_safe = PROFILES[name]["cost"].get("d_safe", 5.0)
    assert scenario.cost.d_safe == d_safe


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("profile = 'racing'", "profile: expected 'delivery', 'rescue' or 'endurance', not 'racing'"),
        ("profile = 3", "profile: expected 'delivery', 'rescue' or 'endurance', not 3"),
        ("profile = 'rescue'\ncost = 3", "cost: expected a table, not 3"),
        ("profile = 'rescue'\ncost = { d_saf = 3 }", "cost.d_saf: unknown key; did you mean d_safe?"),
        ("vehicle = { battery = { capacity_wh = 90 } }", "vehicle: expected an airframe with the battery"),
        (
            "vehicle = { airframe = { mass_kg = 2, rotor_diameter = 0.3, figure_of_merit = 0.95 } }",
            "vehicle.airframe.figure_of_merit: expected a number of at most 0.869565, not 0.95",
        ),
    ],
)
def test_mistakes_are_named(line: str, words: str) -> None:
    with pytest.raises(BadInput) as caught:
        read(line)
    assert str(caught.value) == f"here.toml: {words}"


@pytest.mark.parametrize("name", PROFILES)
def test_the_document_says_what_a_profile_sets(name: str) -> None:
    text = (Path(__file__).parents[2] / "docs" / "lab" / "profiles.md").read_text(encoding="utf-8")
    (row,) = [line for line in text.splitlines() if line.startswith(f"| `{name}` | ")]
    for key, value in PROFILES[name].items():
        settings = {f"{key}.{k}": v for k, v in value.items()} if isinstance(value, dict) else {key: value}
        for place, wanted in settings.items():
            shown = str(list(wanted)) if isinstance(wanted, tuple) else f"{wanted:g}"
            assert f"`{place} = {shown}`" in row


AIRFRAME = "mass_kg = 2.4, rotors = 6, rotor_diameter = 0.3"
MINUTE = Track(np.array([0.0, 60.0]), np.zeros((2, 3)), np.zeros(2))


def test_energy_needs_an_airframe() -> None:
    assert flight_energy(read(""), MINUTE) is None


def test_the_airframe_of_the_file_is_the_one_that_flies() -> None:
    scenario = read(f"vehicle = {{ airframe = {{ {AIRFRAME} }} }}")
    assert scenario.vehicle.airframe is not None
    airframe = scenario.vehicle.airframe.build()
    assert airframe.disc_area == pytest.approx(6 * np.pi * 0.15**2)
    assert airframe.drag_area == pytest.approx(0.05 * 2.4 ** (2 / 3))
    used = flight_energy(scenario, MINUTE)
    assert used is not None
    assert used.energy_wh * 60 == pytest.approx(
        float(power(airframe, np.zeros(1), np.zeros(1), np.array([1.225]))[0]), rel=1e-6
    )


def test_a_hover_power_that_was_learned_sets_the_level() -> None:
    learned = LearnedVehicle(Autopilot.PX4, hover_power=Learned(360.0, 350.0, 370.0))
    scenario = read(f"vehicle = {{ airframe = {{ {AIRFRAME} }} }}")
    flown_by = scenario.model_copy(update={"vehicle": scenario.vehicle.learned_as(learned)})
    used = flight_energy(flown_by, MINUTE)
    assert used is not None
    assert used.energy_wh == pytest.approx(6.0)
    fast = Track(MINUTE.times, np.array([[0.0, 0, 0], [600.0, 0, 0]]), np.full(2, 10.0))
    plain, scaled = flight_energy(scenario, fast), flight_energy(flown_by, fast)
    hovers = flight_energy(scenario, MINUTE)
    assert plain is not None
    assert scaled is not None
    assert hovers is not None
    assert scaled.energy_wh / used.energy_wh == pytest.approx(plain.energy_wh / hovers.energy_wh)
    alone = flight_energy(None, fast, learned)
    assert alone is not None
    assert alone.energy_wh == pytest.approx(6.0)


@pytest.mark.parametrize(
    ("battery", "gives"),
    [
        ("capacity_wh = 100.0", 100.0),
        ("capacity_mah = 5000.0, voltage = 22.2", 111.0),
        ("capacity_wh = 100.0, health = 0.8", 80.0),
        ("capacity_wh = 100.0, temperature = -18.0", 50.0),
        ("capacity_wh = 100.0, temperature = 4.5", 75.0),
        ("capacity_wh = 100.0, temperature = 35.0", 100.0),
        ("capacity_mah = 5000.0, voltage = 22.2, health = 0.9, temperature = 27.0", 99.9),
    ],
)
def test_a_battery_gives_what_its_age_and_its_temperature_leave(battery: str, gives: float) -> None:
    section = read(f"vehicle = {{ airframe = {{ {AIRFRAME} }}, battery = {{ {battery} }} }}").vehicle.battery
    assert section is not None
    assert section.build().capacity_wh == pytest.approx(gives)


@pytest.mark.parametrize(
    "battery",
    ["reserve = 0.2", "capacity_mah = 5000.0", "capacity_wh = 9.0, voltage = 22.2", "voltage = 22.2",
     "capacity_wh = 90.0, capacity_mah = 5000.0, voltage = 22.2"],
)  # fmt: skip
def test_a_battery_has_one_capacity(battery: str) -> None:
    with refuses("bad-input", "here.toml: vehicle.battery", "capacity_wh", "capacity_mah"):
        read(f"vehicle = {{ airframe = {{ {AIRFRAME} }}, battery = {{ {battery} }} }}")


@pytest.mark.parametrize(
    ("wrong", "place"),
    [
        ("airframe = { mass_kg = 0.0, rotor_diameter = 0.3 }", "airframe.mass_kg"),
        ("airframe = { mass_kg = 2.0, rotor_diameter = -1.0 }", "airframe.rotor_diameter"),
        (f"airframe = {{ {AIRFRAME}, figure_of_merit = 0.95 }}", "airframe.figure_of_merit"),
        (f"airframe = {{ {AIRFRAME}, drive_efficiency = 1.2 }}", "airframe.drive_efficiency"),
        ("battery = { capacity_wh = 0.0 }", "battery.capacity_wh"),
        ("battery = { capacity_wh = 100.0, reserve = 1.0 }", "battery.reserve"),
        ("battery = { capacity_wh = 100.0, reserve = -0.1 }", "battery.reserve"),
    ],
)
def test_an_impossible_airframe_or_battery_is_refused(wrong: str, place: str) -> None:
    with refuses("bad-input", f"here.toml: vehicle.{place}"):
        read(f"vehicle = {{ {wrong} }}")


def test_a_flight_beyond_the_battery_is_refused_and_wind_counts() -> None:
    enough = f"vehicle = {{ airframe = {{ {AIRFRAME} }}, battery = {{ capacity_wh = 6.5, reserve = 0.2 }} }}"
    windy = enough.replace("reserve", "head_wind = 22, reserve")

    def short(text: str) -> NotEnoughBattery | None:
        used, battery = flight_energy(read(text), MINUTE), battery_of(read(text))
        assert used is not None
        assert battery is not None
        return shortage(used.between, battery)

    assert short(enough) is None
    assert "battery: expected a reserve of 20% after landing" in str(short(windy))
