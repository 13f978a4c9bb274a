"""What must be fast, compiled: the cost of many candidate paths, and the model from which one path is polished.

Each has a plain NumPy twin that the tests hold it against. Obstacles, ground and weights come as `Chart` and `Rules`;
what is called at every node is handed single arrays and rasters, because handing on a chart counts references to it.
"""

# mypy: disable-error-code="no-untyped-def,misc"

import math

import numpy as np
from numba import njit

from ipoa_mission.planning.chart import FENCE, LEAST, LEVER, STEEP
from ipoa_mission.world.obstacles.obstacle import CYLINDER, SPHERE

FAST = {"reassoc", "contract", "arcp", "nsz"}  # lets sums be vectorised


def _arctangent(terms: int) -> tuple[float, ...]:
    """Coefficients of t, t^3, ... of arctan on [0, 1]: its Chebyshev series."""
    series = np.zeros(2 * terms)
    k = np.arange(terms)
    series[1::2] = 2 * (-1.0) ** k * (math.sqrt(2) - 1) ** (2 * k + 1) / (2 * k + 1)
    return tuple(float(c) for c in np.polynomial.chebyshev.cheb2poly(series)[1::2])


A0, A1, A2, A3, A4, A5, A6, A7, A8, A9 = _arctangent(10)  # good to 2e-9 rad


@njit(inline="always")
def _angle(cross, dot, product):
    """The angle between two vectors from |cross|, dot and the product of their lengths: half-angle and a series."""
    t = abs(cross) / (product + abs(dot) + 1e-300)
    s = t * t
    series = A0 + s * (A1 + s * (A2 + s * (A3 + s * (A4 + s * (A5 + s * (A6 + s * (A7 + s * (A8 + s * A9))))))))
    half = 2.0 * t * series
    return half if dot >= 0.0 else math.pi - half


@njit(inline="always")
def _on_map(raster, x, y):
    """Column and row of a place, fractions included; beyond the map the nearest ones, and 0 for what is no number."""
    u, v = (x - raster.east) * raster.per_metre, (y - raster.north) * raster.per_metre
    u, v = u if u > 0.0 else 0.0, v if v > 0.0 else 0.0
    return min(u, raster.columns - 1.0), min(v, raster.rows - 1.0)


@njit(inline="always")
def _ground(raster, heights, x, y):
    """Bilinear height of the ground, and its slopes along east and north."""
    u, v = _on_map(raster, x, y)
    i, j = min(int(u), raster.columns - 2), min(int(v), raster.rows - 2)
    u, v = u - i, v - j
    south, north = heights[j, i + 1] - heights[j, i], heights[j + 1, i + 1] - heights[j + 1, i]
    low, high = heights[j, i] + u * south, heights[j + 1, i] + u * north
    return low + v * (high - low), ((1.0 - v) * south + v * north) * raster.per_metre, (high - low) * raster.per_metre


@njit(inline="always")
def _cell(raster, x, y):
    """The number of the cell at a place; beyond the map the nearest one."""
    u, v = _on_map(raster, x, y)
    return np.int32(np.floor(v) * raster.columns + np.floor(u))


@njit(inline="always")
def _least_height(low_zones, height, x, y):
    """The height above ground that is required here."""
    for k in range(low_zones.shape[0]):
        if (x - low_zones[k, 0]) ** 2 + (y - low_zones[k, 1]) ** 2 <= low_zones[k, 2] ** 2:
            height = min(height, low_zones[k, 3])
    return height


@njit(inline="always")
def _aside(kind, shape, edges, body, x, y):
    """Signed distance to an upright obstacle's outline in the plane, and its direction (east, north)."""
    if kind[body] == CYLINDER:
        e, n = x - shape[body, 0], y - shape[body, 1]
        r = math.sqrt(e * e + n * n) + 1e-12
        aside = r - shape[body, 2]
    else:
        e, n, nearest, inside = 0.0, 0.0, 1e300, False
        for k in range(int(shape[body, 0]), int(shape[body, 1])):
            e0, n0, e1, n1 = edges[k, 0], edges[k, 1], edges[k, 2], edges[k, 3]
            share = ((x - e0) * (e1 - e0) + (y - n0) * (n1 - n0)) / ((e1 - e0) ** 2 + (n1 - n0) ** 2)
            share = min(max(share, 0.0), 1.0)
            away_e, away_n = x - e0 - share * (e1 - e0), y - n0 - share * (n1 - n0)
            square = away_e * away_e + away_n * away_n
            if square < nearest:
                nearest, e, n = square, away_e, away_n
            if (n0 > y) != (n1 > y) and x < e0 + (y - n0) / (n1 - n0) * (e1 - e0):
                inside = not inside
        r = math.sqrt(nearest) + 1e-12
        if inside != (kind[body] == FENCE):  # within a prism, or beyond a fence
            r = -r
        aside = r
    return aside, e / r, n / r


@njit(inline="always")
def _distance(kind, shape, edges, body, x, y, z):
    """Signed distance to an obstacle, and the direction in which it grows (east, north, up)."""
    if kind[body] == SPHERE:
        e, n, u = x - shape[body, 0], y - shape[body, 1], z - shape[body, 2]
        r = math.sqrt(e * e + n * n + u * u) + 1e-12
        distance, e, n, u = r - shape[body, 3], e / r, n / r, u / r
    else:
        distance, e, n = _aside(kind, shape, edges, body, x, y)
        under, over = shape[body, 3] - z, z - shape[body, 4]
        above, u = max(under, over), 0.0
        if distance > 0.0 and above > 0.0:  # over a rim
            r = math.sqrt(distance * distance + above * above)
            e, n, u = e * distance / r, n * distance / r, (above if over > under else -above) / r
            distance = r
        elif above > distance:
            distance, e, n, u = above, 0.0, 0.0, 1.0 if over > under else -1.0
    return distance, e, n, u


@njit(cache=True, fastmath=FAST, error_model="numpy")
def path_costs(points, chart, rules):
    """Cost of each of many paths; `points` is (m, 3, n): east, north, up of n nodes.

    A path that breaks a limit costs its length, `rules.collision`, and more the deeper and the longer it does.
    """
    count, _, n = points.shape
    costs = np.empty(count)
    level, leg, rise = np.empty(n - 1), np.empty(n - 1), np.empty(n - 1)
    steps_e, steps_n, cell = np.empty(n - 1), np.empty(n - 1), np.empty(n, np.int32)
    near = max(rules.clearance, rules.d_safe + rules.radius)
    raster, first, listed, top, kind, shape, edges = (
        chart.cells,
        chart.first,
        chart.listed,
        chart.top,
        chart.kind,
        chart.shape,
        chart.edges,
    )
    around, heights, low_zones = chart.around, chart.heights, chart.low_zones
    (west, south, low), (east, north, high) = chart.lower, chart.upper
    for c in range(count):
        x, y, z = points[c, 0], points[c, 1], points[c, 2]
        length, depth = 0.0, 0.0
        for i in range(n - 1):
            e, n_, u = x[i + 1] - x[i], y[i + 1] - y[i], z[i + 1] - z[i]
            steps_e[i], steps_n[i], rise[i] = e, n_, u
            level[i] = math.sqrt(e * e + n_ * n_)
            leg[i] = math.sqrt(e * e + n_ * n_ + u * u)
            length += leg[i]
        if min(rules.climb, rules.descent) < STEEP:
            for i in range(n - 1):
                depth += max(rise[i] - rules.climb * level[i], -rise[i] - rules.descent * level[i], 0.0)
        outside = 0.0
        for i in range(n):
            cell[i] = _cell(raster, x[i], y[i])
            outside += max(west - x[i], x[i] - east, 0.0) + max(south - y[i], y[i] - north, 0.0)
            outside += max(low - z[i], z[i] - high, 0.0)
        depth += outside * length / (n - 1)

        threat = 0.0
        for i in range(n):
            share = 0.5 * ((leg[i - 1] if i > 0 else 0.0) + (leg[i] if i < n - 1 else 0.0))
            if z[i] < top[cell[i]]:
                height = z[i] - _ground(chart.ground, heights, x[i], y[i])[0]
                depth += share * max(
                    _least_height(low_zones, rules.height, x[i], y[i]) - height, height - rules.ceiling, 0.0
                )
            for k in range(first[cell[i]], first[cell[i] + 1]):
                body = listed[k]
                if not around[body, 3] < z[i] < around[body, 4]:
                    continue
                if (x[i] - around[body, 0]) ** 2 + (y[i] - around[body, 1]) ** 2 > around[body, 2]:
                    continue
                distance = _distance(kind, shape, edges, body, x[i], y[i], z[i])[0]
                if kind[body] == FENCE:
                    depth += share * max(-distance, 0.0)
                elif distance < near:
                    depth += share * max(rules.clearance - distance, 0.0)
                    distance -= rules.radius
                    if distance < rules.d_safe:
                        threat += (1.0 if rules.per_node else share) / max(distance, LEAST)
        costs[c] = rules.length * length
        if depth > 0.0:
            costs[c] += rules.collision + rules.depth * depth
            continue

        turning, climbing = 0.0, 0.0
        for i in range(n - 2):
            a, b, c_, d = steps_e[i], steps_n[i], steps_e[i + 1], steps_n[i + 1]
            turning += _angle(a * d - b * c_, a * c_ + b * d, level[i] * level[i + 1])
            a, b, c_, d = level[i], rise[i], level[i + 1], rise[i + 1]
            climbing += _angle(a * d - b * c_, a * c_ + b * d, leg[i] * leg[i + 1])
        costs[c] += rules.turning * turning + rules.climbing * climbing + rules.threat * threat
    return costs


@njit(inline="always")
def _add(gradient, band, window, i, base, pull, flat, slope, curvature):
    """Adds a term that changes by `pull` (3, 3) with the nodes before, at and after i.

    Its first derivative is `slope`, its second `curvature`; both are handed on to the five control points, on which
    it depends by `flat` (15,).
    """
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
def path_model(nodes, first, window, count, chart, rules, soft, even, signs):
    """The smoothed cost of one path, its gradient, and a positive semidefinite model of its Hessian.

    `nodes` (n, 3) depend on `count` control points: node i - 1, i and i + 1 on those from `first[i]` with the
    coefficients `window[i]` (3, 5). `even` is the length of a leg [m] when all are alike. `signs` (n, 2), between -1
    and 1, is what is thought of the sign of the turn and of the change of climb at each node; the surer, the less an
    angle resists to being changed (the dual variables of Chan, Golub and Mulet 1999).

    Returns the value, its gradient (3 count,), the lower band of the Hessian (15, 3 count), `band[i - j, j]` being its
    element i, j, and the angles (n, 2) [rad]. The model is Gauss-Newton's: what bends downwards is left out.
    """
    n = len(nodes)
    raster, listed_from, listed, around = chart.cells, chart.first, chart.listed, chart.around
    kind, shape, edges, heights, low_zones = chart.kind, chart.shape, chart.edges, chart.heights, chart.low_zones
    value, gradient, band, angles = 0.0, np.zeros(3 * count), np.zeros((15, 3 * count)), np.zeros((n, 2))
    step, level, leg, danger = np.zeros((n, 3)), np.zeros(n), np.zeros(n), np.zeros(n)
    pull, flat = np.zeros((3, 3)), np.zeros(15)
    for i in range(n - 1):
        for axis in range(3):
            step[i, axis] = nodes[i + 1, axis] - nodes[i, axis]
        level[i] = math.sqrt(step[i, 0] ** 2 + step[i, 1] ** 2) + 1e-9
        leg[i] = math.sqrt(level[i] ** 2 + step[i, 2] ** 2)

    # Obstacles, ground and bounds at each node
    for i in range(n):
        x, y, z, base = nodes[i, 0], nodes[i, 1], nodes[i, 2], 3 * first[i]
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
                    _add(gradient, band, window, i, base, pull, flat, sign * slope, curvature)
        for axis in range(3):
            slack = min(nodes[i, axis] - chart.lower[axis], chart.upper[axis] - nodes[i, axis]) - soft.aside
            wall, slope, curvature = _wall(slack, soft, even)
            if curvature > 0.0:
                pull[1] = 0.0
                pull[1, axis] = -1.0 if 2.0 * nodes[i, axis] > chart.lower[axis] + chart.upper[axis] else 1.0
                value += wall
                _add(gradient, band, window, i, base, pull, flat, slope, curvature)
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
                _add(gradient, band, window, i, base, pull, flat, slope, curvature)

    # Length of each leg (which threats make dearer), even spacing, climb limits
    for i in range(n - 1):
        base = 3 * first[i]
        price = rules.length + 0.5 * (danger[i] + danger[i + 1])
        value += rules.length * leg[i] + 0.5 * soft.evenness / even * (leg[i] - even) ** 2
        pull[0] = 0.0
        for axis in range(3):
            pull[2, axis] = step[i, axis] / leg[i]
            pull[1, axis] = -pull[2, axis]
        _add(
            gradient,
            band,
            window,
            i,
            base,
            pull,
            flat,
            price + soft.evenness / even * (leg[i] - even),
            soft.evenness / even,
        )
        for across in range(2):  # the two directions in which a longer leg is a bent one
            if across == 0:
                pull[2, 0], pull[2, 1], pull[2, 2] = -step[i, 1] / level[i], step[i, 0] / level[i], 0.0
            else:
                for axis in range(2):
                    pull[2, axis] = -step[i, 2] / leg[i] * step[i, axis] / level[i]
                pull[2, 2] = level[i] / leg[i]
            for axis in range(3):
                pull[1, axis] = -pull[2, axis]
            _add(gradient, band, window, i, base, pull, flat, 0.0, price / leg[i])
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
                _add(gradient, band, window, i, base, pull, flat, slope, curvature)

    # Turning and climbing at each inner node
    for i in range(1, n - 1):
        base = 3 * first[i]
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
            _add(gradient, band, window, i, base, pull, flat, rate * angle / smooth, curvature)
    return value, gradient, band, angles


@njit(inline="always")
def _look(
    cells, first, listed, around, kind, shape, edges, raster, heights, zones, lower, upper, reach, rules, x, y, z
):
    """How much a place has more than required of everything solid [m], and the threat there per metre."""
    ground, threat = _ground(raster, heights, x, y)[0], 0.0
    spare = min(z - ground - _least_height(zones, rules.height, x, y), rules.ceiling - (z - ground))
    spare = min(spare, reach - rules.clearance)
    if not (lower[0] <= x <= upper[0] and lower[1] <= y <= upper[1] and lower[2] <= z <= upper[2]):
        spare = -np.inf
    cell = _cell(cells, x, y)
    for k in range(first[cell], first[cell + 1]):
        body = listed[k]
        if not around[body, 3] < z < around[body, 4]:
            continue
        if (x - around[body, 0]) ** 2 + (y - around[body, 1]) ** 2 > around[body, 2]:
            continue
        distance = _distance(kind, shape, edges, body, x, y, z)[0]
        if kind[body] == FENCE:
            spare = min(spare, distance)
            continue
        spare = min(spare, distance - rules.clearance)
        if distance - rules.radius < rules.d_safe:
            threat += rules.threat / max(distance - rules.radius, LEAST)
    return spare, threat


@njit(cache=True, fastmath=FAST, error_model="numpy")
def survey(points, chart, rules):
    """For each point (n, 3) how much it has more than required of everything solid [m], and the threat there per metre.

    Obstacles farther than the chart's reach count as at its edge.
    """
    n = len(points)
    cells, first, listed, around = chart.cells, chart.first, chart.listed, chart.around
    kind, shape, edges, raster, heights = chart.kind, chart.shape, chart.edges, chart.ground, chart.heights
    zones, lower, upper, reach = chart.low_zones, chart.lower, chart.upper, chart.reach
    slack, threat = np.empty(n), np.empty(n)
    for i in range(n):
        x, y, z = points[i, 0], points[i, 1], points[i, 2]
        slack[i], threat[i] = _look(
            cells, first, listed, around, kind, shape, edges, raster, heights, zones, lower, upper, reach,
            rules, x, y, z,
        )  # fmt: skip
    return slack, threat
