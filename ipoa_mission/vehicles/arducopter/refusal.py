"""ArduPilot's answer to an uploaded item, read in its source."""

import math
from collections.abc import Sequence

from ipoa_mission.autopilot.commands import Command, Frame
from ipoa_mission.autopilot.firmware_tables import POLYGON, Firmware, Refusals, Refused


def refused(firmware: Firmware, command: int, frame: int, values: Sequence[float], count: int) -> Refused | None:
    """`count`: items on the wire."""
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
    if command in firmware.sixteen_bits and not 0 <= values[0] <= 65535:
        return Refused("INVALID_PARAM1", 1, f"expected 0 to 65535, not {values[0]:g}")
    if command == Command.DO_JUMP and not 0 < int(values[0]) < count:
        return Refused("ERROR", 1, "expected the number of an item")
    return None


def refused_in_fence(firmware: Firmware, command: int, frame: int, values: Sequence[float]) -> Refused | None:
    if frame not in firmware.frames - {Frame.MISSION}:
        return Refused("UNSUPPORTED_FRAME")
    if command not in firmware.fence:
        return Refused("UNSUPPORTED")
    if command in POLYGON and values[0] > 255:
        return Refused("INVALID_PARAM1", 1, "expected 255 vertices at most")
    return None


def refused_in_rally(firmware: Firmware, command: int, frame: int, values: Sequence[float]) -> Refused | None:
    if command not in firmware.rally:
        return Refused("UNSUPPORTED")
    if wrong := _no_place(values, frame):
        return wrong
    if values[6] < -32768 or values[6] > 32767:
        return Refused("INVALID_PARAM7", 7, "expected an altitude from -32768 to 32767 m")
    return None if frame in firmware.frames - {Frame.MISSION} else Refused("UNSUPPORTED_FRAME")


def _no_place(values: Sequence[float], frame: int) -> Refused | None:
    """Frame 2 sends steps of 1e-7 degrees."""
    unit = 1e-7 if frame == Frame.MISSION else 1.0
    if not abs(values[4]) * unit <= 90.0:
        return Refused("INVALID_PARAM5_X", 5, f"expected a latitude, not {values[4]:g}")
    if not abs(values[5]) * unit <= 180.0:
        return Refused("INVALID_PARAM6_Y", 6, f"expected a longitude, not {values[5]:g}")
    return None


REFUSALS = Refusals(refused, refused_in_fence, refused_in_rally)
