"""Defaults, types, units and names of parameters."""

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Annotated, NamedTuple, TypeAlias, get_origin, get_type_hints

from ipoa_mission.errors import BadInput

Parameters: TypeAlias = Mapping[str, float]
NO_PARAMETERS: Parameters = {}
SINGLE_MAX = 3.4e38  # a float's maximum in MAVLink
INT8, INT16, INT32, REAL32 = 2, 4, 6, 9  # MAV_PARAM_TYPE


class Parameter(NamedTuple):
    """A parameter by its older name, in units of `unit` [m, s or degrees]."""

    name: str
    default: float | None  # None: not simulated
    kind: int = REAL32  # MAV_PARAM_TYPE
    meaning: str = ""  # the same for all autopilots
    unit: float = 1.0
    newer: str = ""  # its newer name, in units of 1
    positive: bool = False  # must be above 0

    def spelled(self, value: float) -> float:
        return value / self.unit

    def si(self, value: float) -> float:
        """Divide by 100 as the firmware does: 0.01 is rounded."""
        return value / (1.0 / self.unit)


def defaults(rows: Iterable[Parameter]) -> dict[str, float]:
    return {row.name: row.default for row in rows if row.default is not None}


@dataclass(frozen=True)
class ParameterTable:
    """An autopilot's known parameters."""

    affecting: tuple[Parameter, ...]  # a mission
    further: tuple[Parameter, ...]  # known, or read by ground stations
    set_up: tuple[Parameter, ...]  # only read by ground stations
    surely_there: tuple[tuple[str, ...], ...]  # alternative names
    steered_by: tuple[str, ...] = ()  # above 0 they may let it leave its path; not modeled
    packs_integers: bool = False  # sent as a float's bits
    limits_speed: str = ""  # PX4: the limit MPC_XY_VEL_MAX; ArduCopter: the cruise speed WPNAV_SPEED
    fastest: float = 40.0  # twice both firmwares' documented maximum [m/s]

    @cached_property
    def by_name(self) -> Mapping[str, Parameter]:
        return {row.name: row for row in (*self.affecting, *self.further)}

    @cached_property
    def kinds(self) -> Mapping[str, int]:
        """Return MAV_PARAM_TYPE by name; others are REAL32."""
        return {row.name: row.kind for row in (*self.set_up, *self.by_name.values())}

    @cached_property
    def by_meaning(self) -> Mapping[str, Parameter]:
        return {row.meaning: row for row in self.by_name.values() if row.meaning}

    @cached_property
    def moving(self) -> Parameters:
        return defaults(self.affecting)

    @cached_property
    def others(self) -> Parameters:
        return defaults(self.further)

    @cached_property
    def renamed(self) -> Mapping[str, tuple[str, float]]:
        """Return the older name, and its units per new unit, by newer name."""
        return {row.newer: (row.name, 1.0 / row.unit) for row in self.by_name.values() if row.newer}

    @cached_property
    def names(self) -> frozenset[str]:
        return frozenset((*self.moving, *self.others, *self.renamed))

    def by_old_names(self, parameters: Parameters) -> dict[str, float]:
        newer = self.renamed
        old = {name: value for name, value in parameters.items() if name not in newer}
        return old | {newer[name][0]: value * newer[name][1] for name, value in parameters.items() if name in newer}

    def complete(self, parameters: Parameters) -> dict[str, float]:
        return {**self.moving, **self.by_old_names(parameters)}

    def si(self, parameters: Parameters) -> dict[str, float]:
        """Return this table's parameters in m, s and degrees."""
        known = self.complete(parameters)
        return {name: row.si(known[name]) for name, row in self.by_name.items() if name in known}

    def meant(self, meaning: str, complete: Parameters) -> float:
        row = self.by_meaning[meaning]
        return row.si(complete[row.name])

    def overridden(self, parameters: Parameters, by: Parameters) -> dict[str, float]:
        replaced = self.by_old_names(dict.fromkeys(by, 0.0)).keys()
        rest = {
            name: value for name, value in parameters.items() if not self.by_old_names({name: 0.0}).keys() & replaced
        }
        return rest | dict(by)

    def has_bit(self, parameters: Parameters, switch: tuple[str, int]) -> bool:
        name, bit = switch
        return bool(whole(self.by_old_names(parameters), name) >> bit & 1)

    @cached_property
    def positive(self) -> tuple[str, ...]:
        return tuple(row.name for row in self.affecting if row.positive)

    def expect_positive(self, parameters: Parameters) -> None:
        """Raise BadInput for a value that must be above 0."""
        for name in self.positive:
            if not parameters[name] > 0:
                raise BadInput(f"expected more than 0, not {parameters[name]:g}", place=name)

    def usable(self, parameters: Parameters) -> dict[str, float]:
        """Drop values that must be above 0 and are not."""
        return {name: value for name, value in parameters.items() if name not in self.positive or value > 0}

    def speed_limit(self, parameters: Parameters) -> float:
        """Return `fastest`, or the vehicle's higher limit [m/s]."""
        unit = self.by_name[self.limits_speed].unit if self.limits_speed else 0.0
        return max(self.fastest, self.by_old_names(parameters).get(self.limits_speed, 0.0) * unit)

    def why_too_fast(self, speed: float, parameters: Parameters) -> str | None:
        limit = self.speed_limit(parameters)
        if not speed > limit:
            return None
        unless = f", unless {self.limits_speed} allows more" if self.limits_speed else ""
        cm = f": is it in cm/s? {speed / 100:g} m/s" if speed / 100 <= limit and speed >= 100 else ""
        return f"expected at most {limit:g} m/s{unless}, not {speed:g}{cm}"

    def spellings(self, name: str) -> list[tuple[str, float]]:
        """Return other names, each with its units per unit of `name`."""
        if name in self.renamed:
            return [(name, 1.0), self.renamed[name]]
        return [(name, 1.0), *((new, 1.0 / factor) for new, (old, factor) in self.renamed.items() if old == name)]


def parameters_of_fields(record: type) -> Mapping[str, str]:
    """Return the parameter of each field that is annotated with one, as `speed: Annotated[float, "WPNAV_SPEED"]`."""
    hints = get_type_hints(record, include_extras=True)
    return {field: hint.__metadata__[0] for field, hint in hints.items() if get_origin(hint) is Annotated}


def whole(parameters: Parameters, name: str, default: float = 0.0) -> int:
    """Return a parameter of bits or choices; raise BadInput for NaN and infinity."""
    value = parameters.get(name, default)
    if not math.isfinite(value):
        raise BadInput(f"expected a whole number, not {value:g}", place=name)
    return int(value)


def name_values(parameters: Parameters) -> str:
    return " and ".join(f"{name} = {value:g}" for name, value in parameters.items())
