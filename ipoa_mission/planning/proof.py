"""Prove that a path keeps its limits: lower bounds of distances, exact for legs."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from ipoa_mission.geometry import Points, Vector, as_place, climb_angles, place_words
from ipoa_mission.planning.path_problem import PathTask
from ipoa_mission.planning.spline import Spline
from ipoa_mission.scenario.path_limits import Limits
from ipoa_mission.world.airspace import Clearance

CHORD = 5e-4  # of a curve from its chords [m]
TOUCHING = 1e-3  # of a bound [m]
ROUNDING = 1e-9  # [m per parameter]


@dataclass(frozen=True)
class Check:
    limit: str
    nearest: Clearance
    required: float
    at_most: bool = False
    unit: str = "m"

    @property
    def slack(self) -> float:
        return self.required - self.nearest.distance if self.at_most else self.nearest.distance - self.required

    @property
    def is_kept(self) -> bool:
        """Return whether the limit is kept, to a millimeter (or 0.001 degree)."""
        return self.slack >= -TOUCHING

    @property
    def about(self) -> dict[str, object]:
        return {"limit": self.limit, "near": self.nearest.what}

    def words(self) -> str:
        where = place_words(self.nearest.place)
        if self.limit == "bounds" and self.slack < 0:
            return f"{-self.nearest.distance:.2f} m beyond {self.nearest.what} {where}"
        if self.limit == "obstacles" and self.nearest.distance < 0:
            return f"{-self.nearest.distance:.2f} m inside {self.nearest.what} {where}"
        if self.limit == "ground" and self.nearest.distance < 0:
            return f"{-self.nearest.distance:.2f} m under the ground {where}"
        bound = "at most" if self.at_most else "at least"
        measure = {
            "obstacles": f"from {self.nearest.what}",
            "bounds": f"inside {self.nearest.what}",
            "ground": "above the ground",
            "ceiling": "above the ground",
        }
        measured = f"{self.nearest.distance:.2f} {self.unit} {measure.get(self.limit, self.nearest.what)}"
        return f"{measured} {where}, {bound} {self.required:.2f} {self.unit} required"


@dataclass(frozen=True)
class Proof:
    checks: tuple[Check, ...]

    @property
    def is_proved(self) -> bool:
        return all(check.is_kept for check in self.checks)

    @property
    def worst(self) -> Check:
        return min(self.checks, key=lambda check: check.slack)

    @property
    def clearance(self) -> Clearance:
        solid = [check.nearest for check in self.checks if check.limit in ("obstacles", "ground")]
        return min(solid, key=lambda clearance: clearance.distance)

    def words(self) -> str:
        return self.worst.words()


def prove(legs: Points, task: PathTask, chord_error: float = 0.0, spare: float = np.inf) -> Proof:
    """Prove the limits of the task for the straight legs between waypoints (n, 3), exactly.

    With `chord_error` [m] the legs represent a path within that distance. A clearance of `spare` [m] more than required
    is not computed further.
    """
    return Proof(tuple(_leg_checks(legs, task, chord_error, spare)))


def doubtful_legs(points: Points, task: PathTask) -> NDArray[np.intp]:
    """Return the legs between points (n, 3) that may break a limit, by quick bounds."""
    legs = points[:-1], points[1:]
    airspace = task.airspace
    limits = task.limits
    distance = limits.obstacle_distance + TOUCHING
    height = limits.height_above_ground + TOUCHING
    doubtful = airspace.legs_clearance(*legs, distance)[0] < distance
    doubtful |= airspace.terrain.legs_height(*legs, height) < height
    doubtful |= airspace.bounds.legs_margin(points) < TOUCHING
    angles = climb_angles(points)
    doubtful |= (angles > limits.climb_angle) | (-angles > limits.descent_angle)
    return np.flatnonzero(doubtful | np.isfinite(limits.ceiling_above_ground))


def unproved_legs(points: Points, task: PathTask) -> Iterator[int]:
    """Yield unproved legs between points (n, 3)."""
    for leg in doubtful_legs(points, task).tolist():
        if not all(check.is_kept for check in _leg_checks(points[leg : leg + 2], task, chord_error=0.0, spare=0.0)):
            yield leg


def prove_curve(curve: Spline, task: PathTask) -> Proof:
    """Prove the limits for a curve: lower bounds, at most 2 mm less than exact."""
    tolerance = CHORD / (1 + task.airspace.terrain.steepness)
    u = curve.chords(tolerance)
    legs = curve.points(u)
    velocity = curve.points(u, order=1)
    steepness = _steepness(velocity, curve.points(u[:-1], order=2), np.diff(u))
    return Proof(tuple(_checks(legs, task, steepness, tolerance, np.inf)))


def _leg_checks(legs: Points, task: PathTask, chord_error: float, spare: float) -> Iterator[Check]:
    angles = climb_angles(legs)
    return _checks(legs, task, (angles, -angles), chord_error, spare)


def _checks(
    legs: Points, task: PathTask, steepness: tuple[Vector, Vector], chord_error: float, spare: float
) -> Iterator[Check]:
    """`steepness`: angles of climb and descent, (n-1,) each [rad]."""
    airspace = task.airspace
    limits = task.limits
    if airspace.obstacles:
        clearance = airspace.obstacle_clearance(legs, within=limits.obstacle_distance + chord_error + spare)
        yield Check("obstacles", clearance.minus(chord_error), limits.obstacle_distance)
    yield Check("bounds", airspace.bounds_margin(legs, within=chord_error + spare).minus(chord_error), 0.0)
    yield from prove_heights(legs, task, chord_error, spare)
    climbs, descents = steepness
    for limit, angles, most in (("climb", climbs, limits.climb_angle), ("descent", descents, limits.descent_angle)):
        if np.isfinite(most):
            steepest = int(np.argmax(angles))
            angle = float(np.degrees(angles[steepest]))
            clearance = Clearance(angle, as_place(legs[steepest]), f"of {limit}", steepest)
            yield Check(limit, clearance, float(np.degrees(most)), at_most=True, unit="deg")


def prove_heights(legs: Points, task: PathTask, chord_error: float = 0.0, spare: float = np.inf) -> Iterator[Check]:
    """Prove ground and ceiling for straight legs (n, 3); `chord_error` and `spare` as in `prove`."""
    yield from prove_ground(legs, task, chord_error, spare)
    if np.isfinite(task.limits.ceiling_above_ground):
        vertical = chord_error * (1 + task.airspace.terrain.steepness)
        reached = task.airspace.height_reached(legs)
        yield Check("ceiling", reached.minus(-vertical), task.limits.ceiling_above_ground, at_most=True)


def prove_ground(legs: Points, task: PathTask, chord_error: float = 0.0, spare: float = np.inf) -> Iterator[Check]:
    airspace = task.airspace
    limits = task.limits
    vertical = chord_error * (1 + airspace.terrain.steepness)
    heights: dict[float, Clearance] = {}
    for required, run, first_leg in _runs(legs, limits, chord_error):
        clearance = airspace.terrain_clearance(run, within=required + vertical + spare)
        leg = first_leg + clearance.leg
        clearance = Clearance(clearance.distance - vertical, clearance.place, clearance.what, leg)
        heights[required] = min(heights.get(required, clearance), clearance, key=lambda least: least.distance)
    yield from (Check("ground", clearance, required) for required, clearance in heights.items())


def _steepness(velocity: Points, bend: Points, steps: Vector) -> tuple[Vector, Vector]:
    """Return upper bounds of climb and descent angles on each piece of a curve, (k-1,) each [rad].

    `velocity` (k, 3) and `bend` (k-1, 3) are at their begins. If all three Bézier points of a velocity go ahead, the
    angle is at most that of the steepest.
    """
    vectors = np.stack([velocity[:-1], velocity[:-1] + bend * steps[:, None] / 2, velocity[1:]], axis=1)
    level = vectors[:, :, :2].sum(axis=1)
    level /= np.maximum(np.linalg.norm(level, axis=1), 1e-300)[:, None]
    ahead = np.einsum("kij,kj->ki", vectors[:, :, :2], level)
    ahead[(ahead < 0).any(axis=1)] = 0.0
    rise = np.where(np.abs(vectors[:, :, 2]) > ROUNDING, vectors[:, :, 2], 0.0)
    return np.arctan2(rise, ahead).max(axis=1), np.arctan2(-rise, ahead).max(axis=1)


def _runs(legs: Points, limits: Limits, chord_error: float) -> Iterator[tuple[float, Points, int]]:
    """Yield runs of legs cut at low zones: required height, polyline, index of its first leg (at most two off)."""
    if not limits.low_zones:
        yield limits.height_above_ground, legs, 0
        return
    limits = replace(
        limits, low_zones=tuple(replace(z, radius=max(z.radius - chord_error, 0.0)) for z in limits.low_zones)
    )
    cuts = [(np.arange(len(legs)), np.zeros(len(legs)))]
    for zone in limits.low_zones:
        step = np.diff(legs[:, :2], axis=0)
        away = legs[:-1, :2] - (zone.east, zone.north)
        square = (step**2).sum(axis=1)
        half = (step * away).sum(axis=1)
        root = np.sqrt(np.maximum(half**2 - square * ((away**2).sum(axis=1) - zone.radius**2), 0.0))
        for side in (-root, root):
            fraction = np.divide(side - half, square, out=np.zeros_like(half), where=square > 0)
            inside = (fraction > 0) & (fraction < 1)
            cuts.append((np.nonzero(inside)[0], fraction[inside]))
    leg, fraction = (np.concatenate(column) for column in zip(*cuts, strict=True))
    order = np.lexsort((fraction, leg))
    leg, fraction = leg[order], fraction[order]
    ends = legs[np.minimum(leg + 1, len(legs) - 1)]
    points = legs[leg] + fraction[:, None] * (ends - legs[leg])
    required = limits.required_height((points[:-1] + points[1:]) / 2)
    starts = np.concatenate([[0], np.nonzero(np.diff(required))[0] + 1, [len(required)]])
    for first, last in pairwise(starts.tolist()):
        yield float(required[first]), points[first : last + 1], int(leg[first])
