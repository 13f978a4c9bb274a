"""An autopilot's parameters: defaults, types, units and names."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TypeAlias

Parameters: TypeAlias = Mapping[str, float]
NO_PARAMETERS: Parameters = {}
SINGLE_MAX = 3.4e38  # largest float of MAVLink
INT8, INT16, INT32, REAL32 = 2, 4, 6, 9  # MAV_PARAM_TYPE
Declared: TypeAlias = tuple[float, int]  # value and type


def declared(words: Mapping[int, str]) -> Mapping[str, int]:
    """Return the MAV_PARAM_TYPE of each parameter, from the names of each type."""
    return {name: kind for kind, names in words.items() for name in names.split()}


@dataclass(frozen=True)
class Quantity:
    """A parameter and the size of its unit in m, m/s or s."""

    name: str
    unit: float = 1.0

    def spelled(self, value: float) -> float:
        """Convert a value [m, m/s, s] to the parameter's unit."""
        return value / self.unit


@dataclass(frozen=True)
class ParameterTable:
    """An autopilot's known parameters, by their older names.

    Defaults: `moving` affect a mission; `others` are read by ground stations; `set_up` describe the vehicle's set-up
    (value and type). `types`: parameters that are no float. `renamed`: newer name to older name and old units per new
    unit. `meanings`: quantity to this autopilot's name. `units`: size of a parameter's unit in m, s or degrees, where
    other autopilots have the same quantity. `packs_integers`: integers are sent as their bits in a float.
    """

    moving: Parameters
    others: Parameters
    set_up: Mapping[str, Declared]
    types: Mapping[str, int]
    climb: Quantity
    descent: Quantity
    return_height: Quantity
    fence_switch: str  # activates a fence; 0: no effect
    system_id: str
    meanings: Mapping[str, str]
    units: Parameters
    surely_there: tuple[tuple[str, ...], ...]  # on every vehicle: alternative names of each
    renamed: Mapping[str, tuple[str, float]] = field(default_factory=dict)
    packs_integers: bool = False
    speed: Quantity | None = None  # limits or sets the speed of a mission
    fastest: float = 40.0  # twice the documented maximum of both firmwares, as some vehicles exceed it [m/s]

    @property
    def names(self) -> frozenset[str]:
        return frozenset((*self.moving, *self.others, *self.renamed))

    def by_old_names(self, parameters: Parameters) -> dict[str, float]:
        newer = self.renamed
        old = {name: value for name, value in parameters.items() if name not in newer}
        return old | {newer[name][0]: value * newer[name][1] for name, value in parameters.items() if name in newer}

    def complete(self, parameters: Parameters) -> dict[str, float]:
        """Return the parameters by their older names, with defaults for missing ones."""
        return {**self.moving, **self.by_old_names(parameters)}

    def overridden(self, parameters: Parameters, by: Parameters) -> dict[str, float]:
        """Return the parameters with the values of `by`, by older or newer name, in their place."""
        given = self.by_old_names(dict.fromkeys(by, 0.0)).keys()
        kept = {name: value for name, value in parameters.items() if not self.by_old_names({name: 0.0}).keys() & given}
        return kept | dict(by)

    def speed_limit(self, parameters: Parameters) -> float:
        """Return the greatest plausible speed of a mission [m/s]: `fastest`, or the vehicle's own limit if higher."""
        own = 0.0 if self.speed is None else self.by_old_names(parameters).get(self.speed.name, 0.0) * self.speed.unit
        return max(self.fastest, own)

    def why_too_fast(self, speed: float, parameters: Parameters) -> str | None:
        """Return why a mission's speed [m/s] exceeds the limit; None if it does not."""
        limit = self.speed_limit(parameters)
        if not speed > limit:
            return None
        unless = "" if self.speed is None else f", unless {self.speed.name} allows more"
        cm = f": is it in cm/s? {speed / 100:g} m/s" if speed / 100 <= limit and speed >= 100 else ""
        return f"expected at most {limit:g} m/s{unless}, not {speed:g}{cm}"

    def spellings(self, name: str) -> list[tuple[str, float]]:
        """Return the alternative names of a parameter, each with its units per unit of `name`."""
        here = [(name, 1.0)]
        if name in self.renamed:
            old, factor = self.renamed[name]
            return [*here, (old, factor)]
        return [*here, *((new, 1.0 / factor) for new, (old, factor) in self.renamed.items() if old == name)]
