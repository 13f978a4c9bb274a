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
    """Fitted values; None: not determined, the simulator's value holds.

    `drag`: multiple. `lag`: rotors and rate loop [s]. `lift_delay`, `landing_delay`: lift-off and disarming [s,
    signed]. Power [W]: `hover_power` + `square_power` v^2 + `cube_power` v^3 up to `airspeed` [m/s]; `climb_power` and
    `descent_power` per m/s [W, signed]. `energy_ratio`: measured over modeled energy.
    """

    autopilot: Autopilot
    drag: Learned | None = None
    lag: Learned | None = None
    lift_delay: Learned | None = None
    landing_delay: Learned | None = None
    hover_power: Learned | None = None
    square_power: Learned | None = None
    cube_power: Learned | None = None
    climb_power: Learned | None = None
    descent_power: Learned | None = None
    airspeed: Learned | None = None
    energy_ratio: Learned | None = None
    version: str = ""
    flights: int = 0

    def with_numbers(self, numbers: Mapping[str, Learned | None]) -> "LearnedVehicle":
        changes: dict[str, Any] = dict(numbers)
        return replace(self, **changes)

    def value(self, name: str, otherwise: float) -> float:
        """Return a fitted value.

        >>> LearnedVehicle(Autopilot.PX4, drag=Learned(1.6, 1.5, 1.7)).value("drag", 1.0)
        1.6
        """
        learned: Learned | None = getattr(self, name)
        return otherwise if learned is None else learned.value
