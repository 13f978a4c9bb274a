"""Compare a vehicle's parameters with those that a mission was made for."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Protocol

from ipoa_mission.autopilot.autopilot import Autopilot
from ipoa_mission.autopilot.parameters import Parameters
from ipoa_mission.autopilot.version import Version
from ipoa_mission.link.messages import STATION_SYSTEM
from ipoa_mission.mission.items import Mission


class HasParameters(Protocol):
    autopilot: Autopilot

    def parameters(self, wanted: Iterable[str | Sequence[str]]) -> Parameters: ...


@dataclass(frozen=True)
class OtherValue:
    """Values of mission and vehicle, by the vehicle's name."""

    name: str
    wanted: float
    has: float

    def __str__(self) -> str:
        return f"{self.name} is {self.has:g} on the vehicle, and the mission was made for {self.wanted:g}"


def other_values(vehicle: HasParameters, wanted: Parameters) -> tuple[tuple[OtherValue, ...], tuple[str, ...]]:
    """Return differing values, and parameters that the vehicle lacks. ArduCopter 4.7 has renamed and rescaled some."""
    spelled = vehicle.autopilot.parameter_table.spellings
    values = vehicle.parameters([name for name, _ in spelled(parameter)] for parameter in wanted) if wanted else {}
    differing = []
    missing = []
    for parameter, value in wanted.items():
        for name, unit in spelled(parameter):
            if name in values:
                if not abs(values[name] - value * unit) <= 1e-6 * max(1.0, abs(value * unit)):  # single; NaN differs
                    differing.append(OtherValue(name, value * unit, values[name]))
                break
        else:
            missing.append(parameter)
    return tuple(differing), tuple(missing)


def own_values(vehicle: HasParameters, names: Iterable[str]) -> Parameters:
    table = vehicle.autopilot.parameter_table
    return table.by_old_names(vehicle.parameters([name for name, _ in table.spellings(older)] for older in names))


def without_station(vehicle: HasParameters, version: Version | None = None) -> str:
    """Return what the vehicle does after losing this station, if known; by default of the newest measured version."""
    loss = vehicle.autopilot.failsafe_profile.station_loss
    if loss is None:
        return ""
    values = vehicle.parameters(loss.decided_by)
    return loss.words(vehicle.autopilot.failsafes(values, version), values, STATION_SYSTEM)


def idle_fence(vehicle: HasParameters, mission: Mission) -> str | None:
    if not mission.fence:
        return None
    switch = vehicle.autopilot.parameter_table.by_meaning["fence switch"].name
    if vehicle.parameters([switch]).get(switch, 1.0) != 0.0:
        return None
    bits = vehicle.autopilot.protocol_profile.limits_are_bits
    more = f"; {bits} chooses the enabled limits: 4 is this fence alone" if bits else ""
    return f"the fence does nothing on this vehicle: its {switch} is 0{more}"
