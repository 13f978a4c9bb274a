"""The parameters of one autopilot: its defaults, how it declares them, what it calls what others call otherwise."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TypeAlias

Parameters: TypeAlias = Mapping[str, float]
NO_PARAMETERS: Parameters = {}
SINGLE_MAX = 3.4e38  # what MAVLink's floats can carry
INT8, INT16, INT32, REAL32 = 2, 4, 6, 9  # MAV_PARAM_TYPE
Declared: TypeAlias = tuple[float, int]  # a value and its type


def declared(words: Mapping[int, str]) -> Mapping[str, int]:
    """The MAV_PARAM_TYPE of each parameter, from the names of each type."""
    return {name: kind for kind, names in words.items() for name in names.split()}


@dataclass(frozen=True)
class Quantity:
    """A parameter, and how many metres, metres per second or seconds one of its units is."""

    name: str
    unit: float = 1.0

    def spelled(self, value: float) -> float:
        """A value [m, m/s, s] in the parameter's unit."""
        return value / self.unit


@dataclass(frozen=True)
class ParameterTable:
    """What is known of an autopilot's parameters, by the older of their names.

    `moving` are the defaults of what moves a mission, `others` of what ground stations look for besides, `set_up` of
    how a vehicle was set up (value and type). `types` has what is no float. `renamed` has the older name of each newer
    one, and how many of the old unit make one of the new. `meanings` has this autopilot's name for what has another
    name elsewhere; `units` has those that are the same quantity there, and how many m, s or degrees one unit is.
    `packs_integers`: the bits of a whole number are sent in the place of a float's.
    """

    moving: Parameters
    others: Parameters
    set_up: Mapping[str, Declared]
    types: Mapping[str, int]
    climb: Quantity
    descent: Quantity
    return_height: Quantity
    fence_switch: str  # which puts a fence into force; at 0 it has no effect
    system_id: str
    meanings: Mapping[str, str]
    units: Parameters
    surely_there: tuple[tuple[str, ...], ...]  # what every vehicle has: each by any of its names
    renamed: Mapping[str, tuple[str, float]] = field(default_factory=dict)
    packs_integers: bool = False
    speed: Quantity | None = None  # that limits or sets the speed of a mission
    fastest: float = 40.0  # twice what both firmwares document for it: some vehicles are set up beyond [m/s]

    @property
    def names(self) -> frozenset[str]:
        """All names that are known, old and new."""
        return frozenset((*self.moving, *self.others, *self.renamed))

    def by_old_names(self, parameters: Parameters) -> dict[str, float]:
        """The same parameters, those that have a newer name by the older one and in its unit."""
        newer = self.renamed
        old = {name: value for name, value in parameters.items() if name not in newer}
        return old | {newer[name][0]: value * newer[name][1] for name, value in parameters.items() if name in newer}

    def complete(self, parameters: Parameters) -> dict[str, float]:
        """These parameters by their older names, and the defaults of what is not given."""
        return {**self.moving, **self.by_old_names(parameters)}

    def overridden(self, parameters: Parameters, by: Parameters) -> dict[str, float]:
        """All of these parameters, with the value that `by` gives where it names one, by its older or newer name."""
        given = self.by_old_names(dict.fromkeys(by, 0.0)).keys()
        kept = {name: value for name, value in parameters.items() if not self.by_old_names({name: 0.0}).keys() & given}
        return kept | dict(by)

    def speed_limit(self, parameters: Parameters) -> float:
        """Limit the speeds of a mission [m/s]: by `fastest`, or a faster vehicle's own parameter."""
        own = 0.0 if self.speed is None else self.by_old_names(parameters).get(self.speed.name, 0.0) * self.speed.unit
        return max(self.fastest, own)

    def why_too_fast(self, speed: float, parameters: Parameters) -> str | None:
        """Explain that a mission's speed [m/s] is beyond the limit; None where it is not."""
        limit = self.speed_limit(parameters)
        if not speed > limit:
            return None
        unless = "" if self.speed is None else f", unless {self.speed.name} allows more"
        cm = f": is it in cm/s? {speed / 100:g} m/s" if speed / 100 <= limit and speed >= 100 else ""
        return f"expected at most {limit:g} m/s{unless}, not {speed:g}{cm}"

    def spellings(self, name: str) -> list[tuple[str, float]]:
        """What a vehicle may call this parameter, and how many of its unit make one of the given name's."""
        here = [(name, 1.0)]
        if name in self.renamed:
            old, factor = self.renamed[name]
            return [*here, (old, factor)]
        return [*here, *((new, 1.0 / factor) for new, (old, factor) in self.renamed.items() if old == name)]
