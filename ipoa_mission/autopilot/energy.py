"""Power of a multirotor by momentum theory or a measured curve, and the energy that its battery has.

    P = (kappa T v + P_profile + D V + m g w) / eta + P_avionics

T balances weight and drag; `v = T / (2 rho A |V + v|)`; P_profile follows from the figure of merit in hover. J. G.
Leishman, Principles of Helicopter Aerodynamics, 2nd ed. 2006, sections 2.2-2.8, 2.13, 5.3-5.4.

Not modeled: advance ratio, ground effect, vortex ring state. Descent needs level power.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ipoa_mission.errors import MissionError
from ipoa_mission.geometry import GRAVITY, Vector


class PowerCurve(NamedTuple):
    """Power [W] = hover + square v^2 + cube v^3 + climb w, or + descent w in a descent, by airspeed v."""

    hover_w: float
    square_w: float = 0.0  # negative: translational lift
    cube_w: float = 0.0  # drag, never negative
    climb_w: float = 0.0
    descent_w: float = 0.0
    fastest: float = np.inf  # measured airspeed [m/s]

    def level(self, airspeed: Vector) -> Vector:
        measured = np.minimum(airspeed, self.fastest)
        known = self._level(measured)
        return np.asarray(np.where(airspeed > measured, np.maximum(self._level(airspeed), known), known))

    def _level(self, airspeed: Vector) -> Vector:
        return np.asarray(self.hover_w + (self.square_w + self.cube_w * airspeed) * airspeed**2)

    def power(self, airspeed: Vector, climb: Vector) -> Vector:
        upright = self.climb_w * np.maximum(climb, 0.0) + self.descent_w * np.maximum(-climb, 0.0)
        return np.asarray(np.maximum(self.level(airspeed) + upright, 0.0))

    def beyond(self, airspeed: Vector) -> Vector:
        """Return the upper bound's factor beyond `fastest` (n,): all power is drag."""
        cubed = np.asarray(np.maximum(airspeed / self.fastest, 1.0) ** 3)
        return np.asarray(self._level(np.minimum(airspeed, self.fastest)) * cubed / self.level(airspeed))


KAPPA = 1.15  # induced over ideal power (Leishman, section 2.8)


@dataclass(frozen=True)
class PowerModel:
    mass_kg: float  # at take-off
    disc_area: float  # of all rotors [m^2]
    drag_area: float  # C_D A [m^2]
    figure_of_merit: float = 0.6  # ideal over real rotor power in hover
    drive_efficiency: float = 0.8  # of motors and ESCs
    avionics_w: float = 10.0  # all else


def air_density(altitude_amsl: Vector) -> Vector:
    """Compute the ICAO standard density [kg/m^3] at altitudes (n,) below 11 km [m]."""
    return np.asarray(1.225 * (1 - 2.25577e-5 * np.asarray(altitude_amsl, float)) ** 4.25588)


def power(airframe: PowerModel, airspeed: Vector, climb: Vector, density: Vector) -> Vector:
    """Compute electrical power [W]; airspeed and climb [m/s], density [kg/m^3], each (n,)."""
    weight = airframe.mass_kg * GRAVITY
    rising = np.maximum(climb, 0.0)
    drag = 0.5 * density * airframe.drag_area * airspeed**2
    thrust = np.hypot(weight, drag)
    # the disc tilts by asin(drag / thrust)
    along = (airspeed * drag + rising * weight) / thrust
    across = np.sqrt(np.maximum(airspeed**2 + rising**2 - along**2, 0.0))
    induced = induced_speed(thrust, along, across, 2 * density * airframe.disc_area)
    ideal_hover = weight * np.sqrt(weight / (2 * density * airframe.disc_area))
    profile = ideal_hover * (1 / airframe.figure_of_merit - KAPPA)
    rotors = KAPPA * thrust * induced + profile + drag * airspeed + weight * rising
    return np.asarray(rotors / airframe.drive_efficiency + airframe.avionics_w)


def induced_speed(thrust: Vector, along: Vector, across: Vector, twice_density_area: Vector) -> Vector:
    """Solve v sqrt(across^2 + (along + v)^2) = T / (2 rho A) for v [m/s] by Newton's method, from above."""
    hover_squared = thrust / twice_density_area
    v = np.sqrt(hover_squared)
    for _ in range(50):
        flow = np.hypot(across, along + v)
        step = (v * flow - hover_squared) / (flow + v * (along + v) / flow)
        v = v - step
        if np.all(np.abs(step) <= 1e-12 * v):
            break
    return np.asarray(v)


class NotEnoughBattery(MissionError, code="not-enough-battery"):
    """The flight would end with less than the reserve, or not reach home."""


class Interval(NamedTuple):
    low: float
    likely: float
    high: float

    def plus(self, other: "Interval") -> "Interval":
        return Interval(self.low + other.low, self.likely + other.likely, self.high + other.high)

    def rest_after(self, part: "Interval") -> "Interval":
        """Return the rest of the same flight, which takes much where its `part` does: low less low."""
        return Interval(self.low - part.low, self.likely - part.likely, self.high - part.high)

    def __str__(self) -> str:
        return f"{self.likely:.1f} ({self.low:.1f} to {self.high:.1f})"


@dataclass(frozen=True)
class Battery:
    capacity_wh: float  # when full
    reserve: float = 0.2  # share to keep after landing

    @property
    def usable_wh(self) -> float:
        return self.capacity_wh * (1.0 - self.reserve)


def shortage(used: Interval, battery: Battery) -> NotEnoughBattery | None:
    """Return the refusal of an energy [Wh], whose upper bound may use the reserve."""
    left = 1 - used.likely / battery.capacity_wh
    least_left = 1 - used.high / battery.capacity_wh
    rounding = 1e-9
    if left >= battery.reserve - rounding and least_left >= -rounding:
        return None
    takes = f"takes {used.likely:.1f} Wh" + (f" ({used.low:.1f} to {used.high:.1f})" if used.high > used.low else "")
    capacity = f"{battery.capacity_wh:.4g} Wh"
    outcome = f"leaves {left:.1%} of {capacity}" if left > 0 else f"more than the {capacity} of its battery"
    outcome = outcome if left < battery.reserve - rounding else f"may take all of {capacity}"
    needed = max(used.likely / (1 - battery.reserve), used.high)
    return NotEnoughBattery(
        f"expected a reserve of {battery.reserve:.0%} after landing, but the flight {takes}, {outcome}",
        hint=f"take a battery of {needed:.1f} Wh, a shorter route, another speed, or more flights (`plan --split`)",
        place="battery",
    )
