"""Energy of a flight by a measured power curve, by momentum theory, or by its hover power."""

from dataclasses import dataclass, replace

import numpy as np

from ipoa_mission.autopilot.energy import Battery, Interval, PowerCurve, PowerModel, air_density, power
from ipoa_mission.autopilot.learned import LearnedVehicle
from ipoa_mission.forecast.timing.track import Track
from ipoa_mission.geometry import Points, Vector
from ipoa_mission.scenario import Scenario
from ipoa_mission.wind import CALM, Wind

JOULES_PER_WATT_HOUR = 3600.0
LIFTED_DISTANCE = 0.1  # from the first place to lift-off [m]


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
        lasts_s = float(self.times[-1] - self.times[0])
        energy = self.between
        below = 1.0 - energy.low / energy.likely
        above = energy.high / energy.likely - 1.0
        earlier = max(1.0 - least_s / lasts_s, 0.0)
        later = max(most_s / lasts_s - 1.0, 0.0)
        low = max(1.0 - np.hypot(below, earlier), 0.0) / max(1.0 - below, 1e-9)
        return self.widened(low, (1.0 + np.hypot(above, later)) / (1.0 + above))


def through_air(track: Track, wind: Wind) -> tuple[Vector, Vector]:
    """Return airspeeds and climb rates, (n-1,) [m/s]; `track.speeds` count, as those of its places would jump."""
    moved = np.diff(track.points, axis=0)
    climb = moved[:, 2] / np.diff(track.times)
    speed = (track.speeds[:-1] + track.speeds[1:]) / 2
    horizontal = np.sqrt(np.maximum(speed**2 - climb**2, 0.0))
    if wind == CALM:
        return horizontal, climb
    along = np.hypot(moved[:, 0], moved[:, 1])
    towards = moved[:, :2] / np.where(along > 0.0, along, np.inf)[:, None]
    blows = np.array([wind.velocity(float(up)) for up in _middle_heights(track)])
    return np.hypot(*(horizontal[:, None] * towards - blows).T), climb


def _middle_heights(track: Track) -> Vector:
    return (track.points[:-1, 2] + track.points[1:, 2]) / 2


def is_flown(points: Points) -> Vector:
    """Return 1 for spans (n-1,) in the air, else 0; all 1 if it never moves."""
    away = np.linalg.norm(points - points[0], axis=1) > LIFTED_DISTANCE
    ahead = np.linalg.norm(points - points[-1], axis=1) > LIFTED_DISTANCE
    if not away.any():
        return np.ones(len(points) - 1)
    spans = np.arange(len(points) - 1)
    return np.asarray((spans >= np.argmax(away) - 1) & (spans <= np.flatnonzero(ahead)[-1]), float)


def by_momentum(
    airframe: PowerModel, track: Track, altitude_amsl: float = 0.0, wind: Wind = CALM, head_wind: float = 0.0
) -> Consumption:
    """Compute the consumption by momentum theory; `altitude_amsl` [m] is that of up = 0.

    `head_wind` [m/s] adds to `wind`, also in hover. Deceleration returns no energy.
    """
    airspeed, climb = through_air(track, wind)
    density = air_density(altitude_amsl + _middle_heights(track))
    steady = power(airframe, airspeed + head_wind, climb, density)
    gained = np.maximum(np.diff(0.5 * airframe.mass_kg * track.speeds**2), 0.0)
    drawn = steady + gained / airframe.drive_efficiency / np.diff(track.times)
    return Consumption(track.times, drawn, drawn, drawn)


def by_curve(curve: PowerCurve, track: Track, wind: Wind = CALM, head_wind: float = 0.0) -> Consumption:
    """Compute the consumption by a measured curve, or by the hover power alone.

    >>> east = np.array([[0.0, 0.0, 0.0], [0.0, 0.0, 0.0], [40.0, 0.0, 0.0]])
    >>> by_curve(PowerCurve(hover_w=180.0), Track(np.array([0.0, 4.0, 24.0]), east, np.zeros(3))).energy_wh
    1.0
    """
    airspeed, climb = through_air(track, wind)
    drawn = curve.power(airspeed + head_wind, climb) * is_flown(track.points)
    return Consumption(track.times, drawn, drawn, drawn * curve.beyond(airspeed + head_wind))


def flight_energy(
    scenario: Scenario | None, track: Track, learned: LearnedVehicle | None = None, wind: Wind = CALM
) -> Consumption | None:
    """Return a flight's energy; None without airframe and hover power. A repeated time counts once."""
    vehicle = None if scenario is None else scenario.vehicle
    learned = learned or (None if vehicle is None else vehicle.learned)
    head_wind = vehicle.battery.head_wind if vehicle is not None and vehicle.battery is not None else 0.0
    curve = curve_of(learned)
    hover_w = None if learned is None or learned.hover_power is None else learned.hover_power.value
    path = track.without_repeated_times()

    def consumed(against: float) -> Consumption | None:
        if curve is not None:
            return by_curve(curve, path, wind, against)
        if scenario is None or vehicle is None or vehicle.airframe is None:
            return None if hover_w is None else by_curve(PowerCurve(hover_w), path)
        airframe = vehicle.airframe.build()
        altitude = scenario.home.altitude_amsl
        modeled = by_momentum(airframe, path, altitude, wind, against)
        if hover_w is None:
            return modeled
        still = np.zeros(1)
        drawn = modeled.spans_w * (hover_w / power(airframe, still, still, air_density(still + altitude)))
        return Consumption(path.times, drawn, drawn, drawn)

    used = consumed(head_wind)
    if used is None:
        return None
    if wind.spread > 0.0 and (against := consumed(head_wind + wind.spread)) is not None:
        used = replace(used, most_w=against.most_w)
    return used.widened(*_share(learned))


def _share(learned: LearnedVehicle | None) -> tuple[float, float]:
    """Return actual over predicted energy, nine flights in ten (docs/lab/profiles.md)."""
    if learned is None or learned.hover_power is None:
        return 0.75, 1.4
    ratio = learned.energy_ratio
    return (0.85, 1.25) if ratio is None else (ratio.low, ratio.high)


def curve_of(learned: LearnedVehicle | None) -> PowerCurve | None:
    if learned is None or learned.hover_power is None or learned.airspeed is None:
        return None
    return PowerCurve(
        hover_w=learned.hover_power.value,
        square_w=learned.value("square_power", 0.0),
        cube_w=learned.value("cube_power", 0.0),
        climb_w=learned.value("climb_power", 0.0),
        descent_w=learned.value("descent_power", 0.0),
        fastest=learned.airspeed.value,
    )


def battery_of(scenario: Scenario | None) -> Battery | None:
    section = None if scenario is None else scenario.vehicle.battery
    return None if section is None else section.build()
