from types import SimpleNamespace
from typing import Any

import pytest

from ipoa_mission.autopilot.autopilot import Autopilot
from ipoa_mission.autopilot.failsafe import FailsafeProfile
from ipoa_mission.autopilot.parameters import Parameters
from ipoa_mission.flight.preflight import without_station

ARDUPILOT, PX4 = Autopilot.ARDUPILOT, Autopilot.PX4


def words(autopilot: Autopilot, values: Parameters) -> str:
    def parameters(wanted: Any) -> Parameters:
        names = {name for entry in wanted for name in ((entry,) if isinstance(entry, str) else entry)}
        assert values.keys() <= names
        return values

    vehicle: Any = SimpleNamespace(autopilot=autopilot, parameters=parameters)
    return without_station(vehicle)


@pytest.mark.parametrize(
    ("autopilot", "values", "expected"),
    [
        (ARDUPILOT, {"FS_GCS_ENABLE": 0}, "without its ground station the vehicle continues (FS_GCS_ENABLE 0)"),
        (ARDUPILOT, {"FS_GCS_ENABLE": 1}, "5 s without its ground station lead to rtl or land (FS_GCS_ENABLE 1)"),
        (
            ARDUPILOT,
            {"FS_GCS_ENABLE": 1, "FS_OPTIONS": 2},
            "without its ground station the vehicle continues (FS_GCS_ENABLE 1, by FS_OPTIONS)",
        ),
        (
            ARDUPILOT,
            {"FS_GCS_ENABLE": 5, "FS_GCS_TIMEOUT": 30, "SYSID_MYGCS": 245},
            "30 s without its ground station lead to land (FS_GCS_ENABLE 5)",
        ),
        (
            ARDUPILOT,
            {"FS_GCS_ENABLE": 1, "MAV_GCS_SYSID": 255, "MAV_GCS_SYSID_HI": 0},
            "FS_GCS_ENABLE 1 counts for station 255, not for this one (245)",
        ),
        (
            ARDUPILOT,
            {"FS_GCS_ENABLE": 1, "MAV_GCS_SYSID": 240, "MAV_GCS_SYSID_HI": 250},
            "5 s without its ground station lead to rtl or land (FS_GCS_ENABLE 1)",
        ),
        (PX4, {"NAV_DLL_ACT": 0}, "without its ground station the vehicle continues (NAV_DLL_ACT 0)"),
        (
            PX4,
            {"NAV_DLL_ACT": 2, "COM_DL_LOSS_T": 20},
            "20 s without its ground station lead to rtl or land or terminate (NAV_DLL_ACT 2)",
        ),
        (PX4, {"COM_DL_LOSS_T": 20}, ""),
    ],
)
def test_station_loss_is_told_by_the_vehicle_s_parameters(
    autopilot: Autopilot, values: Parameters, expected: str
) -> None:
    assert words(autopilot, values) == expected


def test_unknown_action_is_not_told() -> None:
    unknown: Any = SimpleNamespace(failsafe_profile=FailsafeProfile())
    assert words(unknown, {}) == ""
    unknown = SimpleNamespace(failsafe_profile=PX4.failsafe_profile, failsafes=lambda values, version: ())
    assert words(unknown, {"NAV_DLL_ACT": 2}) == ""
