from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np

from ipoa_mission.autopilot.energy.curve import PowerCurve
from ipoa_mission.autopilot.energy.power import PowerModel, air_density, power
from ipoa_mission.errors import BadInput, MissionError
from ipoa_mission.geometry import Points, Vector
from ipoa_mission.wind import CALM, Wind

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
    """Full capacity [Wh], and the share to keep after landing."""

    capacity_wh: float
    reserve: float = 0.2

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
class Consumption:
    """The spans between `times` (n,) [s] draw `spans_w` (n-1,) [W], with a 90 % interval.

    `least_w` and `most_w` are `spans_w` if the uncertainty is unknown.
    """

    times: Vector
    spans_w: Vector
    least_w: Vector = field(default_factory=lambda: np.empty(0))
    most_w: Vector = field(default_factory=lambda: np.empty(0))

    def __post_init__(self) -> None:
        for name in ("least_w", "most_w"):
            if not len(getattr(self, name)):
                object.__setattr__(self, name, self.spans_w)

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
        return Interval(*(float(np.interp(time, self.times, used)) for used in self._used))

    @property
    def _used(self) -> tuple[Vector, Vector, Vector]:
        lasts = np.diff(self.times) / JOULES_PER_WATT_HOUR
        low, likely, high = (
            np.concatenate([[0.0], np.cumsum(drawn * lasts)]) for drawn in (self.least_w, self.spans_w, self.most_w)
        )
        return low, likely, high

    def widened(self, low: float, high: float) -> "Consumption":
        return replace(self, least_w=self.least_w * low, most_w=self.most_w * high)

    def lasting(self, least_s: float, most_s: float) -> "Consumption":
        """Return a copy for this duration interval [s]: both uncertainties combined."""
        lasts, taken = float(self.times[-1] - self.times[0]), self.between
        below, above = 1.0 - taken.low / taken.likely, taken.high / taken.likely - 1.0
        earlier, later = max(1.0 - least_s / lasts, 0.0), max(most_s / lasts - 1.0, 0.0)
        low = max(1.0 - np.hypot(below, earlier), 0.0) / max(1.0 - below, 1e-9)
        return self.widened(low, (1.0 + np.hypot(above, later)) / (1.0 + above))

    def left(self, battery: Battery) -> float:
        return 1 - self.energy_wh / battery.capacity_wh


def consumption(
    airframe: PowerModel,
    times: Vector,
    points: Points,
    speeds: Vector,
    altitude_amsl: float = 0.0,
    head_wind: float = 0.0,
    hover_w: float | None = None,
    wind: Wind = CALM,
) -> Consumption:
    """Compute the consumption of a track: `times` (n,) [s], `points` (n, 3) [m], `speeds` (n,) [m/s].

    Points are east, north, up; speeds over ground, with climb: derived from positions they would jump. `altitude_amsl`
    [m] is that of up = 0. `head_wind` [m/s] adds to `wind`, also in hover. Deceleration returns no energy. `hover_w`
    scales all power to the hover power measured at up = 0 [W].

    Raises:
        BadInput: the times do not increase, or the lengths differ.
    """
    times, points, speeds = _lasting(times, points, speeds)
    airspeed, climb = _through_air(times, points, speeds, wind)
    density = air_density(altitude_amsl + (points[:-1, 2] + points[1:, 2]) / 2)
    steady = power(airframe, airspeed + head_wind, climb, density)
    gained = np.maximum(np.diff(0.5 * airframe.mass_kg * speeds**2), 0.0)
    drawn = steady + gained / airframe.drive_efficiency / np.diff(times)
    if hover_w is not None:
        still = np.zeros(1)
        drawn *= hover_w / power(airframe, still, still, air_density(still + altitude_amsl))
    return Consumption(times, drawn)


def by_curve(
    curve: PowerCurve, times: Vector, points: Points, speeds: Vector, wind: Wind = CALM, head_wind: float = 0.0
) -> Consumption:
    """Compute the consumption by a measured curve; raise as `consumption`."""
    times, points, speeds = _lasting(times, points, speeds)
    airspeed, climb = _through_air(times, points, speeds, wind)
    drawn = curve.power(airspeed + head_wind, climb) * _flies(points)
    return Consumption(times, drawn, drawn, drawn * curve.beyond(airspeed + head_wind))


def hovering(hover_w: float, times: Vector, points: Points, speeds: Vector) -> Consumption:
    """Compute the consumption from the hover power [W] alone.

    >>> east = np.array([[0.0, 0.0, 0.0], [0.0, 0.0, 0.0], [40.0, 0.0, 0.0]])
    >>> hovering(180.0, np.array([0.0, 4.0, 24.0]), east, np.zeros(3)).energy_wh
    1.0
    """
    return by_curve(PowerCurve(hover_w), times, points, speeds)


def _flies(points: Points) -> Vector:
    """Return 1 for spans (n-1,) in the air, else 0; all 1 if it never moves."""
    away = np.linalg.norm(points - points[0], axis=1) > LIFTED_DISTANCE
    ahead = np.linalg.norm(points - points[-1], axis=1) > LIFTED_DISTANCE
    if not away.any():
        return np.ones(len(points) - 1)
    spans = np.arange(len(points) - 1)
    return np.asarray((spans >= np.argmax(away) - 1) & (spans <= np.flatnonzero(ahead)[-1]), float)


def _through_air(times: Vector, points: Points, speeds: Vector, wind: Wind) -> tuple[Vector, Vector]:
    """Return airspeeds and climb rates, (n-1,) [m/s]."""
    moved = np.diff(points, axis=0)
    climb, speed = moved[:, 2] / np.diff(times), (speeds[:-1] + speeds[1:]) / 2
    level = np.sqrt(np.maximum(speed**2 - climb**2, 0.0))
    if wind == CALM:
        return level, climb
    along = np.hypot(moved[:, 0], moved[:, 1])
    towards = moved[:, :2] / np.where(along > 0.0, along, np.inf)[:, None]
    blows = np.array([wind.towards(float(up)) for up in (points[:-1, 2] + points[1:, 2]) / 2])
    return np.hypot(*(level[:, None] * towards - blows).T), climb


def _lasting(times: Vector, points: Points, speeds: Vector) -> tuple[Vector, Points, Vector]:
    if not len(times) == len(points) == len(speeds) or not (np.diff(times) >= 0).all() or not times[-1] > times[0]:
        raise BadInput("expected times, speeds and points of one length, and increasing times", place="track")
    lasting = np.concatenate([np.diff(times) > 0, [True]])
    return times[lasting], points[lasting], speeds[lasting]


def shortage(used: Interval, battery: Battery) -> NotEnoughBattery | None:
    """Return the refusal of this energy [Wh]; its upper bound may use the reserve."""
    left, most = (1 - taken / battery.capacity_wh for taken in (used.likely, used.high))
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
