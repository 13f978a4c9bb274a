"""Loops in which a route gains height where it is too steep: turns of a sheared helix on an ellipse."""

from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ipoa_mission.geometry import Points, Vector, leg_lengths
from ipoa_mission.planning.problem import PreparedProblem, via_indices


class LoopShape(NamedTuple):
    turns: tuple[int, ...] = (1, 2, 3, 4, 5, 6, 8, 10, 13, 17, 22, 30, 40, 55)
    axis_ratios: tuple[float, ...] = (1.0, 2.0, 4.0, 8.0, 16.0)  # of the ellipse
    sides: int = 16  # of the ellipse
    levels: int = 9
    lift_slope_share: float = 0.97  # of the steepest
    slope_share: float = 0.85  # of the steepest
    control_points_per_turn: int = 12
    slope_factor: float = 1.3  # times the limit; less steep pieces the polish mends
    shortest_detour: float = 0.5  # shorter ones need no loop [m]


LOOPS = LoopShape()


def with_loops(way: Points, inner: int, problem: PreparedProblem, step: float) -> tuple[Points, Vector]:
    """Return the route (k, 3) with loops where too steep for the polish, and control points on each leg."""
    way = _without_detours(way, problem)
    pieces = [way[:1]]
    loops = [np.zeros(0, bool)]
    for first, last in _runs(way):
        run = way[first : last + 1]
        climb = _climb_in_loops(run, step, problem)
        if climb is None:
            pieces.append(run[1:])
            loops.append(np.zeros(last - first, bool))
        else:
            pieces += climb
            loops.append(np.repeat((False, True, False), [len(piece) for piece in climb]))
    guide = np.vstack(pieces)
    turning = np.concatenate(loops)
    guide[-1] = way[-1]
    legs = leg_lengths(guide)
    straight = max(float(legs[~turning].sum()), LOOPS.shortest_detour)
    return guide, np.where(turning, LOOPS.control_points_per_turn / LOOPS.sides, inner * legs / straight)


def _climb_in_loops(run: Points, step: float, problem: PreparedProblem) -> tuple[Points, Points, Points] | None:
    """Return a run before, in and after the shortest loops for its steep pieces."""
    steep = np.nonzero(_too_steep(run, problem))[0]
    rises = np.diff(run[:, 2])
    height = float(rises[steep].sum())
    if abs(height) <= 2 * step:
        return None
    level = run.copy()
    level[1:, 2] -= np.cumsum(np.where(np.isin(np.arange(len(rises)), steep), rises, 0))
    climb = None
    for k in np.unique(steep[[0, len(steep) // 2, -1]]):
        lifted = level.copy()
        lifted[k + 1 :, 2] += height
        if not _free(lifted[: k + 1], problem) or not _free(lifted[k + 1 :], problem):
            continue
        turns = _loops(lifted[k], lifted[k] + (0.0, 0.0, height), (lifted[k + 1] - lifted[k])[:2], problem)
        if turns is not None and (climb is None or len(turns) < len(climb[1])):
            climb = lifted[1 : k + 1], turns, lifted[k + 1 :]
    return climb


def lift(way: Points, problem: PreparedProblem, step: float) -> tuple[Points, float]:
    """Return the route (k, 3) lifted to keep the slope limits, and the longest detour it needs.

    A detour is a share of the distance of the climb; infinite if the lifted route is not free.
    """
    lifted = way.copy()
    longest = 0.0
    climb_slope = LOOPS.lift_slope_share * problem.rules.climb
    descent_slope = LOOPS.lift_slope_share * problem.rules.descent
    traveled = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(way[:, :2], axis=0).T))])
    for first, last in pairwise([0, *via_indices(way, problem.task.places[1:-1]), len(way) - 1]):
        along = traveled[first : last + 1] - traveled[first]
        height = way[first : last + 1, 2]
        climb, descent = climb_slope * along, descent_slope * along
        after = np.maximum.accumulate(height + descent) - descent  # no lower than a descent from behind
        before = np.maximum.accumulate((after - climb)[::-1])[::-1]  # and than a climb to what is ahead
        lifted[first + 1 : last, 2] = (before + climb)[1:-1]
        for missing, slope, within in (
            (before[0] - height[0], problem.rules.climb, along[np.argmax(after - climb)]),
            (after[-1] - height[-1], problem.rules.descent, along[-1] - along[np.argmax(height + descent)]),
        ):
            if missing > 2 * step:
                longest = max(longest, float(missing / slope / max(within, LOOPS.shortest_detour)))
    return lifted, longest if _free(lifted, problem) else np.inf


def _without_detours(way: Points, problem: PreparedProblem) -> Points:
    """Return the route without nodes next to places, which may be behind them."""
    stops = {tuple(place) for place in problem.task.places}
    kept = np.ones(len(way), bool)
    for k in range(1, len(way) - 1):
        beside = tuple(way[k - 1]) in stops or tuple(way[k + 1]) in stops
        if beside and tuple(way[k]) not in stops and kept[k - 1]:
            kept[k] = not _free(way[[k - 1, k + 1]], problem)
    return way[kept]


def _runs(way: Points) -> list[tuple[int, int]]:
    up = np.sign(np.diff(way[:, 2]))
    for i in range(1, len(up)):
        up[i] = up[i] or up[i - 1]
    return list(pairwise([0, *(np.nonzero(up[:-1] * up[1:] < 0)[0] + 1).tolist(), len(up)]))


def _too_steep(way: Points, problem: PreparedProblem) -> NDArray[np.bool_]:
    step = np.diff(way, axis=0)
    rules = problem.rules
    level = LOOPS.slope_factor * np.hypot(step[:, 0], step[:, 1])
    return np.asarray(np.maximum(step[:, 2] / rules.climb, -step[:, 2] / rules.descent) > level)


def _free(way: Points, problem: PreparedProblem) -> bool:
    spots = np.vstack([way[1:-1], (way[1:] + way[:-1]) / 2])
    return bool((problem.survey(spots)[0] >= -0.5 * problem.rules.clearance).all())


def _loops(a: Vector, b: Vector, ahead: Vector, problem: PreparedProblem) -> Points | None:
    """Return loops from a to b, without a, (k, 3), best aligned with `ahead` (2,)."""
    rise = float(b[2] - a[2])
    needed = max(rise / problem.rules.climb, -rise / problem.rules.descent) / LOOPS.slope_share
    if needed < LOOPS.shortest_detour:
        return None
    for turns in LOOPS.turns:
        shapes = _ellipses(needed / turns)
        slack = _room(shapes, a, b, problem)
        begins = shapes[:, 1] - shapes[:, -1]
        aligned = begins @ ahead / np.linalg.norm(begins, axis=1)
        for k in np.argsort(-aligned):
            if slack[k] >= max(0.5 * slack.max(), 0.0) and _room(_closely(shapes[k], problem), a, b, problem)[0] >= 0:
                share = np.arange(1, LOOPS.sides * turns + 1) / (LOOPS.sides * turns)
                points = a + share[:, None] * (b - a)
                points[:, :2] += np.tile(np.roll(shapes[k], -1, axis=0), (turns, 1))
                return points
    return None


def _room(shapes: NDArray[np.float64], a: Vector, b: Vector, problem: PreparedProblem) -> Vector:
    """Return the least slack of shapes (s, k, 2) around places from a to b, (s,) [m]."""
    spots = a + np.linspace(0.0, 1.0, LOOPS.levels)[:, None] * (b - a)
    around = np.empty((len(shapes), LOOPS.levels, shapes.shape[1], 3))
    around[..., :2] = spots[:, None, :2] + shapes[:, None]
    around[..., 2] = spots[:, None, 2]
    return np.asarray(problem.survey(around.reshape(-1, 3))[0].reshape(len(shapes), -1).min(axis=1))


def _closely(shape: NDArray[np.float64], problem: PreparedProblem) -> NDArray[np.float64]:
    """Return a shape (k, 2) and the line to it, sampled finely, (1, m, 2)."""
    step = max(problem.limits.obstacle_distance, 0.1)
    along = np.roll(shape, -1, axis=0) - shape
    away = float(np.linalg.norm(shape[0]))
    side = float(np.linalg.norm(along, axis=1).max())
    shares = np.linspace(0.0, 1.0, int(np.clip(side / step, 1, 50)), endpoint=False)[:, None, None]
    outline = (shape + shares * along).reshape(-1, 2)
    line = np.linspace(0.0, 1.0, int(np.clip(away / step, 1, 200)))[:, None] * shape[0]
    return np.vstack([outline, line])[None]


def _ellipses(length: float) -> NDArray[np.float64]:
    """Return ellipses through or around the origin, (s, SIDES, 2), both ways."""
    angle = 2 * np.pi * np.arange(LOOPS.sides) / LOOPS.sides
    ellipses = []
    for longer in LOOPS.axis_ratios:
        for turned in np.pi * np.arange(8 if longer > 1 else 1) / 8:
            axes = np.array([(np.cos(turned), np.sin(turned)), (-np.sin(turned), np.cos(turned))])
            corners = np.column_stack([longer * np.cos(angle), np.sin(angle)]) @ axes
            corners *= length / np.linalg.norm(corners - np.roll(corners, 1, axis=0), axis=1).sum()
            for start in range(0, LOOPS.sides, 2):
                shape = np.roll(corners, -start, axis=0)
                for through in (1.0, 0.0):
                    ellipses += [shape - through * shape[0], (shape - through * shape[0])[-np.arange(LOOPS.sides)]]
    return np.array(ellipses)
