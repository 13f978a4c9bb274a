"""PX4's answer to an uploaded item, read in its source."""

import math
from collections.abc import Container, Sequence

from ipoa_mission.autopilot.commands import Command, Frame
from ipoa_mission.autopilot.firmware_tables import POLYGON, Firmware, Refusals, Refused


def refused(firmware: Firmware, command: int, frame: int, values: Sequence[float], _count: int) -> Refused | None:
    if frame not in firmware.frames:
        return Refused("UNSUPPORTED_FRAME")
    if wrong := _unused(firmware, command, frame, values):
        return wrong
    where, table = ("plain", firmware.plain) if frame == Frame.MISSION else ("placed", firmware.placed)
    if command in table:
        modes, is_roi = firmware.roi_modes[where], command in {Command.NAV_ROI, Command.DO_SET_ROI}
        if is_roi and not (math.isfinite(values[0]) and int(values[0]) in modes):
            listed = " or ".join(map(str, sorted(modes)))
            return Refused("INVALID_PARAM1", 1, f"expected a mode of {listed}, not {values[0]:g}")
        return None
    if command in firmware.fence or command in firmware.rally:
        return Refused("ERROR" if frame != Frame.MISSION else "UNSUPPORTED")
    return Refused("UNSUPPORTED")


def refused_in_fence(firmware: Firmware, command: int, frame: int, values: Sequence[float]) -> Refused | None:
    if command in POLYGON and not values[0] + 0.5 >= 3:
        return Refused("ERROR", 1, "expected 3 vertices or more")
    return _of_a_list(firmware, firmware.fence, command, frame, values)


def refused_in_rally(firmware: Firmware, command: int, frame: int, values: Sequence[float]) -> Refused | None:
    return _of_a_list(firmware, firmware.rally, command, frame, values)


def _of_a_list(
    firmware: Firmware, commands: Container[int], command: int, frame: int, values: Sequence[float]
) -> Refused | None:
    if frame not in firmware.frames:
        return Refused("UNSUPPORTED_FRAME")
    if wrong := _unused(firmware, command, frame, values):
        return wrong
    if frame == Frame.MISSION:
        return Refused("UNSUPPORTED")
    return None if command in commands else Refused("ERROR")


def _unused(firmware: Firmware, command: int, frame: int, values: Sequence[float]) -> Refused | None:
    """Return the refusal of the first unused param other than 0 or NaN.

    With a place, unused latitude or longitude must be NaN.
    """
    used = None if firmware.used is None else firmware.used.get(command)
    if used is None:
        return None
    places = {5: "INVALID_PARAM5_X", 6: "INVALID_PARAM6_Y"}
    for n, value in enumerate(values, start=1):
        is_integer = n in places and frame != Frame.MISSION
        if n not in used and not (math.isnan(value) or (value == 0.0 and not is_integer)):
            expected = "NaN" if is_integer else "0 or NaN"
            words = f"expected {expected}, as {firmware} does not use this param here, not {value:g}"
            return Refused(places.get(n, f"INVALID_PARAM{n}"), n, words)
    return None


REFUSALS = Refusals(refused, refused_in_fence, refused_in_rally)
