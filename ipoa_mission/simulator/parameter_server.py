import math
from collections.abc import Mapping

from ipoa_mission.autopilot.autopilot import Autopilot
from ipoa_mission.autopilot.parameters import REAL32
from ipoa_mission.autopilot.version import Version
from ipoa_mission.link.messages import Message, ParamRequestList, ParamRequestRead, ParamSet, ParamValue
from ipoa_mission.link.orders import parameter_value, spelled_parameter

#: ArduPilot's PARAM_VALUE.param_index of a named request.
BY_NAME = 65535


class ParameterServer:
    def __init__(self, autopilot: Autopilot, given: Mapping[str, float], version: Version | None = None) -> None:
        self._autopilot = autopilot
        set_up = autopilot.book.set_up
        self._types = {**autopilot.book.types, **{name: kind for name, (_, kind) in set_up.items()}}
        declared = {name: value for name, (value, _) in set_up.items()}
        own = {**autopilot.book.moving, **autopilot.defaults_of(version)}
        self.values = {**declared, **own, **autopilot.book.others, **given}

    def answers(self, message: Message) -> list[ParamValue] | None:
        """None for other messages."""
        names = sorted(self.values)
        match message:
            case ParamRequestList():
                return [self._value(name, index, len(names)) for index, name in enumerate(names)]
            case ParamRequestRead(_, index) if 0 <= index < len(names):
                return [self._value(names[index], index, len(names))]
            case ParamRequestRead(name, -1):
                return self._named(name, names)
            case ParamSet(name, value, kind):
                self._set(name, value, kind)
                return self._named(name, names)
            case ParamRequestRead():
                return []
        return None

    def _set(self, name: str, value: float, kind: int) -> None:
        """Convert or ignore another type."""
        own = self._types.get(name, REAL32)
        if name not in self.values or (self._autopilot.protocol_profile.keeps_types and kind != own):
            return
        number = parameter_value(ParamValue(name, value, own, 0, 0), self._autopilot)
        if math.isfinite(number):
            self.values[name] = number if own == REAL32 else float(round(number))

    def _named(self, name: str, names: list[str]) -> list[ParamValue]:
        if name not in self.values:
            return []
        index = BY_NAME if self._autopilot.protocol_profile.parameters_by_name else names.index(name)
        return [self._value(name, index, len(names))]

    def _value(self, name: str, index: int, count: int) -> ParamValue:
        kind = self._types.get(name, REAL32)
        return ParamValue(name, spelled_parameter(self.values[name], kind, self._autopilot), kind, count, index)
