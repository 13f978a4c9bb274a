"""The model from which one path is polished, compiled: its smoothed cost, the gradient, and the curvature.

It has a plain NumPy twin that the tests hold it against.
"""

# mypy: disable-error-code="no-untyped-def,misc"

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ipoa_mission.compiled import njit
from ipoa_mission.planning._places import FAST, _cell, _distance, _ground, _least_height
from ipoa_mission.planning.chart import FENCE, LEAST, LEVER


class Terms(NamedTuple):
    """What the terms of the cost are added up in, and how they depend on the control points."""

    gradient: NDArray[np.float64]  # (3 count,)
    band: NDArray[np.float64]  # the lower band of the Hessian, (15, 3 count)
    first: NDArray[np.int64]  # the first control point that a node depends on, (n,)
    window: NDArray[np.float64]  # and its coefficients for the nodes before, at and after it, (n, 3, 5)
    pull: NDArray[np.float64]  # how a term changes with those three nodes, (3, 3)
    flat: NDArray[np.float64]  # and with the control points, (15,)


class Steps(NamedTuple):
    """The legs between nodes: step (n, 3), its level length (n,), its length (n,) [m]."""

    step: NDArray[np.float64]
    level: NDArray[np.float64]
    leg: NDArray[np.float64]


@njit(inline="always")
def _add(terms, i, slope, curvature):
    """Adds a term that changes by `pull` (3, 3) with the nodes before, at and after i.

    Its first derivative is `slope`, its second `curvature`; both are handed on to the five control points, on which
    it depends by `flat` (15,).
    """
    gradient, band, window, pull, flat = terms.gradient, terms.band, terms.window, terms.pull, terms.flat
    base = 3 * terms.first[i]
    for a in range(15):
        k, axis = a // 3, a % 3
        flat[a] = window[i, 0, k] * pull[0, axis] + window[i, 1, k] * pull[1, axis] + window[i, 2, k] * pull[2, axis]
        gradient[base + a] += slope * flat[a]
    if curvature > 0.0:
        for a in range(15):
            here = curvature * flat[a]
            if here != 0.0:
                for b in range(a + 1):
                    band[a - b, base + b] += here * flat[b]


@njit(inline="always")
def _wall(slack, soft, even):
    """What it costs to be so near to a wall, and how that changes with the slack: value, slope and curvature.

    -log(slack / reach), brought smoothly to nothing at `reach`; where it is as stiff as a broken limit should be, and
    beyond, the parabola that touches it there.
    """
    t = slack / soft.reach
    if t >= 1.0:
        return 0.0, 0.0, 0.0
    near = max(t, math.sqrt(soft.wall / soft.stiffness) / soft.reach)
    beyond, slope, curvature = t - near, 2.0 - near - 1.0 / near, 1.0 / near**2 - 1.0
    value = (2.0 - 0.5 * near) * near - 1.5 - math.log(near) + beyond * (slope + 0.5 * curvature * beyond)
    weight = soft.wall * even
    return weight * value, weight * (slope + curvature * beyond) / soft.reach, weight * curvature / soft.reach**2


@njit(cache=True, fastmath=FAST, error_model="numpy")
def _solid(nodes, steps, danger, chart, rules, soft, even, terms):
    """Adds obstacles, ground and bounds at each node; notes in `danger` (n,) what the threats cost a metre."""
    n, leg, pull, value = len(nodes), steps.leg, terms.pull, 0.0
    raster, listed_from, listed, around = chart.cells, chart.first, chart.listed, chart.around
    kind, shape, edges, heights, low_zones = chart.kind, chart.shape, chart.edges, chart.heights, chart.low_zones
    for i in range(n):
        x, y, z = nodes[i, 0], nodes[i, 1], nodes[i, 2]
        pull[0], pull[2] = 0.0, 0.0
        share = 0.5 * ((leg[i - 1] if i > 0 else 0.0) + leg[i])
        cell = _cell(raster, x, y)
        if z < chart.top[cell] + soft.above + soft.reach:
            ground, pull[1, 0], pull[1, 1] = _ground(chart.ground, heights, x, y)
            pull[1, 2] = -1.0
            for sign in (1.0, -1.0):
                if sign > 0.0:
                    slack = rules.ceiling - soft.above - (z - ground)
                else:
                    slack = z - ground - _least_height(low_zones, rules.height + soft.above, x, y)
                wall, slope, curvature = _wall(slack, soft, even)
                if curvature > 0.0:
                    value += wall
                    _add(terms, i, sign * slope, curvature)
        for axis in range(3):
            slack = min(nodes[i, axis] - chart.lower[axis], chart.upper[axis] - nodes[i, axis]) - soft.aside
            wall, slope, curvature = _wall(slack, soft, even)
            if curvature > 0.0:
                pull[1] = 0.0
                pull[1, axis] = -1.0 if 2.0 * nodes[i, axis] > chart.lower[axis] + chart.upper[axis] else 1.0
                value += wall
                _add(terms, i, slope, curvature)
        for k in range(listed_from[cell], listed_from[cell + 1]):
            body = listed[k]
            if not around[body, 3] < z < around[body, 4]:
                continue
            if (x - around[body, 0]) ** 2 + (y - around[body, 1]) ** 2 > around[body, 2]:
                continue
            distance, pull[1, 0], pull[1, 1], pull[1, 2] = _distance(kind, shape, edges, body, x, y, z)
            hull = distance - rules.radius
            threatened = kind[body] != FENCE and hull < rules.d_safe
            slack = distance if kind[body] == FENCE else distance - rules.clearance
            if kind[body] != FENCE and not threatened:  # the end of the threat is a wall from outside
                slack = min(slack, hull - rules.d_safe)
            wall, slope, curvature = _wall(slack - soft.aside, soft, even)
            value += wall
            if threatened:
                near = max(hull, LEAST)
                threat, weight = rules.threat / near, 1.0 if rules.per_node else share
                danger[i] += 0.0 if rules.per_node else threat
                value += weight * threat
                if hull > LEAST:
                    slope -= weight * threat / near
                    curvature += weight * 2.0 * threat / near**2
            if slope != 0.0 or curvature > 0.0:
                _add(terms, i, slope, curvature)
    return value


@njit(cache=True, fastmath=FAST, error_model="numpy")
def _length(steps, danger, rules, soft, even, terms):
    """Adds the length of each leg, which threats make dearer, its even spacing and its climb."""
    step, level, leg, pull, value = steps.step, steps.level, steps.leg, terms.pull, 0.0
    n = len(leg)
    for i in range(n - 1):
        price = rules.length + 0.5 * (danger[i] + danger[i + 1])
        value += rules.length * leg[i] + 0.5 * soft.evenness / even * (leg[i] - even) ** 2
        pull[0] = 0.0
        for axis in range(3):
            pull[2, axis] = step[i, axis] / leg[i]
            pull[1, axis] = -pull[2, axis]
        _add(terms, i, price + soft.evenness / even * (leg[i] - even), soft.evenness / even)
        for across in range(2):  # the two directions in which a longer leg is a bent one
            if across == 0:
                pull[2, 0], pull[2, 1], pull[2, 2] = -step[i, 1] / level[i], step[i, 0] / level[i], 0.0
            else:
                for axis in range(2):
                    pull[2, axis] = -step[i, 2] / leg[i] * step[i, axis] / level[i]
                pull[2, 2] = level[i] / leg[i]
            for axis in range(3):
                pull[1, axis] = -pull[2, axis]
            _add(terms, i, 0.0, price / leg[i])
        for sign, limit in ((1.0, rules.climb - soft.flatter), (-1.0, rules.descent - soft.flatter)):
            slack = limit * level[i] - sign * step[i, 2]
            wall, slope, curvature = _wall(LEVER / even * slack, soft, even)
            if curvature > 0.0:
                for axis in range(2):
                    pull[2, axis] = LEVER / even * limit * step[i, axis] / level[i]
                pull[2, 2] = -LEVER / even * sign
                for axis in range(3):
                    pull[1, axis] = -pull[2, axis]
                value += wall
                _add(terms, i, slope, curvature)
    return value


@njit(cache=True, fastmath=FAST, error_model="numpy")
def _bends(steps, rules, soft, signs, angles, terms):
    """Adds the turn and the change of climb at each inner node; notes them in `angles` (n, 2) [rad]."""
    step, level, leg, pull, value = steps.step, steps.level, steps.leg, terms.pull, 0.0
    n = len(leg)
    for i in range(1, n - 1):
        for upwards in range(2):
            if upwards:
                rate = rules.climbing
                angle = math.atan2(step[i, 2], level[i]) - math.atan2(step[i - 1, 2], level[i - 1])
                for side, row in ((i - 1, 0), (i, 2)):
                    for axis in range(2):
                        pull[row, axis] = -step[side, 2] / leg[side] ** 2 * step[side, axis] / level[side]
                    pull[row, 2] = level[side] / leg[side] ** 2
            else:
                rate = rules.turning
                angle = math.atan2(
                    step[i - 1, 0] * step[i, 1] - step[i - 1, 1] * step[i, 0],
                    step[i - 1, 0] * step[i, 0] + step[i - 1, 1] * step[i, 1],
                )
                for side, row in ((i - 1, 0), (i, 2)):
                    pull[row, 0], pull[row, 1] = -step[side, 1] / level[side] ** 2, step[side, 0] / level[side] ** 2
                    pull[row, 2] = 0.0
            for axis in range(3):  # the leg before ends here, the leg after begins here: both directions count
                pull[1, axis] = -pull[0, axis] - pull[2, axis]
            angles[i, upwards] = angle
            smooth = math.sqrt(angle * angle + soft.bend**2)
            value += rate * (smooth - soft.bend)
            curvature = rate * (1.0 - signs[i, upwards] * angle / smooth) / smooth
            _add(terms, i, rate * angle / smooth, curvature)
    return value


@njit(cache=True, fastmath=FAST, error_model="numpy")
def path_model(nodes, spans, count, chart, rules, soft, even, signs):
    """The smoothed cost of one path, its gradient, and a positive semidefinite model of its Hessian.

    `nodes` (n, 3) depend on `count` control points: node i - 1, i and i + 1 on those from `first[i]` with the
    coefficients `window[i]` (3, 5); `spans` is (first, window). `even` is the length of a leg [m] when all are
    alike. `signs` (n, 2), between -1 and 1, is what is thought of the sign of the turn and of the change of climb
    at each node; the surer, the less an angle resists to being changed (the dual variables of Chan, Golub and Mulet
    1999).

    Returns the value, its gradient (3 count,), the lower band of the Hessian (15, 3 count), `band[i - j, j]` being its
    element i, j, and the angles (n, 2) [rad]. The model is Gauss-Newton's: what bends downwards is left out.
    """
    n, (first, window) = len(nodes), spans
    gradient, band, angles = np.zeros(3 * count), np.zeros((15, 3 * count)), np.zeros((n, 2))
    steps, danger = Steps(np.zeros((n, 3)), np.zeros(n), np.zeros(n)), np.zeros(n)
    terms = Terms(gradient, band, first, window, np.zeros((3, 3)), np.zeros(15))
    for i in range(n - 1):
        for axis in range(3):
            steps.step[i, axis] = nodes[i + 1, axis] - nodes[i, axis]
        steps.level[i] = math.sqrt(steps.step[i, 0] ** 2 + steps.step[i, 1] ** 2) + 1e-9
        steps.leg[i] = math.sqrt(steps.level[i] ** 2 + steps.step[i, 2] ** 2)
    value = _solid(nodes, steps, danger, chart, rules, soft, even, terms)
    value += _length(steps, danger, rules, soft, even, terms)
    value += _bends(steps, rules, soft, signs, angles, terms)
    return value, gradient, band, angles
