"""How one vehicle differs from the simulated one that the time models are made of: what `learn` finds in its logs."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

from ipoa_mission.vehicles.autopilot import Autopilot


@dataclass(frozen=True)
class Learned:
    """A number and where it lies with a chance of nine in ten."""

    value: float
    low: float
    high: float


@dataclass(frozen=True)
class LearnedVehicle:
    """The numbers of one vehicle; None where its flights do not tell, so that the simulated vehicle's counts.

    `drag` is a multiple of the simulated vehicle's, `lag` [s] that of rotors and rate loop; it lifts off `lift_delay`
    [s] and disarms after a landing `landing_delay` [s] later than that one, or earlier if negative. Hovering takes
    `hover_power` [W] out of its batteries; an airspeed v up to `airspeed` [m/s] takes `square_power` v^2 and
    `cube_power` v^3 [W] more, and each m/s of climb or of descent `climb_power` or `descent_power` [W] more, which may
    be negative. `energy_ratio`: how many times as much as that flights take. `version` and `flights`: of what they were
    learned.
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
        """The same with these, by name."""
        changes: dict[str, Any] = dict(numbers)
        return replace(self, **changes)

    def value(self, name: str, otherwise: float) -> float:
        """One of its numbers, or what holds otherwise.

        >>> LearnedVehicle(Autopilot.PX4, drag=Learned(1.6, 1.5, 1.7)).value("drag", 1.0)
        1.6
        """
        learned: Learned | None = getattr(self, name)
        return otherwise if learned is None else learned.value
