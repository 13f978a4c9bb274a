"""The energy of a flight along a track, and the battery that must hold it with its reserve."""

from dataclasses import dataclass

import numpy as np

from ipoa_mission.errors import BadInput, MissionError
from ipoa_mission.geometry import Points, Vector
from ipoa_mission.vehicles.energy.power import PowerModel, air_density, power

JOULES_A_WATT_HOUR = 3600.0
LIFTED = 0.1  # who is so far from where he began does not stand any more [m]


class NotEnoughBattery(MissionError):
    """The flight would come home with less than the reserve, or not at all."""


@dataclass(frozen=True)
class Battery:
    """A battery: what it holds when full [Wh], and the share of it that must be left after landing."""

    capacity_wh: float
    reserve: float = 0.2

    def __post_init__(self) -> None:
        if not self.capacity_wh > 0 or not 0 <= self.reserve < 1:
            raise BadInput(
                "battery: expected a capacity of more than nothing and a reserve from 0 to below 1, "
                f"not {self.capacity_wh:g} Wh and {self.reserve:g}"
            )


@dataclass(frozen=True)
class Consumption:
    """What a flight takes: all of it [Wh], mean and highest power [W], and the power of each span (n-1,) [W]."""

    energy_wh: float
    mean_w: float
    peak_w: float
    spans_w: Vector

    def __str__(self) -> str:
        return f"{self.energy_wh:.1f} Wh, {self.mean_w:.0f} W on average"

    def left(self, battery: Battery) -> float:
        """The share of the battery that is left after the flight; negative if it is not enough."""
        return 1 - self.energy_wh / battery.capacity_wh


def consumption(
    airframe: PowerModel,
    times: Vector,
    points: Points,
    speeds: Vector,
    altitude_amsl: float = 0.0,
    head_wind: float = 0.0,
    hover_w: float | None = None,
) -> Consumption:
    """What flying along a track takes: at `times` (n,) [s] it passes `points` (n, 3) [m] with `speeds` (n,) [m/s].

    Points are east, north, up; speeds are over ground, climb included. `altitude_amsl` is that of up = 0 (the air is
    thinner higher up); `head_wind` [m/s] blows against the flight all the way, hovering too. Speeding up takes its
    kinetic energy; slowing down gives nothing back. Speeds are not taken from the points: predictions and logs have
    small jumps in position, and power grows with the cube of speed. `hover_w` [W], where it was measured, is what
    hovering at up = 0 takes: all power grows or shrinks with it.

    Raises:
        BadInput: the times do not grow, or are not as many as the points and speeds.
    """
    times, points, speeds = _lasting(times, points, speeds)
    spans = np.diff(times)
    speed, climb = (speeds[:-1] + speeds[1:]) / 2, np.diff(points[:, 2]) / spans
    level = np.sqrt(np.maximum(speed**2 - climb**2, 0.0))
    density = air_density(altitude_amsl + (points[:-1, 2] + points[1:, 2]) / 2)
    steady = power(airframe, level + head_wind, climb, density)
    gained = np.maximum(np.diff(0.5 * airframe.mass_kg * speeds**2), 0.0)
    drawn = steady + gained / airframe.drive_efficiency / spans
    if hover_w is not None:
        still = np.zeros(1)
        drawn *= hover_w / power(airframe, still, still, air_density(still + altitude_amsl))
    return _consumed(times, drawn)


def hovering(hover_w: float, times: Vector, points: Points, speeds: Vector) -> Consumption:
    """What the same track takes of a vehicle of which no more is known than its power in hover [W], once it moves.

    >>> east = np.array([[0.0, 0.0, 0.0], [0.0, 0.0, 0.0], [40.0, 0.0, 0.0]])
    >>> hovering(180.0, np.array([0.0, 4.0, 24.0]), east, np.zeros(3)).energy_wh
    1.0

    Raises:
        BadInput: as of `consumption`.
    """
    times, points, _ = _lasting(times, points, speeds)
    away = np.linalg.norm(points - points[0], axis=1) > LIFTED
    lifted = np.argmax(away) - 1 if away.any() else 0
    return _consumed(times, np.where(np.arange(len(times) - 1) >= lifted, hover_w, 0.0))


def _lasting(times: Vector, points: Points, speeds: Vector) -> tuple[Vector, Points, Vector]:
    """The track without what takes no time."""
    if not len(times) == len(points) == len(speeds) or not (np.diff(times) >= 0).all() or not times[-1] > times[0]:
        raise BadInput("track: expected as many times and speeds as points, and times that grow")
    lasting = np.concatenate([np.diff(times) > 0, [True]])
    return times[lasting], points[lasting], speeds[lasting]


def _consumed(times: Vector, drawn: Vector) -> Consumption:
    joules = float(drawn @ np.diff(times))
    return Consumption(joules / JOULES_A_WATT_HOUR, joules / float(times[-1] - times[0]), float(drawn.max()), drawn)


def expect_reserve(used: Consumption, battery: Battery) -> None:
    """Refuse a flight after which less than the reserve is left.

    Raises:
        NotEnoughBattery: saying what the flight needs and what is left.
    """
    left = used.left(battery)
    if left < battery.reserve - 1e-9:  # a rounding error is no shortage
        needed = used.energy_wh / (1 - battery.reserve)
        outcome = f"leaves {left:.1%} of {battery.capacity_wh:g} Wh" if left > 0 else f"not {battery.capacity_wh:g} Wh"
        raise NotEnoughBattery(
            f"battery: expected a reserve of {battery.reserve:.0%} after landing, "
            f"but the flight takes {used.energy_wh:.1f} Wh, {outcome}",
            hint=f"a battery of {needed:.1f} Wh would do; or fly a shorter way, or at another speed",
        )
