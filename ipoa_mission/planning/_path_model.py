"""Compiled polishing of one path: the model of its cost, and its minimization.

It is compiled without permission to reorder sums: plans depend on their last bits. Shipped machine code and numba must
give the same ones.
"""

# mypy: disable-error-code="no-untyped-def,misc"

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ipoa_mission.compiled import njit
from ipoa_mission.planning._places import _cell, _distance, _ground, _least_height
from ipoa_mission.planning.banded import solve_banded
from ipoa_mission.planning.obstacle_grid import FENCE, LEAST, LEVER


class Terms(NamedTuple):
    """First and second derivatives of the cost by the three coordinates of each node, or of each step."""

    slope: NDArray[np.float64]  # (n, 3)
    curvature: NDArray[np.float64]  # (n, 3, 3), lower triangles


class Bends(NamedTuple):
    """The turn and the climb at each node, and first and second derivatives of the cost by them, all (n, 2)."""

    angles: NDArray[np.float64]  # [rad]
    slope: NDArray[np.float64]
    curvature: NDArray[np.float64]


class Steps(NamedTuple):
    """Steps from each node to the next, all (n,), 0 for the last."""

    level: NDArray[np.float64]  # [m]
    leg: NDArray[np.float64]  # [m]
    east: NDArray[np.float64]  # per meter of horizontal length
    north: NDArray[np.float64]
    rise: NDArray[np.float64]  # per meter of length
    flat: NDArray[np.float64]  # per meter of length


class PathModel(NamedTuple):
    """The smoothed cost of a path, and its derivatives."""

    value: float
    bends: Bends
    by_node: Terms
    by_step: Terms
    mixed: NDArray[np.float64]  # (n, 3, 3), second derivatives by the step to each node and the step from it


@njit(inline="always")
def _add(terms, i, direction, slope, curvature):
    """Add a term of node or step i by its first and second derivative along `direction` (east, north, up)."""
    for a in range(3):
        terms.slope[i, a] += slope * direction[a]
        for b in range(a + 1):
            terms.curvature[i, a, b] += curvature * direction[a] * direction[b]


@njit(inline="always")
def _directions(steps, i):
    """Return the directions ahead of step i, to its left, and upwards at right angles to both."""
    east, north, rise, flat = steps.east[i], steps.north[i], steps.rise[i], steps.flat[i]
    return (flat * east, flat * north, rise), (-north, east, 0.0), (-rise * east, -rise * north, flat)


@njit(inline="always")
def _barrier(slack, smoothing, mean_leg):
    """Return cost, slope and curvature of a barrier: -log(slack / reach), smoothly zero at `reach`.

    It continues as the osculating parabola, at the stiffness of a broken limit.
    """
    t = slack / smoothing.reach
    if t >= 1.0:
        return 0.0, 0.0, 0.0
    near = max(t, math.sqrt(smoothing.barrier / smoothing.stiffness) / smoothing.reach)
    beyond = t - near
    slope = 2.0 - near - 1.0 / near
    curvature = 1.0 / near**2 - 1.0
    value = (2.0 - 0.5 * near) * near - 1.5 - math.log(near) + beyond * (slope + 0.5 * curvature * beyond)
    scale = smoothing.barrier * mean_leg
    return scale * value, scale * (slope + curvature * beyond) / smoothing.reach, scale * curvature / smoothing.reach**2


@njit(cache=True, error_model="numpy")
def _steps(nodes):
    n = len(nodes)
    steps = Steps(np.zeros(n), np.zeros(n), np.zeros(n), np.zeros(n), np.zeros(n), np.zeros(n))
    for i in range(n - 1):
        east = nodes[i + 1, 0] - nodes[i, 0]
        north = nodes[i + 1, 1] - nodes[i, 1]
        up = nodes[i + 1, 2] - nodes[i, 2]
        level = math.sqrt(east**2 + north**2) + 1e-9
        leg = math.sqrt(level**2 + up**2)
        steps.level[i] = level
        steps.leg[i] = leg
        steps.east[i] = east / level
        steps.north[i] = north / level
        steps.rise[i] = up / leg
        steps.flat[i] = level / leg
    return steps


@njit(cache=True, error_model="numpy")
def _position_terms(nodes, leg, threats, grid, rules, smoothing, mean_leg, by_node):
    """Add the cost of obstacles, ground and bounds; write the threat per meter to `threats` (n,)."""
    cells, first, listed, top, around, kind, shape, edges, raster, heights, lower, upper, _, low_zones = grid
    n = len(nodes)
    value = 0.0
    for i in range(n):
        x, y, z = nodes[i, 0], nodes[i, 1], nodes[i, 2]
        share = 0.5 * ((leg[i - 1] if i > 0 else 0.0) + leg[i])
        cell = _cell(cells, x, y)
        if z < top[cell] + smoothing.above + smoothing.reach:
            ground, east, north = _ground(raster, heights, x, y)
            below_ceiling = rules.ceiling - smoothing.above - (z - ground)
            above_ground = z - ground - _least_height(low_zones, rules.height + smoothing.above, x, y)
            for sign, slack in ((1.0, below_ceiling), (-1.0, above_ground)):
                barrier, slope, curvature = _barrier(slack, smoothing, mean_leg)
                if curvature > 0.0:
                    value += barrier
                    _add(by_node, i, (east, north, -1.0), sign * slope, curvature)
        for axis in range(3):
            slack = min(nodes[i, axis] - lower[axis], upper[axis] - nodes[i, axis]) - smoothing.aside
            barrier, slope, curvature = _barrier(slack, smoothing, mean_leg)
            if curvature > 0.0:
                inwards = -1.0 if 2.0 * nodes[i, axis] > lower[axis] + upper[axis] else 1.0
                value += barrier
                by_node.slope[i, axis] += inwards * slope
                by_node.curvature[i, axis, axis] += curvature
        for k in range(first[cell], first[cell + 1]):
            body = listed[k]
            if not around[body, 3] < z < around[body, 4]:
                continue
            if (x - around[body, 0]) ** 2 + (y - around[body, 1]) ** 2 > around[body, 2]:
                continue
            distance, east, north, up = _distance(kind, shape, edges, body, x, y, z)
            slack = distance
            hull = distance - rules.radius
            threatened = False
            if kind[body] != FENCE:
                slack -= rules.clearance
                threatened = hull < rules.d_safe
                if not threatened:  # a barrier from outside
                    slack = min(slack, hull - rules.d_safe)
            barrier, slope, curvature = _barrier(slack - smoothing.aside, smoothing, mean_leg)
            value += barrier
            if threatened:
                near = max(hull, LEAST)
                threat = rules.threat / near
                weight = 1.0 if rules.per_node else share
                threats[i] += 0.0 if rules.per_node else threat
                value += weight * threat
                if hull > LEAST:
                    slope -= weight * threat / near
                    curvature += weight * 2.0 * threat / near**2
            if slope != 0.0 or curvature > 0.0:
                _add(by_node, i, (east, north, up), slope, curvature)
    return value


@njit(cache=True, error_model="numpy")
def _bends(steps, rules, smoothing, signs):
    """Return the cost of all turns and climbs, and their angles and derivatives."""
    east, north = steps.east, steps.north
    n = len(signs)
    bends = Bends(np.zeros((n, 2)), np.zeros((n, 2)), np.zeros((n, 2)))
    value = 0.0
    climb = math.atan(steps.rise[0] / steps.flat[0])
    for i in range(1, n - 1):
        before = climb
        climb = math.atan(steps.rise[i] / steps.flat[i])
        bends.angles[i, 0] = math.atan2(
            east[i - 1] * north[i] - north[i - 1] * east[i], east[i - 1] * east[i] + north[i - 1] * north[i]
        )
        bends.angles[i, 1] = climb - before
        for k in range(2):
            angle = bends.angles[i, k]
            rate = rules.climbing if k else rules.turning
            smooth = math.sqrt(angle * angle + smoothing.bend**2)
            value += rate * (smooth - smoothing.bend)
            bends.slope[i, k] = rate * angle / smooth
            bends.curvature[i, k] = rate * (1.0 - signs[i, k] * angle / smooth) / smooth
    return value, bends


@njit(cache=True, error_model="numpy")
def _leg_terms(steps, bends, threats, rules, smoothing, mean_leg, by_step):
    """Add the cost of each leg. A longer leg is a bent one: bend at its begin minus bend at its end."""
    level, leg = steps.level, steps.leg
    value = 0.0
    stretch = smoothing.evenness / mean_leg
    lever = LEVER / mean_leg
    for i in range(len(leg) - 1):
        ahead, left, over = _directions(steps, i)
        price = rules.length + 0.5 * (threats[i] + threats[i + 1])
        value += rules.length * leg[i] + 0.5 * stretch * (leg[i] - mean_leg) ** 2
        _add(by_step, i, ahead, price + stretch * (leg[i] - mean_leg), stretch)
        for k, aside, length in ((0, left, level[i]), (1, over, leg[i])):
            slope = (bends.slope[i, k] - bends.slope[i + 1, k]) / length
            curvature = (bends.curvature[i, k] + bends.curvature[i + 1, k]) / length**2
            _add(by_step, i, aside, slope, price / leg[i] + curvature)
        for sign, greatest in ((1.0, rules.climb_slope), (-1.0, rules.descent_slope)):
            limit = greatest - smoothing.flatter
            slack = limit * level[i] - sign * steps.rise[i] * leg[i]
            barrier, slope, curvature = _barrier(lever * slack, smoothing, mean_leg)
            if curvature > 0.0:
                value += barrier
                steeper = lever * limit * steps.east[i], lever * limit * steps.north[i], -lever * sign
                _add(by_step, i, steeper, slope, curvature)
    return value


@njit(cache=True, error_model="numpy")
def _mixed(steps, bends):
    """Return second derivatives by the step to each node and the step from it, (n, 3, 3)."""
    level, leg = steps.level, steps.leg
    n = len(leg)
    mixed = np.zeros((n, 3, 3))
    for i in range(1, n - 1):
        turn = -bends.curvature[i, 0] / (level[i - 1] * level[i])
        climb = -bends.curvature[i, 1] / (leg[i - 1] * leg[i])
        _, left_before, over_before = _directions(steps, i - 1)
        _, left, over = _directions(steps, i)
        for a in range(3):
            for b in range(3):
                mixed[i, a, b] = turn * left_before[a] * left[b] + climb * over_before[a] * over[b]
    return mixed


@njit(cache=True, error_model="numpy")
def gradient_and_hessian(model, basis, count):
    """Return gradient (3 count,) and Gauss-Newton's Hessian (15, 3 count) by control points, for `solve_banded`."""
    by_node, by_step, mixed = model.by_node, model.by_step, model.mixed
    first = basis.first
    here, before, after = basis.values[0], basis.values[1], basis.values[2]
    n = len(first)
    gradient = np.zeros(3 * count)
    band = np.zeros((15, 3 * count))
    start = 0
    while start < n:
        end = start + 1
        while end < n and first[end] == first[start]:
            end += 1
        fifth = start
        while fifth < end and here[4, fifth] == 0.0 and before[4, fifth] == 0.0 and after[4, fifth] == 0.0:
            fifth += 1
        for k in range(5):
            begin = fifth if k == 4 else start  # few nodes depend on the fifth
            some = range(np.uint64(begin), np.uint64(end))  # unsigned: no index counts from an array's end
            row = 3 * (first[start] + k)
            for axis in range(3):
                total = 0.0
                for i in some:
                    total += here[k, i] * by_node.slope[i, axis] + after[k, i] * by_step.slope[i, axis]
                gradient[row + axis] += total
            for m in range(k + 1):
                column = 3 * (first[start] + m)
                for a in range(3):
                    for b in range(3 if k > m else a + 1):
                        high, low = max(a, b), min(a, b)
                        total = 0.0
                        for i in some:
                            node = here[k, i] * here[m, i] * by_node.curvature[i, high, low]
                            step = after[k, i] * after[m, i] * by_step.curvature[i, high, low]
                            back = before[k, i] * after[m, i]
                            forth = after[k, i] * before[m, i]
                            if a == b:
                                total += node + step + (back + forth) * mixed[i, a, a]
                            else:
                                total += node + step + back * mixed[i, a, b] + forth * mixed[i, b, a]
                        band[row + a - column - b, column + b] += total
        start = end
    return gradient, band


@njit(cache=True, error_model="numpy")
def path_model(nodes, grid, rules, smoothing, mean_leg, signs):
    """Return the smoothed cost of a path and its derivatives.

    `mean_leg` is the mean leg length [m]. `signs` (n, 2), from -1 to 1, are the dual variables of Chan, Golub and Mulet
    (1999): signs of the angles.
    """
    n = len(nodes)
    by_node = Terms(np.zeros((n, 3)), np.zeros((n, 3, 3)))
    by_step = Terms(np.zeros((n, 3)), np.zeros((n, 3, 3)))
    steps = _steps(nodes)
    threats = np.zeros(n)
    value = _position_terms(nodes, steps.leg, threats, grid, rules, smoothing, mean_leg, by_node)
    bent, bends = _bends(steps, rules, smoothing, signs)
    value += bent + _leg_terms(steps, bends, threats, rules, smoothing, mean_leg, by_step)
    return PathModel(value, bends, by_node, by_step, _mixed(steps, bends))


SURE_SIGN = 0.9
LEVENBERG_TRIALS = 6  # of greater damping


@njit(cache=True, error_model="numpy")
def reduced(gradient, band, shifts):
    """Return gradient (f,) and lower band of the Hessian by free coordinates: W^T H W for shifts W."""
    starts, columns, weights = shifts.starts, shifts.columns, shifts.weights
    slope = np.zeros(shifts.free)
    narrow = np.zeros((shifts.band_width + 1, shifts.free))
    for row in range(len(gradient)):
        for k in range(starts[row // 3], starts[row // 3 + 1]):
            slope[3 * columns[k] + row % 3] += weights[k] * gradient[row]
    for below in range(len(band)):
        once = 0.5 if below == 0 else 1.0  # entries off the diagonal count both ways
        for column in range(len(gradient) - below):
            row = column + below
            for k in range(starts[row // 3], starts[row // 3 + 1]):
                a = 3 * columns[k] + row % 3
                for m in range(starts[column // 3], starts[column // 3 + 1]):
                    b = 3 * columns[m] + column % 3
                    share = once * (2.0 if a == b else 1.0)
                    narrow[abs(a - b), min(a, b)] += share * (weights[k] * weights[m]) * band[below, column]
    return slope, narrow


@njit(cache=True, error_model="numpy")
def _moved(control, step, shifts):
    moved = control.copy()
    for point in range(len(control)):
        for axis in range(3):
            change = 0.0
            for k in range(shifts.starts[point], shifts.starts[point + 1]):
                change += shifts.weights[k] * step[3 * shifts.columns[k] + axis]
            moved[point, axis] -= change
    return moved


@njit(cache=True, error_model="numpy")
def _model(control, signs, inputs, grid, rules, smoothing):
    first = inputs.basis.first
    here = inputs.basis.values[0]
    nodes = np.zeros((len(first), 3))
    for k in range(5):
        for i in range(len(nodes)):
            for axis in range(3):
                nodes[i, axis] += here[k, i] * control[first[i] + k, axis]
    return path_model(nodes, grid, rules, smoothing, inputs.mean_leg, signs)


@njit(cache=True, error_model="numpy")
def _updated(signs, angles, changed, bend):
    """Return the signs after a step from `angles` to those `changed`, all (n, 2)."""
    updated = signs.copy()
    for i in range(len(signs)):
        for k in range(2):
            smooth = math.sqrt(angles[i, k] ** 2 + bend**2)
            change = (1.0 - signs[i, k] * angles[i, k] / smooth) * (changed[i, k] - angles[i, k])
            updated[i, k] = min(max((angles[i, k] + change) / smooth, -SURE_SIGN), SURE_SIGN)
    return updated


@njit(cache=True, error_model="numpy")
def minimize_path_model(control, signs, inputs, grid, rules, smoothing, steps, enough):
    """Minimize by Levenberg-Marquardt: damping falls as the model proves right.

    Return the control points (k, 3) and signs (n, 2), after `steps`, or one that gains less than the share `enough`.
    """
    model = _model(control, signs, inputs, grid, rules, smoothing)
    damping = 1e-3
    for _ in range(steps):
        gradient, wide = gradient_and_hessian(model, inputs.basis, len(control))
        slope, band = reduced(gradient, wide, inputs.shifts)
        n = band.shape[1]
        mean = 0.0
        for k in range(n):
            mean += band[0, k] / n
        for _ in range(LEVENBERG_TRIALS):
            damped = band.copy()
            for k in range(n):
                damped[0, k] += damping * band[0, k] + 1e-6 * mean
            step, solved = solve_banded(damped, slope)
            moved = _moved(control, step, inputs.shifts)
            trial = _model(moved, signs, inputs, grid, rules, smoothing)
            better = solved == 1 and trial.value < model.value
            if better:
                break
            damping = max(8.0 * damping, 1e-4)
        if not better:
            break
        gain = model.value - trial.value
        signs = _updated(signs, model.bends.angles, trial.bends.angles, smoothing.bend)
        control = moved
        model = trial
        damping = max(damping / 5.0, 1e-7)
        if gain < enough * abs(model.value):
            break
    return control, signs
