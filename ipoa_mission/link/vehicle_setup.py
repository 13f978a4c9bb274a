"""What a vehicle will not do with a mission although it holds it: by its own parameters, read and set over the link."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Protocol

from ipoa_mission.link.messages import STATION_SYSTEM
from ipoa_mission.mission.items import Mission
from ipoa_mission.vehicles.autopilot import Autopilot
from ipoa_mission.vehicles.parameters import Parameters
from ipoa_mission.vehicles.version import Version

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
    spelled = vehicle.autopilot.book.spellings
    values = vehicle.parameters([name for name, _ in spelled(one)] for one in wanted) if wanted else {}
    others, missing = [], []
    for one, value in wanted.items():
        for name, unit in spelled(one):
            if name in values:
                if not abs(values[name] - value * unit) <= ROUNDING * max(1.0, abs(value * unit)):  # NaN is another
                    others.append(OtherValue(name, value * unit, values[name]))
                break
        else:
            missing.append(one)
    return tuple(others), tuple(missing)


def own_values(vehicle: HasParameters, names: Iterable[str]) -> Parameters:
    """The vehicle's values of these that it has, by its older names and in their units."""
    book = vehicle.autopilot.book
    return book.by_old_names(vehicle.parameters([name for name, _ in book.spellings(one)] for one in names))


def without_station(vehicle: HasParameters, version: Version | None = None) -> str:
    """What the vehicle does when it loses this ground station, by its own parameters; nothing where nobody knows.

    `version` of its firmware: left out, the newest measured.

    Raises:
        NoAnswer: it does not tell its parameters.
    """
    loss = vehicle.autopilot.station_loss
    if loss is None:
        return ""
    values = vehicle.parameters(loss.decided_by)
    return loss.words(vehicle.autopilot.failsafes(values, version), values, STATION_SYSTEM)


def idle_fence(vehicle: HasParameters, mission: Mission) -> str | None:
    """What to say where the vehicle holds the mission's fence and does nothing with it."""
    if not mission.fence:
        return None
    switch = vehicle.autopilot.book.fence_switch
    if vehicle.parameters([switch]).get(switch, 1.0) != 0.0:
        return None
    bits = vehicle.autopilot.protocol_profile.limits_are_bits
    more = f"; {bits} says what it puts into force: 4 is this fence alone" if bits else ""
    return f"the fence does nothing on this vehicle: its {switch} is 0{more}"
