"""Electrical power of a multirotor by momentum theory.

    P = (kappa T v + P_profile + D V + m g w) / eta + P_avionics

T balances weight and drag; `v = T / (2 rho A |V + v|)`; P_profile follows from the figure of merit in hover. J. G.
Leishman, Principles of Helicopter Aerodynamics, 2nd ed. 2006, sections 2.2-2.8, 2.13, 5.3-5.4. With T = m g and no
tilt: Y. Zeng, J. Xu, R. Zhang, IEEE Trans. Wireless Commun. 18 (2019) 2329, eq. (12).

Not modeled: advance ratio, ground effect, vortex ring state. Descent needs level power.
"""

from dataclasses import dataclass

import numpy as np

from ipoa_mission.errors import BadInput
from ipoa_mission.geometry import GRAVITY, Vector

KAPPA = 1.15  # induced over ideal power (Leishman, section 2.8)


@dataclass(frozen=True)
class PowerModel:
    """Take-off mass [kg], area of all rotor discs [m^2], drag area C_D A [m^2].

    `figure_of_merit`: ideal over real rotor power in hover. `drive_efficiency`: of motors and ESCs. `avionics_w`: all
    else [W].
    """

    mass_kg: float
    disc_area: float
    drag_area: float
    figure_of_merit: float = 0.6
    drive_efficiency: float = 0.8
    avionics_w: float = 10.0

    def __post_init__(self) -> None:
        for name in ("mass_kg", "disc_area"):
            if not getattr(self, name) > 0:
                raise BadInput(f"expected a positive number, not {getattr(self, name):g}", place=f"airframe.{name}")
        if not 0 < self.figure_of_merit <= 1 / KAPPA or not 0 < self.drive_efficiency <= 1:
            raise BadInput(
                f"expected a figure of merit of at most {1 / KAPPA:.2f} and a drive efficiency of at most 1, "
                f"not {self.figure_of_merit:g} and {self.drive_efficiency:g}",
                place="airframe",
            )


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
    """Solve v sqrt(across^2 + (along + v)^2) = T / (2 rho A) for v [m/s] by Newton's method.

    For v, along >= 0 it is convex, so Newton converges from above.
    """
    hover_squared = thrust / twice_density_area
    v = np.sqrt(hover_squared)
    for _ in range(50):
        flow = np.hypot(across, along + v)
        step = (v * flow - hover_squared) / (flow + v * (along + v) / flow)
        v = v - step
        if np.all(np.abs(step) <= 1e-12 * v):
            break
    return np.asarray(v)
