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

EE, NE, NN, UE, UN, UU = range(6)


class Derivatives(NamedTuple):
    """First and second derivatives by node or step, or by turn and climb at each node."""

    slope: NDArray[np.float64]  # (3, n), or (2, n)
    curvature: NDArray[np.float64]  # (6, n), `EE` and so on, or (2, n)


class Steps(NamedTuple):
    """Steps from each node to the next, all (n,), 0 for the last.

    Directions: ahead (flat east, flat north, rise), left (-north, east, 0), over (-rise east, -rise north, flat).
    """

    level: NDArray[np.float64]  # [m]
    leg: NDArray[np.float64]  # [m]
    east: NDArray[np.float64]  # per meter of horizontal length
    north: NDArray[np.float64]
    rise: NDArray[np.float64]  # per meter of length
    flat: NDArray[np.float64]  # per meter of length


@njit(inline="always")
def _add(derivatives, i, east, north, up, slope, curvature):
    """Add a term of node or step i along (east, north, up), by its first and second derivative."""
    first, second = derivatives.slope, derivatives.curvature
    first[0, i] += slope * east
    first[1, i] += slope * north
    first[2, i] += slope * up
    second[EE, i] += curvature * east * east
    second[NE, i] += curvature * north * east
    second[NN, i] += curvature * north * north
    second[UE, i] += curvature * up * east
    second[UN, i] += curvature * up * north
    second[UU, i] += curvature * up * up


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
        steps.east[i], steps.north[i] = east / level, north / level
        steps.rise[i], steps.flat[i] = up / leg, level / leg
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
            for sign in (1.0, -1.0):
                if sign > 0.0:
                    slack = rules.ceiling - smoothing.above - (z - ground)
                else:
                    slack = z - ground - _least_height(low_zones, rules.height + smoothing.above, x, y)
                barrier, slope, curvature = _barrier(slack, smoothing, mean_leg)
                if curvature > 0.0:
                    value += barrier
                    _add(by_node, i, east, north, -1.0, sign * slope, curvature)
        for axis in range(3):
            slack = min(nodes[i, axis] - lower[axis], upper[axis] - nodes[i, axis]) - smoothing.aside
            barrier, slope, curvature = _barrier(slack, smoothing, mean_leg)
            if curvature > 0.0:
                inwards = -1.0 if 2.0 * nodes[i, axis] > lower[axis] + upper[axis] else 1.0
                value += barrier
                by_node.slope[axis, i] += inwards * slope
                by_node.curvature[(EE, NN, UU)[axis], i] += curvature
        for k in range(first[cell], first[cell + 1]):
            body = listed[k]
            if not around[body, 3] < z < around[body, 4]:
                continue
            if (x - around[body, 0]) ** 2 + (y - around[body, 1]) ** 2 > around[body, 2]:
                continue
            distance, east, north, up = _distance(kind, shape, edges, body, x, y, z)
            hull = distance - rules.radius
            threatened = kind[body] != FENCE and hull < rules.d_safe
            slack = distance if kind[body] == FENCE else distance - rules.clearance
            if kind[body] != FENCE and not threatened:  # a barrier from outside
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
                _add(by_node, i, east, north, up, slope, curvature)
    return value


@njit(cache=True, error_model="numpy")
def _angle_terms(steps, rules, smoothing, signs, angles):
    east, north = steps.east, steps.north
    n = len(angles)
    by_angle = Derivatives(np.zeros((2, n)), np.zeros((2, n)))
    value = 0.0
    climb = math.atan(steps.rise[0] / steps.flat[0])
    for i in range(1, n - 1):
        before = climb
        climb = math.atan(steps.rise[i] / steps.flat[i])
        angles[i, 0] = math.atan2(
            east[i - 1] * north[i] - north[i - 1] * east[i], east[i - 1] * east[i] + north[i - 1] * north[i]
        )
        angles[i, 1] = climb - before
        for k in range(2):
            angle = angles[i, k]
            rate = rules.climbing if k else rules.turning
            smooth = math.sqrt(angle * angle + smoothing.bend**2)
            value += rate * (smooth - smoothing.bend)
            by_angle.slope[k, i] = rate * angle / smooth
            by_angle.curvature[k, i] = rate * (1.0 - signs[i, k] * angle / smooth) / smooth
    return value, by_angle


@njit(cache=True, error_model="numpy")
def _leg_terms(steps, by_angle, threats, rules, smoothing, mean_leg, by_step):
    """Add the cost of each leg. A longer leg is a bent one: bend at its begin minus bend at its end."""
    level, leg = steps.level, steps.leg
    value = 0.0
    turn, climb = by_angle.slope[0], by_angle.slope[1]
    turns, climbs = by_angle.curvature[0], by_angle.curvature[1]
    stretch = smoothing.evenness / mean_leg
    lever = LEVER / mean_leg
    for i in range(len(leg) - 1):
        east, north, rise, flat = steps.east[i], steps.north[i], steps.rise[i], steps.flat[i]
        price = rules.length + 0.5 * (threats[i] + threats[i + 1])
        value += rules.length * leg[i] + 0.5 * stretch * (leg[i] - mean_leg) ** 2
        _add(by_step, i, flat * east, flat * north, rise, price + stretch * (leg[i] - mean_leg), stretch)
        slope = (turn[i] - turn[i + 1]) / level[i]
        curvature = (turns[i] + turns[i + 1]) / level[i] ** 2
        _add(by_step, i, -north, east, 0.0, slope, price / leg[i] + curvature)
        slope = (climb[i] - climb[i + 1]) / leg[i]
        curvature = (climbs[i] + climbs[i + 1]) / leg[i] ** 2
        _add(by_step, i, -rise * east, -rise * north, flat, slope, price / leg[i] + curvature)
        for sign, greatest in ((1.0, rules.climb_slope), (-1.0, rules.descent_slope)):
            limit = greatest - smoothing.flatter
            slack = limit * level[i] - sign * rise * leg[i]
            barrier, slope, curvature = _barrier(lever * slack, smoothing, mean_leg)
            if curvature > 0.0:
                value += barrier
                _add(by_step, i, lever * limit * east, lever * limit * north, -lever * sign, slope, curvature)
    return value


@njit(cache=True, error_model="numpy")
def _mixed(steps, by_angle):
    """Return second derivatives by the steps before and after, (9, n): EE, EN, EU, NE, ..."""
    level, leg = steps.level, steps.leg
    n = len(leg)
    mixed = np.zeros((9, n))
    for i in range(1, n - 1):
        turn = -by_angle.curvature[0, i] / (level[i - 1] * level[i])
        climb = -by_angle.curvature[1, i] / (leg[i - 1] * leg[i])
        left = (-steps.north[i - 1], steps.east[i - 1]), (-steps.north[i], steps.east[i])
        for a in range(2):
            for b in range(2):
                mixed[3 * a + b, i] = turn * left[0][a] * left[1][b]
        over = (
            (-steps.rise[i - 1] * steps.east[i - 1], -steps.rise[i - 1] * steps.north[i - 1], steps.flat[i - 1]),
            (-steps.rise[i] * steps.east[i], -steps.rise[i] * steps.north[i], steps.flat[i]),
        )
        for a in range(3):
            for b in range(3):
                mixed[3 * a + b, i] += climb * over[0][a] * over[1][b]
    return mixed


@njit(inline="always")
def _block(by_node, by_step, mixed, values, k, m, some):
    """Return second derivatives by control points k and m: EE, EN, EU, NE, ..."""
    here, before, after = values[0], values[1], values[2]
    twice, stepwise = by_node.curvature, by_step.curvature
    ee, en, eu, ne, nn, nu, ue, un, uu = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for i in some:
        place = here[k, i] * here[m, i]
        step = after[k, i] * after[m, i]
        back, forth = before[k, i] * after[m, i], after[k, i] * before[m, i]
        ee += place * twice[EE, i] + step * stepwise[EE, i] + (back + forth) * mixed[0, i]
        nn += place * twice[NN, i] + step * stepwise[NN, i] + (back + forth) * mixed[4, i]
        uu += place * twice[UU, i] + step * stepwise[UU, i] + (back + forth) * mixed[8, i]
        symmetric = place * twice[NE, i] + step * stepwise[NE, i]
        en += symmetric + back * mixed[1, i] + forth * mixed[3, i]
        ne += symmetric + back * mixed[3, i] + forth * mixed[1, i]
        symmetric = place * twice[UE, i] + step * stepwise[UE, i]
        eu += symmetric + back * mixed[2, i] + forth * mixed[6, i]
        ue += symmetric + back * mixed[6, i] + forth * mixed[2, i]
        symmetric = place * twice[UN, i] + step * stepwise[UN, i]
        nu += symmetric + back * mixed[5, i] + forth * mixed[7, i]
        un += symmetric + back * mixed[7, i] + forth * mixed[5, i]
    return (ee, en, eu), (ne, nn, nu), (ue, un, uu)


@njit(cache=True, error_model="numpy")
def gradient_and_hessian(derivatives, basis, count):
    """Return gradient (3 count,) and Gauss-Newton's Hessian (15, 3 count) by control points, for `solve_banded`."""
    by_node, by_step, steps, by_angle = derivatives
    first, values = basis
    here, before, after = values[0], values[1], values[2]
    mixed = _mixed(steps, by_angle)
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
                    total += here[k, i] * by_node.slope[axis, i] + after[k, i] * by_step.slope[axis, i]
                gradient[row + axis] += total
            for m in range(k + 1):
                block = _block(by_node, by_step, mixed, values, k, m, some)
                column = 3 * (first[start] + m)
                for a in range(3):
                    for b in range(3 if k > m else a + 1):
                        band[row + a - column - b, column + b] += block[a][b]
        start = end
    return gradient, band


@njit(cache=True, error_model="numpy")
def path_model(nodes, grid, rules, smoothing, mean_leg, signs):
    """Return the smoothed cost of a path, its angles (n, 2) [rad], and its derivatives.

    `mean_leg` is the mean leg length [m]. `signs` (n, 2), from -1 to 1, are the dual variables of Chan, Golub and Mulet
    (1999): signs of the angles.
    """
    n = len(nodes)
    by_node = Derivatives(np.zeros((3, n)), np.zeros((6, n)))
    by_step = Derivatives(np.zeros((3, n)), np.zeros((6, n)))
    steps = _steps(nodes)
    threats = np.zeros(n)
    angles = np.zeros((n, 2))
    value = _position_terms(nodes, steps.leg, threats, grid, rules, smoothing, mean_leg, by_node)
    bent, by_angle = _angle_terms(steps, rules, smoothing, signs, angles)
    value += bent + _leg_terms(steps, by_angle, threats, rules, smoothing, mean_leg, by_step)
    return value, angles, (by_node, by_step, steps, by_angle)


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
    basis, _, mean_leg = inputs
    here = basis.values[0]
    nodes = np.zeros((len(basis.first), 3))
    for k in range(5):
        for i in range(len(nodes)):
            for axis in range(3):
                nodes[i, axis] += here[k, i] * control[basis.first[i] + k, axis]
    return path_model(nodes, grid, rules, smoothing, mean_leg, signs)


@njit(cache=True, error_model="numpy")
def minimize_path_model(control, signs, inputs, grid, rules, smoothing, until):
    """Minimize by Levenberg-Marquardt: damping falls as the model proves right.

    Return the control points (k, 3) and signs (n, 2). `until`: the most steps, and the gain of the last as a share.
    """
    steps, enough = until
    value, angles, derivatives = _model(control, signs, inputs, grid, rules, smoothing)
    damping = 1e-3
    for _ in range(steps):
        gradient, wide = gradient_and_hessian(derivatives, inputs.basis, len(control))
        slope, band = reduced(gradient, wide, inputs.shifts)
        n = band.shape[1]
        better = False
        mean = 0.0
        for k in range(n):
            mean += band[0, k] / n
        for _ in range(LEVENBERG_TRIALS):
            damped = band.copy()
            for k in range(n):
                damped[0, k] += damping * band[0, k] + 1e-6 * mean
            step, solved = solve_banded(damped, slope)
            trial = _moved(control, step, inputs.shifts)
            trial_value, trial_angles, derivatives = _model(trial, signs, inputs, grid, rules, smoothing)
            if solved == 1 and trial_value < value:
                better = True
                break
            damping = max(8.0 * damping, 1e-4)
        if not better:
            break
        gain = value - trial_value
        turned = signs.copy()
        for i in range(len(signs)):
            for k in range(2):
                smooth = math.sqrt(angles[i, k] ** 2 + smoothing.bend**2)
                change = (1.0 - signs[i, k] * angles[i, k] / smooth) * (trial_angles[i, k] - angles[i, k])
                turned[i, k] = min(max((angles[i, k] + change) / smooth, -SURE_SIGN), SURE_SIGN)
        signs, control, value, angles = turned, trial, trial_value, trial_angles
        damping = max(damping / 5.0, 1e-7)
        if gain < enough * abs(value):
            break
    return control, signs
