"""Parameters by which ground stations see how a vehicle was set up: sensors, radio, modes, battery, failsafes.

Names, types and values are those of ArduCopter 4.7 and PX4 1.17 in their simulators. Nothing here moves a mission.
"""

from collections.abc import Mapping

from ipoa_mission.autopilots.vehicle import Autopilot

INT8, INT16, INT32, REAL32 = 2, 4, 6, 9  # MAV_PARAM_TYPE
Declared = tuple[float, int]  # a value and its type

_STICKS = ("ROLL", "PITCH", "THROTTLE", "YAW")
_SWITCHES = ("FLTMODE", *(f"{one}_SW" for one in ("RETURN", "LOITER", "OFFB", "KILL", "ARM", "GEAR", "TRANS")))
_KNOBS = ("FLAPS", *(f"{one}{n}" for one in ("AUX", "PARAM") for n in (1, 2, 3)))
_DEAD_ZONES = (20.0, 20.0, 30.0, 20.0, 0.0, 0.0, 0.0, 0.0)


def _channel(number: int, dead_zone: float) -> dict[str, Declared]:
    """A radio channel of ArduCopter."""
    values = {"MIN": 1000.0, "TRIM": 1500.0, "MAX": 2000.0, "DZ": dead_zone}
    told = {f"RC{number}_{name}": (value, INT16) for name, value in values.items()}
    return {**told, f"RC{number}_REVERSED": (0.0, INT8)}


_ARDUCOPTER: Mapping[str, Declared] = {
    **{f"RCMAP_{stick}": (float(channel), INT8) for channel, stick in enumerate(_STICKS, start=1)},
    **{name: it for n, zone in enumerate(_DEAD_ZONES, start=1) for name, it in _channel(n, zone).items()},
    **{f"FLTMODE{n}": (mode, INT8) for n, mode in enumerate((7.0, 9.0, 6.0, 3.0, 5.0, 0.0), start=1)},
    "FLTMODE_CH": (5.0, INT8),
    "FRAME_TYPE": (0.0, INT8),
    "COMPASS_DEV_ID": (97539.0, INT32),
    "COMPASS_DEV_ID2": (131874.0, INT32),
    "COMPASS_DEV_ID3": (263178.0, INT32),
    "BATT_MONITOR": (4.0, INT8),
    "BATT_CAPACITY": (3300.0, INT32),
    "BATT_ARM_VOLT": (0.0, REAL32),
    "BATT_LOW_VOLT": (10.5, REAL32),
    "BATT_LOW_MAH": (0.0, REAL32),
    "BATT_FS_LOW_ACT": (0.0, INT8),
    "BATT_FS_CRT_ACT": (0.0, INT8),
    "FS_THR_ENABLE": (1.0, INT8),
    "FS_THR_VALUE": (975.0, INT16),
    "FS_GCS_ENABLE": (0.0, INT8),
}
_PX4: Mapping[str, Declared] = {
    "CAL_GYRO0_ID": (1_310_988.0, INT32),
    "CAL_ACC0_ID": (1_310_988.0, INT32),
    "CAL_MAG0_ID": (197_388.0, INT32),
    "CAL_MAG1_ID": (197_644.0, INT32),
    "CAL_MAG2_ID": (0.0, INT32),
    "SYS_AUTOCONFIG": (0.0, INT32),
    **{f"RC_MAP_{name}": (0.0, INT32) for name in (*_STICKS, *_SWITCHES, *_KNOBS)},
    **{f"COM_FLTMODE{n}": (-1.0, INT32) for n in range(1, 7)},
    "BAT1_N_CELLS": (4.0, INT32),
    "BAT1_V_EMPTY": (3.6, REAL32),
    "BAT1_V_CHARGED": (4.05, REAL32),
    "COM_RC_LOSS_T": (0.5, REAL32),
    "COM_LOW_BAT_ACT": (3.0, INT32),
    "NAV_RCL_ACT": (2.0, INT32),
}
SET_UP: Mapping[Autopilot, Mapping[str, Declared]] = {Autopilot.ARDUPILOT: _ARDUCOPTER, Autopilot.PX4: _PX4}
