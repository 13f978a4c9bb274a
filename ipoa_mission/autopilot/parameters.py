"""Defaults, types, units and names of parameters."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TypeAlias

Parameters: TypeAlias = Mapping[str, float]
NO_PARAMETERS: Parameters = {}
SINGLE_MAX = 3.4e38  # a float's maximum in MAVLink
INT8, INT16, INT32, REAL32 = 2, 4, 6, 9  # MAV_PARAM_TYPE
Declared: TypeAlias = tuple[float, int]  # value and type


def declared(words: Mapping[int, str]) -> Mapping[str, int]:
    return {name: kind for kind, names in words.items() for name in names.split()}


@dataclass(frozen=True)
class Quantity:
    """A parameter and its unit's size in m, m/s or s."""

    name: str
    unit: float = 1.0

    def spelled(self, value: float) -> float:
        return value / self.unit


@dataclass(frozen=True)
class ParameterTable:
    """An autopilot's known parameters, by their older names.

    Defaults: `moving` affect a mission; ground stations read `others`; `set_up` (value and type). `types`: those that
    are no float. `renamed`: newer name to older name and old units per new unit. `meanings`: quantity to name. `units`:
    size in m, s or degrees. `packs_integers`: integers are sent as a float's bits.
    """

    moving: Parameters
    others: Parameters
    set_up: Mapping[str, Declared]
    types: Mapping[str, int]
    climb: Quantity
    descent: Quantity
    return_height: Quantity
    fence_switch: str  # 0: no fence
    system_id: str
    meanings: Mapping[str, str]
    units: Parameters
    surely_there: tuple[tuple[str, ...], ...]  # alternative names
    renamed: Mapping[str, tuple[str, float]] = field(default_factory=dict)
    packs_integers: bool = False
    speed: Quantity | None = None  # PX4: the limit MPC_XY_VEL_MAX; ArduCopter: the cruise speed WPNAV_SPEED
    fastest: float = 40.0  # twice both firmwares' documented maximum [m/s]

    @property
    def names(self) -> frozenset[str]:
        return frozenset((*self.moving, *self.others, *self.renamed))

    def by_old_names(self, parameters: Parameters) -> dict[str, float]:
        newer = self.renamed
        old = {name: value for name, value in parameters.items() if name not in newer}
        return old | {newer[name][0]: value * newer[name][1] for name, value in parameters.items() if name in newer}

    def complete(self, parameters: Parameters) -> dict[str, float]:
        return {**self.moving, **self.by_old_names(parameters)}

    def overridden(self, parameters: Parameters, by: Parameters) -> dict[str, float]:
        given = self.by_old_names(dict.fromkeys(by, 0.0)).keys()
        kept = {name: value for name, value in parameters.items() if not self.by_old_names({name: 0.0}).keys() & given}
        return kept | dict(by)

    def speed_limit(self, parameters: Parameters) -> float:
        """Return `fastest`, or the vehicle's higher limit [m/s]."""
        limit = 0.0 if self.speed is None else self.by_old_names(parameters).get(self.speed.name, 0.0) * self.speed.unit
        return max(self.fastest, limit)

    def why_too_fast(self, speed: float, parameters: Parameters) -> str | None:
        limit = self.speed_limit(parameters)
        if not speed > limit:
            return None
        unless = "" if self.speed is None else f", unless {self.speed.name} allows more"
        cm = f": is it in cm/s? {speed / 100:g} m/s" if speed / 100 <= limit and speed >= 100 else ""
        return f"expected at most {limit:g} m/s{unless}, not {speed:g}{cm}"

    def spellings(self, name: str) -> list[tuple[str, float]]:
        """Return other names, each with its units per unit of `name`."""
        here = [(name, 1.0)]
        if name in self.renamed:
            old, factor = self.renamed[name]
            return [*here, (old, factor)]
        return [*here, *((new, 1.0 / factor) for new, (old, factor) in self.renamed.items() if old == name)]


def name_values(parameters: Parameters) -> str:
    return " and ".join(f"{name} = {value:g}" for name, value in parameters.items())
