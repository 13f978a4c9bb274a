"""The parameter protocol of the built-in autopilot: names and floats, in a fixed order."""

import math
from collections.abc import Mapping

from ipoa_mission.link.messages import Message, ParamRequestList, ParamRequestRead, ParamSet, ParamValue
from ipoa_mission.vehicle import DEFAULT_PARAMETERS, Autopilot

REAL32 = 9
#: What ground stations look for besides what moves a mission.
_OTHERS: Mapping[Autopilot, Mapping[str, float]] = {
    Autopilot.ARDUPILOT: {"SYSID_THISMAV": 1.0, "FRAME_CLASS": 1.0, "FENCE_ENABLE": 0.0, "RTL_ALT_TYPE": 0.0},
    Autopilot.PX4: {
        "MAV_SYS_ID": 1.0,
        "SYS_AUTOSTART": 4001.0,
        "GF_ACTION": 2.0,
        "MIS_DIST_1WP": 10_000.0,
        "MIS_TKO_LAND_REQ": 0.0,
    },
}


class ParameterTable:
    """The values, and the answers to those who ask for them."""

    def __init__(self, autopilot: Autopilot, given: Mapping[str, float]) -> None:
        self.values = {**DEFAULT_PARAMETERS[autopilot], **_OTHERS[autopilot], **given}

    def answers(self, message: Message) -> list[ParamValue] | None:
        """What to say to a message of the protocol; None: it is not one."""
        names = sorted(self.values)
        match message:
            case ParamRequestList():
                return [self._value(name, names) for name in names]
            case ParamRequestRead(_, index) if 0 <= index < len(names):
                return [self._value(names[index], names)]
            case ParamRequestRead(name, -1):
                return [self._value(name, names)] if name in self.values else []
            case ParamSet(name, value):
                if name in self.values and math.isfinite(value):
                    self.values[name] = value
                return [self._value(name, names)] if name in self.values else []
            case ParamRequestRead():
                return []
        return None

    def _value(self, name: str, names: list[str]) -> ParamValue:
        return ParamValue(name, self.values[name], REAL32, len(names), names.index(name))
