"""Energy of a flight by momentum theory, by a measured power curve, or by its hover power.

Electrical power of a multirotor by momentum theory:

    P = (kappa T v + P_profile + D V + m g w) / eta + P_avionics

T balances weight and drag; `v = T / (2 rho A |V + v|)`; P_profile follows from the figure of merit in hover. J. G.
Leishman, Principles of Helicopter Aerodynamics, 2nd ed. 2006, sections 2.2-2.8, 2.13, 5.3-5.4. With T = m g and no
tilt: Y. Zeng, J. Xu, R. Zhang, IEEE Trans. Wireless Commun. 18 (2019) 2329, eq. (12).

Not modeled: advance ratio, ground effect, vortex ring state. Descent needs level power.
"""

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from ipoa_mission.errors import BadInput, MissionError
from ipoa_mission.geometry import GRAVITY, Points, Vector
from ipoa_mission.wind import CALM, Wind


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


JOULES_PER_WATT_HOUR = 3600.0
LIFTED_DISTANCE = 0.1  # from the first place to lift-off [m]


class NotEnoughBattery(MissionError):
    """The flight would end with less than the reserve, or not reach home."""


class Interval(NamedTuple):
    low: float
    likely: float
    high: float

    def __str__(self) -> str:
        return f"{self.likely:.1f} ({self.low:.1f} to {self.high:.1f})"


@dataclass(frozen=True)
class Battery:
    capacity_wh: float  # when full
    reserve: float = 0.2  # share to keep after landing

    def __post_init__(self) -> None:
        if not self.capacity_wh > 0 or not 0 <= self.reserve < 1:
            raise BadInput(
                "expected a capacity above 0 and a reserve from 0 to below 1, "
                f"not {self.capacity_wh:g} Wh and {self.reserve:g}",
                place="battery",
            )

    @property
    def usable_wh(self) -> float:
        return self.capacity_wh * (1.0 - self.reserve)


@dataclass(frozen=True, eq=False)
class TimedPath:
    """`times` (n,) [s], `points` (n, 3) [m], `speeds` (n,) over ground, with climb [m/s].

    Points are east, north, up; speeds derived from them would jump. `altitude_amsl` [m] is that of up = 0. A repeated
    time counts once. Raises BadInput if the times do not increase, or the lengths differ.
    """

    times: Vector
    points: Points
    speeds: Vector
    altitude_amsl: float = 0.0

    def __post_init__(self) -> None:
        times, lengths = self.times, {len(self.times), len(self.points), len(self.speeds)}
        if len(lengths) > 1 or not (np.diff(times) >= 0).all() or not times[-1] > times[0]:
            raise BadInput("expected times, speeds and points of one length, and increasing times", place="track")
        lasting = np.concatenate([np.diff(times) > 0, [True]])
        for name in ("times", "points", "speeds"):
            object.__setattr__(self, name, getattr(self, name)[lasting])

    def through_air(self, wind: Wind) -> tuple[Vector, Vector]:
        """Return airspeeds and climb rates, (n-1,) [m/s]."""
        moved = np.diff(self.points, axis=0)
        climb, speed = moved[:, 2] / np.diff(self.times), (self.speeds[:-1] + self.speeds[1:]) / 2
        level = np.sqrt(np.maximum(speed**2 - climb**2, 0.0))
        if wind == CALM:
            return level, climb
        along = np.hypot(moved[:, 0], moved[:, 1])
        towards = moved[:, :2] / np.where(along > 0.0, along, np.inf)[:, None]
        blows = np.array([wind.towards(float(up)) for up in (self.points[:-1, 2] + self.points[1:, 2]) / 2])
        return np.hypot(*(level[:, None] * towards - blows).T), climb

    def is_flown(self) -> Vector:
        """Return 1 for spans (n-1,) in the air, else 0; all 1 if it never moves."""
        away = np.linalg.norm(self.points - self.points[0], axis=1) > LIFTED_DISTANCE
        ahead = np.linalg.norm(self.points - self.points[-1], axis=1) > LIFTED_DISTANCE
        if not away.any():
            return np.ones(len(self.points) - 1)
        spans = np.arange(len(self.points) - 1)
        return np.asarray((spans >= np.argmax(away) - 1) & (spans <= np.flatnonzero(ahead)[-1]), float)


@dataclass(frozen=True, eq=False)
class Consumption:
    """The spans between `times` (n,) [s] draw `spans_w` (n-1,) [W]; 90 % interval, or all three equal if unknown."""

    times: Vector
    least_w: Vector
    spans_w: Vector
    most_w: Vector

    def __str__(self) -> str:
        between = self.between
        unsure = f" ({between.low:.1f} to {between.high:.1f})" if between.high > between.low else ""
        return f"{self.energy_wh:.1f} Wh{unsure}, {self.mean_w:.0f} W on average"

    @property
    def energy_wh(self) -> float:
        return self.between.likely

    @property
    def mean_w(self) -> float:
        return self.energy_wh * JOULES_PER_WATT_HOUR / float(self.times[-1] - self.times[0])

    @property
    def between(self) -> Interval:
        return self.until(float(self.times[-1]))

    def until(self, time: float) -> Interval:
        lasts = np.diff(self.times) / JOULES_PER_WATT_HOUR
        spans = (self.least_w, self.spans_w, self.most_w)
        used = (np.concatenate([[0.0], np.cumsum(drawn * lasts)]) for drawn in spans)
        return Interval(*(float(np.interp(time, self.times, energy)) for energy in used))

    def widened(self, low: float, high: float) -> "Consumption":
        return replace(self, least_w=self.least_w * low, most_w=self.most_w * high)

    def lasting(self, least_s: float, most_s: float) -> "Consumption":
        """Return a copy for this duration interval [s]: both uncertainties combined."""
        lasts, energy = float(self.times[-1] - self.times[0]), self.between
        below, above = 1.0 - energy.low / energy.likely, energy.high / energy.likely - 1.0
        earlier, later = max(1.0 - least_s / lasts, 0.0), max(most_s / lasts - 1.0, 0.0)
        low = max(1.0 - np.hypot(below, earlier), 0.0) / max(1.0 - below, 1e-9)
        return self.widened(low, (1.0 + np.hypot(above, later)) / (1.0 + above))

    def left(self, battery: Battery) -> float:
        return 1 - self.energy_wh / battery.capacity_wh


def consumption(
    airframe: PowerModel, path: TimedPath, wind: Wind = CALM, head_wind: float = 0.0, hover_w: float | None = None
) -> Consumption:
    """Compute the consumption by momentum theory.

    `head_wind` [m/s] adds to `wind`, also in hover. Deceleration returns no energy. `hover_w` scales all power to the
    hover power measured at up = 0 [W].
    """
    airspeed, climb = path.through_air(wind)
    density = air_density(path.altitude_amsl + (path.points[:-1, 2] + path.points[1:, 2]) / 2)
    steady = power(airframe, airspeed + head_wind, climb, density)
    gained = np.maximum(np.diff(0.5 * airframe.mass_kg * path.speeds**2), 0.0)
    drawn = steady + gained / airframe.drive_efficiency / np.diff(path.times)
    if hover_w is not None:
        still = np.zeros(1)
        drawn *= hover_w / power(airframe, still, still, air_density(still + path.altitude_amsl))
    return Consumption(path.times, drawn, drawn, drawn)


def by_curve(curve: PowerCurve, path: TimedPath, wind: Wind = CALM, head_wind: float = 0.0) -> Consumption:
    """Compute the consumption by a measured curve, or by the hover power alone.

    >>> east = np.array([[0.0, 0.0, 0.0], [0.0, 0.0, 0.0], [40.0, 0.0, 0.0]])
    >>> by_curve(PowerCurve(hover_w=180.0), TimedPath(np.array([0.0, 4.0, 24.0]), east, np.zeros(3))).energy_wh
    1.0
    """
    airspeed, climb = path.through_air(wind)
    drawn = curve.power(airspeed + head_wind, climb) * path.is_flown()
    return Consumption(path.times, drawn, drawn, drawn * curve.beyond(airspeed + head_wind))


def shortage(used: Interval, battery: Battery) -> NotEnoughBattery | None:
    """Return the refusal of this energy [Wh]; its upper bound may use the reserve."""
    left, most = (1 - energy_wh / battery.capacity_wh for energy_wh in (used.likely, used.high))
    rounding = 1e-9
    if left >= battery.reserve - rounding and most >= -rounding:
        return None
    takes = f"takes {used.likely:.1f} Wh" + (f" ({used.low:.1f} to {used.high:.1f})" if used.high > used.low else "")
    outcome = f"leaves {left:.1%} of {battery.capacity_wh:.4g} Wh" if left > 0 else f"not {battery.capacity_wh:.4g} Wh"
    outcome = outcome if left < battery.reserve - rounding else f"may take all of {battery.capacity_wh:.4g} Wh"
    needed = max(used.likely / (1 - battery.reserve), used.high)
    return NotEnoughBattery(
        f"expected a reserve of {battery.reserve:.0%} after landing, but the flight {takes}, {outcome}",
        hint=f"take a battery of {needed:.1f} Wh, a shorter route, another speed, or more flights (`plan --split`)",
        place="battery",
    )
