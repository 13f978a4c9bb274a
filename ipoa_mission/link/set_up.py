"""What a vehicle will not do with a mission although it holds it: by its own parameters, read and set over the link."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol

from ipoa_mission.autopilots.renamed import RENAMED, by_old_names
from ipoa_mission.autopilots.vehicle import Autopilot, Parameters
from ipoa_mission.items import Mission

#: The parameter that puts a fence into force, and the value that leaves it without effect.
FENCE_SWITCH: Mapping[Autopilot, str] = {Autopilot.ARDUPILOT: "FENCE_ENABLE", Autopilot.PX4: "GF_ACTION"}
#: Values of a parameter agree to single precision.
ROUNDING = 1e-6


class HasParameters(Protocol):
    """A vehicle whose parameters can be read."""

    autopilot: Autopilot

    def parameters(self, wanted: Iterable[str | Sequence[str]]) -> Parameters:
        """Its values of these, each by any of its names; what it does not have is left out."""


@dataclass(frozen=True)
class OtherValue:
    """A parameter that the mission was made for with another value than the vehicle has, by the vehicle's name."""

    name: str
    wanted: float
    has: float

    def __str__(self) -> str:
        return f"{self.name} is {self.has:g} on the vehicle, and the mission was made for {self.wanted:g}"


def other_values(vehicle: HasParameters, wanted: Parameters) -> tuple[tuple[OtherValue, ...], tuple[str, ...]]:
    """Which of these parameters the vehicle has otherwise, and which it does not have at all.

    ArduCopter 4.7 has new names and units for some; a parameter is looked up by the name that the vehicle knows.
    """
    values = vehicle.parameters([name for name, _ in _names(one)] for one in wanted) if wanted else {}
    others, missing = [], []
    for one, value in wanted.items():
        for name, unit in _names(one):
            if name in values:
                if abs(values[name] - value * unit) > ROUNDING * max(1.0, abs(value * unit)):
                    others.append(OtherValue(name, value * unit, values[name]))
                break
        else:
            missing.append(one)
    return tuple(others), tuple(missing)


def own_values(vehicle: HasParameters, names: Iterable[str]) -> Parameters:
    """The vehicle's values of these that it has, by ArduCopter's names and units of before 4.7."""
    return by_old_names(vehicle.parameters([name for name, _ in _names(one)] for one in names))


def idle_fence(vehicle: HasParameters, mission: Mission) -> str | None:
    """What to say where the vehicle holds the mission's fence and does nothing with it."""
    if not mission.fence:
        return None
    switch = FENCE_SWITCH[vehicle.autopilot]
    if vehicle.parameters([switch]).get(switch, 1.0) != 0.0:
        return None
    more = "; FENCE_TYPE says what it puts into force: 4 is this fence alone" if switch == "FENCE_ENABLE" else ""
    return f"the fence does nothing on this vehicle: its {switch} is 0{more}"


def _names(name: str) -> list[tuple[str, float]]:
    """The names that a parameter goes by, and how many of each one's unit make one of its own."""
    names = [(name, 1.0)]
    names += [(new, 1.0 / unit) for new, (old, unit) in RENAMED.items() if old == name]
    if name in RENAMED:
        old, unit = RENAMED[name]
        names.append((old, unit))
    return names
