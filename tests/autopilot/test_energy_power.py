import numpy as np
import pytest
from scipy.optimize import brentq

from ipoa_mission.autopilot.energy import KAPPA, PowerModel, air_density, induced_speed, power
from ipoa_mission.geometry import GRAVITY

SEA_LEVEL = np.array([1.225])
QUAD = PowerModel(mass_kg=2.4, disc_area=0.342, drag_area=0.09)
LIFTER = PowerModel(
    mass_kg=9.0, disc_area=1.2, drag_area=0.2, figure_of_merit=0.7, drive_efficiency=0.85, avionics_w=25
)
AIRFRAMES = {"quad": QUAD, "lifter": LIFTER}


def at(airframe: PowerModel, speed: float, climb: float = 0.0, density: float = 1.225) -> float:
    return float(power(airframe, np.array([speed]), np.array([climb]), np.array([density]))[0])


@pytest.mark.parametrize("airframe", AIRFRAMES.values(), ids=AIRFRAMES)
def test_hover_is_the_ideal_power_over_figure_of_merit_and_drive(airframe: PowerModel) -> None:
    ideal = (airframe.mass_kg * GRAVITY) ** 1.5 / np.sqrt(2 * 1.225 * airframe.disc_area)
    expected = ideal / airframe.figure_of_merit / airframe.drive_efficiency + airframe.avionics_w
    assert at(airframe, 0.0) == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize("speed", [0.0, 0.5, 3.0, 10.0, 25.0])
def test_induced_speed_without_tilt_is_that_of_zeng_xu_and_zhang(speed: float) -> None:
    """Eq. (12): v = v0 sqrt(sqrt(1 + V^4 / 4 v0^4) - V^2 / 2 v0^2)."""
    v0 = 5.3
    expected = v0 * np.sqrt(np.sqrt(1 + speed**4 / (4 * v0**4)) - speed**2 / (2 * v0**2))
    unit = np.ones(1)
    assert induced_speed(v0**2 * unit, 0 * unit, speed * unit, unit)[0] == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize("climb", [0.0, 1.0, 4.0, 12.0])
def test_induced_speed_in_a_climb_is_the_axial_solution(climb: float) -> None:
    """Leishman, section 2.10: v / v0 = -w / 2 v0 + sqrt((w / 2 v0)^2 + 1)."""
    v0, unit = 5.3, np.ones(1)
    expected = v0 * (-climb / (2 * v0) + np.sqrt((climb / (2 * v0)) ** 2 + 1))
    assert induced_speed(v0**2 * unit, climb * unit, 0 * unit, unit)[0] == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize("along", [0.0, 2.0, 9.0])
@pytest.mark.parametrize("across", [0.0, 0.1, 4.0, 30.0])
def test_glauerts_equation_is_solved_as_brent_solves_it(along: float, across: float) -> None:
    def residual(v: float) -> float:
        return float(v * np.hypot(across, along + v) - 28.0)

    speed = induced_speed(np.array([28.0]), np.array([along]), np.array([across]), np.array([1.0]))[0]
    assert speed == pytest.approx(brentq(residual, 0.0, 10.0, xtol=1e-13), rel=1e-9)


@pytest.mark.parametrize("airframe", AIRFRAMES.values(), ids=AIRFRAMES)
def test_power_falls_and_then_rises_with_speed(airframe: PowerModel) -> None:
    speeds = np.linspace(0, 25, 251)
    drawn = power(airframe, speeds, np.zeros(251), np.full(251, 1.225))
    cheapest = int(np.argmin(drawn))
    assert 3 < speeds[cheapest] < 15
    assert (np.diff(drawn[: cheapest + 1]) < 0).all()
    assert (np.diff(drawn[cheapest:]) > 0).all()
    assert drawn[cheapest] < 0.95 * drawn[0]


def test_drag_costs_most_power_at_high_speed() -> None:
    """Doubling a high speed takes nearly eight times the power above that of the blades and the avionics."""
    bare = PowerModel(mass_kg=0.2, disc_area=0.342, drag_area=0.09, figure_of_merit=1 / KAPPA, avionics_w=0.0)
    assert at(bare, 40.0) / at(bare, 20.0) == pytest.approx(8, rel=0.05)


def test_a_climb_costs_its_work_less_the_induced_power_it_saves() -> None:
    work = QUAD.mass_kg * GRAVITY * 3.0 / QUAD.drive_efficiency
    assert 0.5 * work < at(QUAD, 0.0, 3.0) - at(QUAD, 0.0) < work


def test_a_descent_gives_nothing_back() -> None:
    assert at(QUAD, 5.0, -2.0) == at(QUAD, 5.0)


def test_thin_air_takes_more_power_to_hover_in() -> None:
    thin = float(air_density(np.array([2000.0]))[0])
    less = (at(QUAD, 0, density=thin) - QUAD.avionics_w) / (at(QUAD, 0) - QUAD.avionics_w)
    assert less == pytest.approx(np.sqrt(1.225 / thin), rel=1e-12)


@pytest.mark.parametrize(("altitude", "density"), [(0, 1.2250), (1000, 1.11164), (2000, 1.00649), (5000, 0.736116)])
def test_the_air_is_the_standard_atmospheres(altitude: float, density: float) -> None:
    """U.S. Standard Atmosphere 1976, by geopotential altitude, kg/m^3."""
    assert float(air_density(np.array([altitude]))[0]) == pytest.approx(density, abs=2e-5)
