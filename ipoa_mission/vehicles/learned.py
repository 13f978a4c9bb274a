"""Differences of one vehicle from the simulated one, fitted to its logs by `learn`."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

from ipoa_mission.vehicles.autopilot import Autopilot


@dataclass(frozen=True)
class Learned:
    """A value with its 90 % interval."""

    value: float
    low: float
    high: float


@dataclass(frozen=True)
class LearnedVehicle:
    """The fitted values of one vehicle; None: undetermined, so the simulated vehicle's value counts.

    `drag`: multiple of the simulated vehicle's. `lag`: of rotors and rate loop [s]. `lift_delay` and `landing_delay`:
    later lift-off and disarming than simulated [s], may be negative. Battery power [W]: `hover_power` in hover, plus
    `square_power` v^2 and `cube_power` v^3 at airspeed v up to `airspeed` [m/s]. `climb_power` and `descent_power`: per
    m/s of climb and descent [W], may be negative. `energy_ratio`: measured over modeled energy of whole flights.
    `version` and `flights`: the source of the values.
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
        """Return a fitted value, or `otherwise` if undetermined.

        >>> LearnedVehicle(Autopilot.PX4, drag=Learned(1.6, 1.5, 1.7)).value("drag", 1.0)
        1.6
        """
        learned: Learned | None = getattr(self, name)
        return otherwise if learned is None else learned.value
