# mypy: disable-error-code="no-untyped-def,misc"

import math

import numpy as np

from ipoa_mission.compiled import njit
from ipoa_mission.planning._places import FASTMATH, _cell, _distance, _ground, _least_height, _slack_and_threat
from ipoa_mission.planning.obstacle_grid import FENCE, LEAST, UNLIMITED


def _arctangent(terms: int) -> tuple[float, ...]:
    series = np.zeros(2 * terms)
    k = np.arange(terms)
    series[1::2] = 2 * (-1.0) ** k * (math.sqrt(2) - 1) ** (2 * k + 1) / (2 * k + 1)
    return tuple(float(c) for c in np.polynomial.chebyshev.cheb2poly(series)[1::2])


A0, A1, A2, A3, A4, A5, A6, A7, A8, A9 = _arctangent(10)  # accurate to 2e-9 rad


@njit(inline="always")
def _angle(cross, dot, product):
    t = abs(cross) / (product + abs(dot) + 1e-300)
    s = t * t
    series = A0 + s * (A1 + s * (A2 + s * (A3 + s * (A4 + s * (A5 + s * (A6 + s * (A7 + s * (A8 + s * A9))))))))
    half = 2.0 * t * series
    return half if dot >= 0.0 else math.pi - half


@njit(cache=True, fastmath=FASTMATH, error_model="numpy")
def path_costs(points, grid, rules):
    """Return the costs of paths (m, 3, n); a broken limit costs the length, and more with its depth and length."""
    count, _, n = points.shape
    costs = np.empty(count)
    level, leg, rise = np.empty(n - 1), np.empty(n - 1), np.empty(n - 1)
    steps_e, steps_n, cell = np.empty(n - 1), np.empty(n - 1), np.empty(n, np.int32)
    near = max(rules.clearance, rules.d_safe + rules.radius)
    cells, first, listed, top, around, kind, shape, edges, raster, heights, lower, upper, _, low_zones = grid
    west, south, low = lower
    east, north, high = upper
    for c in range(count):
        x, y, z = points[c, 0], points[c, 1], points[c, 2]
        length, depth = 0.0, 0.0
        for i in range(n - 1):
            e, n_, u = x[i + 1] - x[i], y[i + 1] - y[i], z[i + 1] - z[i]
            steps_e[i], steps_n[i], rise[i] = e, n_, u
            level[i] = math.sqrt(e * e + n_ * n_)
            leg[i] = math.sqrt(e * e + n_ * n_ + u * u)
            length += leg[i]
        if min(rules.climb_slope, rules.descent_slope) < UNLIMITED:
            for i in range(n - 1):
                depth += max(rise[i] - rules.climb_slope * level[i], -rise[i] - rules.descent_slope * level[i], 0.0)
        outside = 0.0
        for i in range(n):
            cell[i] = _cell(cells, x[i], y[i])
            outside += max(west - x[i], x[i] - east, 0.0) + max(south - y[i], y[i] - north, 0.0)
            outside += max(low - z[i], z[i] - high, 0.0)
        depth += outside * length / (n - 1)

        threat = 0.0
        for i in range(n):
            share = 0.5 * ((leg[i - 1] if i > 0 else 0.0) + (leg[i] if i < n - 1 else 0.0))
            if z[i] < top[cell[i]]:
                height = z[i] - _ground(raster, heights, x[i], y[i])[0]
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


@njit(cache=True, fastmath=FASTMATH, error_model="numpy")
def slack_and_threat(points, grid, rules):
    """Return slack [m] and threat per meter at points (n, 3), within the grid's reach."""
    n = len(points)
    slack, threat = np.empty(n), np.empty(n)
    for i in range(n):
        slack[i], threat[i] = _slack_and_threat(grid, rules, (points[i, 0], points[i, 1], points[i, 2]))
    return slack, threat


@njit(cache=True, fastmath=FASTMATH, error_model="numpy")
def centered(points, offsets, bounds, grid, rules):
    """Move points (n, 3) within corners to the most slack at offsets (rounds, k, 3), while they may reach the least."""
    lower, upper, least = bounds
    moved = points.copy()
    for i in range(len(moved)):
        best = -np.inf
        for number in range(len(offsets)):
            # the later offsets add up to half of the farthest before
            if number > 0 and best + 0.5 * np.sqrt((offsets[number - 1, -1] ** 2).sum()) < least:
                break
            x, y, z = moved[i, 0], moved[i, 1], moved[i, 2]
            for k in range(offsets.shape[1]):
                e = min(max(x + offsets[number, k, 0], lower[0]), upper[0])
                n = min(max(y + offsets[number, k, 1], lower[1]), upper[1])
                u = min(max(z + offsets[number, k, 2], lower[2]), upper[2])
                slack, _ = _slack_and_threat(grid, rules, (e, n, u), best)
                if slack > best:
                    best, moved[i, 0], moved[i, 1], moved[i, 2] = slack, e, n, u
    return moved


MAX_LEG_SAMPLES = 100  # at most on a leg between two nodes


@njit(inline="always")
def _least_cost_ahead(spacing, i, j, k, rules):
    """Return a bound of the cost of these steps."""
    east, north, up = i * spacing[0], j * spacing[1], k * spacing[2]
    return 0.97 * rules.length * math.sqrt(east * east + north * north + up * up)  # detours cost less


@njit(cache=True, fastmath=FASTMATH, error_model="numpy")
def lattice_costs(nodes, stepping, check_legs, ends, grid, rules):
    """Return the least cost from a lattice node to others (n,), and each predecessor (n,), in the order of A*.

    `ends`: source, target and ratio; nodes on no route of less than `ratio` times the cheapest are not reached. A
    step of `stepping` (steps (s, 3), lengths (s,)) costs its length times the mean price of its ends. `check_legs`: of
    steps, for obstacles.
    """
    steps, lengths = stepping
    source, target, ratio = ends
    places = nodes.places
    price = nodes.price.ravel()
    slack = nodes.slack.ravel()
    nx, ny, nz = nodes.price.shape
    total = nx * ny * nz
    onward = (steps[:, 0] * ny + steps[:, 1]) * nz + steps[:, 2]
    goal_i, goal_j, goal_k = target // (ny * nz), target // nz % ny, target % nz
    cost = np.full(total, np.inf)
    cost[source] = 0.0
    before = np.full(total, -1, np.int64)
    keys = np.empty(4 * total + 64)  # of a heap, least first
    keys[0] = 0.0
    heap = np.empty(4 * total + 64, np.int64)
    heap[0] = source
    size = 1
    most = np.inf
    while size > 0:
        key, here = keys[0], heap[0]
        size -= 1
        last_key, last, hole = keys[size], heap[size], 0
        while True:
            child = 2 * hole + 1
            if child >= size:
                break
            if child + 1 < size and keys[child + 1] < keys[child]:
                child += 1
            if keys[child] >= last_key:
                break
            keys[hole], heap[hole], hole = keys[child], heap[child], child
        keys[hole], heap[hole] = last_key, last
        if key > most:
            break
        reached, i, j, k = cost[here], here // (ny * nz), here // nz % ny, here % nz
        bound = reached + _least_cost_ahead(nodes.spacing, i - goal_i, j - goal_j, k - goal_k, rules)
        if key > bound * (1.0 + 1e-12):  # rounded otherwise
            continue
        if here == target:
            most = ratio * reached
        x, y, z = places[here, 0], places[here, 1], places[here, 2]
        price_here, slack_here = price[here], slack[here]
        for s in range(len(steps)):
            a, b, c = i + steps[s, 0], j + steps[s, 1], k + steps[s, 2]
            if not (0 <= a < nx and 0 <= b < ny and 0 <= c < nz):
                continue
            there = here + onward[s]
            trial = reached + lengths[s] * 0.5 * (price_here + price[there])
            if not trial < cost[there] or size >= len(keys):
                continue
            if check_legs:  # from clearance ball to ball
                e, n, u = places[there, 0] - x, places[there, 1] - y, places[there, 2] - z
                length = math.sqrt(e * e + n * n + u * u)
                least = max(0.5 * rules.clearance, length / MAX_LEG_SAMPLES)
                along, end, free = max(slack_here, least), length - slack[there], True
                while free and along < end:
                    t = along / length
                    slack_there, _ = _slack_and_threat(grid, rules, (x + t * e, y + t * n, z + t * u))
                    free = slack_there >= -0.5 * rules.clearance
                    along += max(slack_there, least)
                if not free:
                    continue
            cost[there], before[there] = trial, here
            trial += _least_cost_ahead(nodes.spacing, a - goal_i, b - goal_j, c - goal_k, rules)
            hole = size
            size += 1
            while hole > 0 and keys[(hole - 1) // 2] > trial:
                keys[hole], heap[hole] = keys[(hole - 1) // 2], heap[(hole - 1) // 2]
                hole = (hole - 1) // 2
            keys[hole], heap[hole] = trial, there
    return cost, before
