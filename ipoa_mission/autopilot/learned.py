"""One vehicle's differences from the simulated one, fitted to logs."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

from ipoa_mission.autopilot.autopilot import Autopilot


@dataclass(frozen=True)
class Learned:
    value: float
    low: float
    high: float


@dataclass(frozen=True)
class LearnedVehicle:
    """Fitted values; None: not determined, the simulator's value holds. Powers as in `energy.PowerCurve`."""

    autopilot: Autopilot
    drag: Learned | None = None  # multiple
    lag: Learned | None = None  # of rotors and rate loop [s]
    lift_delay: Learned | None = None  # of lift-off [s, signed]
    landing_delay: Learned | None = None  # of disarming [s, signed]
    hover_power: Learned | None = None  # [W]
    square_power: Learned | None = None
    cube_power: Learned | None = None
    climb_power: Learned | None = None  # [W per m/s, signed]
    descent_power: Learned | None = None
    airspeed: Learned | None = None  # the fastest measured [m/s]
    energy_ratio: Learned | None = None  # measured over modeled
    version: str = ""
    flights: int = 0

    def with_numbers(self, numbers: Mapping[str, Learned | None]) -> "LearnedVehicle":
        changes: dict[str, Any] = dict(numbers)
        return replace(self, **changes)

    def value(self, name: str, otherwise: float) -> float:
        learned: Learned | None = getattr(self, name)
        return otherwise if learned is None else learned.value
