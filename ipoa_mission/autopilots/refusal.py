"""What a firmware says to one item of a list that is uploaded to it, read in its source: taken, or why not.

An item is its command, frame, and seven values: param1 to param4, latitude, longitude (degrees; for a frame without a
place what x and y hold), altitude.
"""

import math
from collections.abc import Container, Sequence
from dataclasses import dataclass

from ipoa_mission.autopilots.firmware import Firmware
from ipoa_mission.autopilots.vehicle import Autopilot
from ipoa_mission.commands import Command, Frame

DEG_E7 = 1e-7
INT16_MIN, INT16_MAX = -(2**15), 2**15 - 1
MOST_VERTICES = 255  # of a polygon, which ArduPilot counts in eight bits
LEAST_VERTICES = 3
ROI = frozenset({Command.NAV_ROI, Command.DO_SET_ROI})
POLYGON = frozenset({Command.NAV_FENCE_POLYGON_VERTEX_INCLUSION, Command.NAV_FENCE_POLYGON_VERTEX_EXCLUSION})
_PARAMS = ("param1", "param2", "param3", "param4", "latitude", "longitude", "altitude")
_PLACES = {5: "INVALID_PARAM5_X", 6: "INVALID_PARAM6_Y"}


@dataclass(frozen=True)
class Refused:
    """`result`: the name of the MAV_MISSION_RESULT; `param`: which of the seven it is for, or 0; `words`: why."""

    result: str
    param: int = 0
    words: str = ""


def refused(firmware: Firmware, command: int, frame: int, values: Sequence[float], count: int) -> Refused | None:
    """Why a mission of `count` items on the wire with this item is refused; None where the firmware takes it."""
    if firmware.autopilot is Autopilot.PX4:
        return _by_px4(firmware, command, frame, values)
    return _by_ardupilot(firmware, command, frame, values, count)


def refused_in_fence(firmware: Firmware, command: int, frame: int, values: Sequence[float]) -> Refused | None:
    """The same for an item of a fence."""
    if firmware.autopilot is Autopilot.PX4:
        if command in POLYGON and not values[0] + 0.5 >= LEAST_VERTICES:
            return Refused("ERROR", 1, f"expected {LEAST_VERTICES} vertices or more")
        return _of_a_px4_list(firmware, firmware.fence, command, frame, values)
    if frame not in firmware.frames - {Frame.MISSION}:
        return Refused("UNSUPPORTED_FRAME")
    if command not in firmware.fence:
        return Refused("UNSUPPORTED")
    if command in POLYGON and values[0] > MOST_VERTICES:
        return Refused("INVALID_PARAM1", 1, f"expected {MOST_VERTICES} vertices at most")
    return None


def refused_in_rally(firmware: Firmware, command: int, frame: int, values: Sequence[float]) -> Refused | None:
    """The same for a rally point."""
    if firmware.autopilot is Autopilot.PX4:
        return _of_a_px4_list(firmware, firmware.rally, command, frame, values)
    if command not in firmware.rally:
        return Refused("UNSUPPORTED")
    if wrong := _no_place(values, frame):
        return wrong
    if values[6] < INT16_MIN or values[6] > INT16_MAX:
        return Refused("INVALID_PARAM7", 7, "expected an altitude in sixteen bits")
    return None if frame in firmware.frames - {Frame.MISSION} else Refused("UNSUPPORTED_FRAME")


def _by_ardupilot(firmware: Firmware, command: int, frame: int, values: Sequence[float], count: int) -> Refused | None:
    may_be_nan = (firmware.takes_nan or {}).get(command, frozenset())
    for n, value in enumerate(values[:4], start=1):
        if math.isinf(value) or (math.isnan(value) and n not in may_be_nan):
            return Refused(f"INVALID_PARAM{n}", n, f"expected a number, not {value:g}")
    if command in (0, 1):
        return Refused("INVALID")
    if not firmware.takes(command):
        return Refused("UNSUPPORTED")
    if command in firmware.placed:
        if wrong := _no_place(values, frame):
            return wrong
        if not abs(values[6]) < firmware.highest_altitude:
            return Refused("INVALID_PARAM7", 7, f"expected an altitude within {firmware.highest_altitude:g} m")
        if frame not in firmware.frames:
            return Refused("UNSUPPORTED_FRAME")
    if command == Command.DO_JUMP and not 0 < int(values[0]) < count:
        return Refused("ERROR", 1, "expected the number of an item")
    return None


def _no_place(values: Sequence[float], frame: int) -> Refused | None:
    """What is no latitude or longitude; in frame 2 it goes over the wire as it is, and is read in steps of 1e-7."""
    unit = DEG_E7 if frame == Frame.MISSION else 1.0
    if not abs(values[4]) * unit <= 90.0:
        return Refused("INVALID_PARAM5_X", 5, f"expected a latitude, not {values[4]:g}")
    if not abs(values[5]) * unit <= 180.0:
        return Refused("INVALID_PARAM6_Y", 6, f"expected a longitude, not {values[5]:g}")
    return None


def _by_px4(firmware: Firmware, command: int, frame: int, values: Sequence[float]) -> Refused | None:
    if frame not in firmware.frames:
        return Refused("UNSUPPORTED_FRAME")
    if wrong := _unused(firmware, command, frame, values):
        return wrong
    where, table = ("plain", firmware.plain) if frame == Frame.MISSION else ("placed", firmware.placed)
    if command in table:
        modes = firmware.roi_modes[where]
        if command in ROI and not (math.isfinite(values[0]) and int(values[0]) in modes):
            return Refused("INVALID_PARAM1", 1, f"expected a mode of {_listed(modes)}, not {values[0]:g}")
        return None
    if command in firmware.fence or command in firmware.rally:
        return Refused("ERROR" if frame != Frame.MISSION else "UNSUPPORTED")
    return Refused("UNSUPPORTED")


def _of_a_px4_list(
    firmware: Firmware, commands: Container[int], command: int, frame: int, values: Sequence[float]
) -> Refused | None:
    """PX4 reads the items of all lists by the same code."""
    if frame not in firmware.frames:
        return Refused("UNSUPPORTED_FRAME")
    if wrong := _unused(firmware, command, frame, values):
        return wrong
    if frame == Frame.MISSION:
        return Refused("UNSUPPORTED")
    return None if command in commands else Refused("ERROR")


def _unused(firmware: Firmware, command: int, frame: int, values: Sequence[float]) -> Refused | None:
    """The first param that the firmware does not use, and that is neither 0 nor NaN.

    In a frame with a place an unused latitude or longitude must be NaN: 0 is a place.
    """
    used = None if firmware.used is None else firmware.used.get(command)
    if used is None:
        return None
    for n, value in enumerate(values, start=1):
        is_integer = n in _PLACES and frame != Frame.MISSION
        if n not in used and not (math.isnan(value) or (value == 0.0 and not is_integer)):
            expected = "NaN" if is_integer else "0 or NaN"
            words = f"expected {expected}, as {firmware} uses no such param here, not {value:g}"
            return Refused(_PLACES.get(n, f"INVALID_PARAM{n}"), n, words)
    return None


def param_name(n: int) -> str:
    """What one of the seven is called in a mission.

    >>> param_name(5)
    'latitude'
    """
    return _PARAMS[n - 1]


def _listed(numbers: frozenset[int]) -> str:
    return " or ".join(map(str, sorted(numbers)))
