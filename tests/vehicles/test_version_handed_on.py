import math
from dataclasses import replace
from pathlib import Path

import pytest

from ipoa_mission.autopilot.autopilot import Autopilot
from ipoa_mission.autopilot.parameters import INT32
from ipoa_mission.autopilot.version import Version
from ipoa_mission.cli.mocking import MockOptions, built_in_autopilot
from ipoa_mission.forecast.forecast import Forecast
from ipoa_mission.geodesy import Geodetic
from ipoa_mission.mission.mission_io import read_mission
from ipoa_mission.simulator.built_in_autopilot import ParameterServer
from ipoa_mission.simulator.simulated_flight import SimulatedFlight
from ipoa_mission.simulator.situation import Conditions
from ipoa_mission.vehicles.px4_multicopter.limits import px4_limits

MISSIONS = Path(__file__).parents[2] / "missions"
PX4 = Autopilot.PX4
BOTH = pytest.mark.parametrize(("version", "radius"), [(Version(1, 17), 2.0), (Version(1, 18), 10.0)])


@BOTH
def test_the_acceptance_radius_is_that_of_the_version(version: Version, radius: float) -> None:
    """NAV_ACC_RAD of multicopters: 2 m by rc.mc_defaults of 1.17.0, 10 m since c05cc47b75."""
    mission = replace(read_mission(MISSIONS / "sitl.plan"), firmware_version=version)
    home = Geodetic(47.4, 8.5, 400.0)
    aboard = SimulatedFlight(PX4, home, {}, Conditions(version=version))
    assert PX4.complete({}, version)["NAV_ACC_RAD"] == radius
    assert px4_limits({}, version).radius == radius
    assert Forecast(mission).itinerary.parameters.get("NAV_ACC_RAD", 2.0) == radius
    assert aboard.parameters["NAV_ACC_RAD"] == radius
    assert ParameterServer(PX4, {}, version).values["NAV_ACC_RAD"] == radius


def test_px4s_type_of_return_is_an_integer() -> None:
    assert PX4.parameter_table.by_name["RTL_TYPE"].kind == INT32  # as rtl_params.c defines it


@pytest.mark.parametrize(("version", "up"), [(Version(1, 17), 0.0), (Version(1, 18), 9.0)])
def test_a_rally_point_at_home_counts_by_the_version(version: Version, up: float) -> None:
    """RTL_TYPE 5 leads to rally points since 1.18; before, it is as 0, and one within 10 m of home is none."""
    plain = read_mission(MISSIONS / "sitl.plan")
    home = plain.home
    rally = (Geodetic(home.latitude_deg, home.longitude_deg, 9.0),)
    mission = replace(plain, rally=rally, parameters={"RTL_TYPE": 5.0}, firmware_version=version)
    assert Forecast(mission).itinerary.goal_of_return((100.0, 0.0, 20.0))[2] == up


def test_the_built_in_autopilot_of_a_scenario_is_of_its_version(tmp_path: Path) -> None:
    text = (MISSIONS / "sitl.toml").read_text(encoding="utf-8")
    path = tmp_path / "sitl.toml"
    path.write_text(text.replace("[vehicle]\n", '[vehicle]\nfirmware_version = "1.17"\n'), encoding="utf-8")
    assert built_in_autopilot(MockOptions(scenario=path), {}).flight.conditions.version == Version(1, 17)
    other = MockOptions(Autopilot.ARDUPILOT, path)
    assert built_in_autopilot(other, {}).flight.conditions.version is None


def test_px4_1_18_ignores_parameters_that_it_no_longer_has() -> None:
    """LNDMC_TRIG_TIME (1 s since 62f5f5267e) and MPC_USE_HTE (always since 0d66981dcc) of release/1.18."""
    removed = {"LNDMC_TRIG_TIME": 3.0, "MPC_USE_HTE": 0.0}
    new = px4_limits(removed, Version(1, 18))
    assert new == px4_limits({}, Version(1, 18))
    old = px4_limits(removed, Version(1, 17))
    assert (old.land_detector_s, old.hover_learning) == (3.0, math.inf)
