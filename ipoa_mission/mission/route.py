"""From the curve to waypoints: which places on it the vehicle is told to fly through.

The vehicle flies straight legs between waypoints, so resampling cuts corners: whatever is chosen here, the legs are
proved clear again, and the tolerance is tightened until they are.
"""

import math
from collections.abc import Callable

import numpy as np

from ipoa_mission.errors import MissionError
from ipoa_mission.geometry import Points, Vector
from ipoa_mission.planning.plan import Plan
from ipoa_mission.planning.proof import Check, prove
from ipoa_mission.planning.spline import Spline
from ipoa_mission.scenario import Scenario
from ipoa_mission.world.airspace import Airspace

PUSHES = 30  # rounds of moving waypoints aside
OVERSHOOT = 0.01  # a leg that is moved keeps so much more than it must [m]
SLOPE_STEP = 1e-3  # for the slope of the distance [m]


class NoRoute(MissionError):
    """No choice of waypoints keeps the required clearance on the straight legs between them."""


def choose_waypoints(plan: Plan, scenario: Scenario) -> Points:
    """Waypoints (k, 3) from start to goal whose straight legs keep the required clearance, as `scenario.route` asks.

    Raises:
        NoRoute: even the tightest sampling of the curve leaves a leg too close to something.
    """
    choose, step = _MODES[scenario.route.mode]
    width = step(scenario)
    for _ in range(6):
        waypoints = push_clear(choose(plan.curve, width), scenario)
        proof = prove(waypoints, scenario)
        if proof.holds:
            return waypoints
        width /= 2
    raise NoRoute(
        f"the legs between waypoints come too close: {proof.words()}",
        hint="plan with a larger safety_distance, or ask for a smaller route.tolerance or route.spacing",
    )


def push_clear(waypoints: Points, scenario: Scenario) -> Points:
    """Waypoints (k, 3) moved aside where a leg between them keeps too little clearance; the ends stay.

    A curve bends round what it avoids, so its chords cut in on that side: each breach pushes the ends of its leg
    outwards by what is missing, shared by their nearness to it. Where that does not help the legs stay as they are,
    and the proof that follows says so.
    """
    moved = waypoints.copy()
    for _ in range(PUSHES):
        clear = True
        for leg in range(len(moved) - 1):
            for check in prove(moved[leg : leg + 2], scenario).checks:
                if check.slack < 0 and check.limit in ("obstacles", "ground", "bounds"):
                    clear = False
                    _push(moved, leg, check, scenario.airspace)
        if clear:
            break
    return moved


def _push(waypoints: Points, leg: int, check: Check, airspace: Airspace) -> None:
    """Move the ends of one leg, in place, so that it keeps `check` where it was broken."""
    place = np.array(check.found.place)
    ahead = waypoints[leg + 1] - waypoints[leg]
    share = float(np.clip((place - waypoints[leg]) @ ahead / max(float(ahead @ ahead), 1e-12), 0, 1))
    weights = np.array([1 - share, share]) * [leg > 0, leg + 1 < len(waypoints) - 1]
    if not weights.any():
        return
    push = (OVERSHOOT - check.slack) * _outwards(place, check.limit, airspace)
    waypoints[leg : leg + 2] += weights[:, None] / (weights @ [1 - share, share]) * push


def _outwards(place: Vector, limit: str, airspace: Airspace) -> Vector:
    """The direction in which a limit is left fastest at a place: upwards from the ground, else the distance's slope."""
    if limit == "ground":
        return np.array([0.0, 0.0, 1.0])
    distance = airspace.obstacle_distance if limit == "obstacles" else airspace.bounds.margin
    around = place + SLOPE_STEP * np.vstack([np.eye(3), -np.eye(3)])
    values = distance(around)
    slope = np.asarray(values[:3] - values[3:])
    return slope / max(float(np.linalg.norm(slope)), 1e-12)


def every(curve: Spline, spacing: float) -> Points:
    """Waypoints along the curve, equally far apart and at most `spacing` [m] of arc, (k, 3): the paper's resampling."""
    return curve.sample(max(2, math.ceil(curve.length / spacing) + 1))


def corridor(curve: Spline, tolerance: float) -> Points:
    """The fewest waypoints on the curve whose straight legs stay within `tolerance` [m] of it, (k, 3).

    A shortest path over all pairs of samples that a straight leg may join (Imai and Iri 1986); among routes of equal
    number the one with the least sum of squared deviations is taken.
    """
    samples = curve.sample(min(240, max(20, math.ceil(curve.length / min(1.0, tolerance)) + 1)))
    last = len(samples) - 1
    legs, strain, before = np.full(last + 1, last + 1), np.full(last + 1, np.inf), np.zeros(last + 1, int)
    legs[0] = strain[0] = 0
    for i in range(last):
        deviation = _reachable(samples[i:], tolerance)
        j = i + 1 + np.flatnonzero(deviation <= tolerance)
        worn = strain[i] + deviation[j - i - 1] ** 2
        better = (legs[i] + 1 < legs[j]) | ((legs[i] + 1 == legs[j]) & (worn < strain[j]))
        legs[j[better]], strain[j[better]], before[j[better]] = legs[i] + 1, worn[better], i
    chosen = [last]
    while chosen[-1] > 0:
        chosen.append(int(before[chosen[-1]]))
    return samples[chosen[::-1]]


def _reachable(samples: Points, tolerance: float) -> Vector:
    """How far the samples in between leave the straight leg from the first sample to each later one [m].

    The search widens until no leg of the last widening fits: a curve that comes back later is not looked for.
    """
    width = 16
    while True:
        deviation = _deviations(samples[: width + 1])
        if width + 1 >= len(samples) or (deviation[width // 2 :] > tolerance).all():
            return deviation
        width *= 2


def _deviations(stretch: Points) -> Vector:
    """For each j the greatest distance of samples 0 to j from the leg between samples 0 and j, (n-1,) [m]."""
    spokes = stretch[1:] - stretch[0]
    squares = np.einsum("ij,ij->i", spokes, spokes)
    along = np.clip(spokes @ spokes.T / np.maximum(squares, 1e-12)[:, None], 0, 1)  # row: leg, column: sample
    gaps = np.linalg.norm(spokes[None, :, :] - along[:, :, None] * spokes[:, None, :], axis=2)
    return np.asarray(np.tril(gaps).max(axis=1))


_MODES: dict[str, tuple[Callable[[Spline, float], Points], Callable[[Scenario], float]]] = {
    "even": (every, lambda scenario: scenario.route.spacing),
    "corridor": (corridor, lambda scenario: scenario.route.tolerance),
}
