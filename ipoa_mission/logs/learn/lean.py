"""How a vehicle leaned in level flight against the air: a witness of its drag that needs no top speed and no calm.

A steady lean holds what the air takes: g tan(lean) less the acceleration is the drag of the model, times a factor, at
the velocity less the wind. Factor, wind and a lean that is measured askew are fitted to a whole flight.
"""

from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation

from ipoa_mission.errors import LogUseless
from ipoa_mission.forecast.timing.flight_model import FlightModel
from ipoa_mission.geometry import GRAVITY, Points, Vector
from ipoa_mission.logs.learn.logged_track import CLEAR, LoggedTrack
from ipoa_mission.vehicles.autopilot import Autopilot

EVERY, SMOOTHED, ALONE = 0.2, 5, 10  # samples: their distance [s], how many are averaged, one in how many is its own
GAP = 2.0  # between two attitudes [s]: what is between them is not known
STEADY = 1.0  # the most climb [m/s] and acceleration [m/s^2]
FAST, LEAST_S = 2.5, 5.0  # below this speed [m/s] drag is no more than the lean's own error; so long above it
HIGH = 0.6  # of the greatest height: below, the wind is another
AS_A_MODEL = 0.05  # standard deviation of ln drag from flight to flight: it is no mere factor
#: Standard deviations of what is believed before: ln drag, wind north and east [m/s], askew ahead and right [m/s^2].
BELIEVED = np.array([0.7, 3.0, 3.0, 0.2, 0.2])


@dataclass(frozen=True)
class Leaned:
    """The logarithm of the drag as a multiple of the simulated vehicle's, and its standard deviation.

    And the wind, towards the north and the east, and how sure it is [m/s].
    """

    drag: float
    deviation: float
    wind: tuple[float, float]
    wind_deviation: float


def drag_by_lean(attitude: Points, track: LoggedTrack, autopilot: Autopilot) -> Leaned:
    """What the lean tells of drag and wind.

    `attitude` (n, 4) is as in `Measured`.

    Raises:
        MissionError: there are no attitudes, or too little fast level flight.
    """
    if len(attitude) < 2 or np.ptp(attitude[:, 0]) < LEAST_S:
        raise LogUseless("it has no attitudes")
    times = np.arange(attitude[0, 0], attitude[-1, 0], EVERY)
    angles = np.column_stack([np.interp(times, attitude[:, 0], np.unwrap(angle)) for angle in attitude[:, :0:-1].T])
    axes = Rotation.from_euler("ZYX", angles).as_matrix()  # columns ahead, right and down, each north, east, down
    heights, velocity = track.at(times)
    gained = _smoothed(np.gradient(velocity[:, :2], EVERY, axis=0))
    pull = _smoothed(-GRAVITY * axes[:, :2, 2] / axes[:, 2, 2, None])
    steady = (np.abs(gained).max(axis=1) < STEADY) & (np.abs(velocity[:, 2]) < STEADY)
    high = max(CLEAR, HIGH * float(track.heights.max()))
    steady &= (heights > high) & (axes[:, 2, 2] > 0.0)
    steady &= np.diff(attitude[:, 0], append=np.inf)[np.searchsorted(attitude[:, 0], times, side="right") - 1] < GAP
    steady[:SMOOTHED] = steady[-SMOOTHED:] = False
    fast_s = (np.hypot(*velocity[steady, :2].T) > FAST).sum() * EVERY
    if fast_s < LEAST_S:
        raise LogUseless(f"it flies level at more than {FAST:g} m/s for {fast_s:.0f} s")
    velocity, axes, held = velocity[steady], axes[steady], (pull - gained)[steady]
    airframe = autopilot.part(FlightModel).airframe(track.home_altitude)

    def misfit(change: Vector, noise: float) -> Vector:
        slowed = np.exp(change[0]) * airframe.slowing(velocity - [change[1], change[2], 0.0], axes)[:, :2]
        wrong = slowed + axes[:, :2, :2] @ change[3:] - held
        return np.concatenate([wrong.ravel() / noise / np.sqrt(ALONE), change / BELIEVED])

    noise = 0.2
    for _ in range(2):
        fitted = least_squares(misfit, np.zeros(5), args=(noise,))
        noise *= float(np.std(fitted.fun[:-5])) * np.sqrt(ALONE)
    variances = np.diag(np.linalg.inv(fitted.jac.T @ fitted.jac))
    drag, north, east = (float(number) for number in fitted.x[:3])
    deviation = float(np.sqrt(variances[0] + AS_A_MODEL**2))
    return Leaned(drag, deviation, (north, east), float(np.sqrt(variances[1:3].max())))


def _smoothed(values: Points) -> Points:
    return np.column_stack([np.convolve(column, np.ones(SMOOTHED) / SMOOTHED, "same") for column in values.T])
