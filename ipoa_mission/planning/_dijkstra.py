# mypy: disable-error-code="no-untyped-def,misc"

import math

import numpy as np

from ipoa_mission.compiled import njit
from ipoa_mission.planning._places import FASTMATH, _look

GLANCES = 100  # at most on a leg between two nodes


@njit(inline="always")
def _ahead(nodes, node, target, rules):
    """Return a bound of the cost from a node to the target: loops are a little cheaper than straight climbs."""
    _, ny, nz = nodes.price.shape
    east = (node // (ny * nz) - target // (ny * nz)) * nodes.spacing[0]
    north = (node // nz % ny - target // nz % ny) * nodes.spacing[1]
    up = (node % nz - target % nz) * nodes.spacing[2]
    return 0.97 * rules.length * math.sqrt(east * east + north * north + up * up)


@njit(cache=True, fastmath=FASTMATH, error_model="numpy")
def spread(nodes, steps, lengths, look, source, target, ratio, grid, rules):
    """Return the least cost from lattice node `source` to others (n,), and each predecessor (n,), in the order of A*.

    Nodes on no route to `target` of less than `ratio` times the cheapest are not reached. A step of `steps` (s, 3)
    costs its length of `lengths` (s,) times the mean price of its ends. With `look`, its leg is checked for obstacles.
    """
    places, (nx, ny, nz) = nodes.places, nodes.price.shape
    price, room, total = nodes.price.ravel(), nodes.slack.ravel(), nx * ny * nz
    onward = (steps[:, 0] * ny + steps[:, 1]) * nz + steps[:, 2]
    cost, before = np.full(total, np.inf), np.full(total, -1, np.int64)
    keys, heap, size = np.empty(4 * total + 64), np.empty(4 * total + 64, np.int64), 1
    cost[source], keys[0], heap[0], most = 0.0, 0.0, source, np.inf
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
        reached = cost[here]
        if key > (reached + _ahead(nodes, here, target, rules)) * (1.0 + 1e-12):  # rounded otherwise
            continue
        if here == target:
            most = ratio * reached
        i, j, k = here // (ny * nz), here // nz % ny, here % nz
        x, y, z = places[here, 0], places[here, 1], places[here, 2]
        price_here, room_here = price[here], room[here]
        for s in range(len(steps)):
            a, b, c = i + steps[s, 0], j + steps[s, 1], k + steps[s, 2]
            if not (0 <= a < nx and 0 <= b < ny and 0 <= c < nz):
                continue
            there = here + onward[s]
            trial = reached + lengths[s] * 0.5 * (price_here + price[there])
            if not trial < cost[there] or size >= len(keys):
                continue
            if look:  # from clearance ball to ball
                e, n, u = places[there, 0] - x, places[there, 1] - y, places[there, 2] - z
                length = math.sqrt(e * e + n * n + u * u)
                least = max(0.5 * rules.clearance, length / GLANCES)
                along, end, free = max(room_here, least), length - room[there], True
                while free and along < end:
                    t = along / length
                    spare, _ = _look(grid, rules, x + t * e, y + t * n, z + t * u)
                    free = spare >= -0.5 * rules.clearance
                    along += max(spare, least)
                if not free:
                    continue
            cost[there], before[there] = trial, here
            trial += _ahead(nodes, there, target, rules)
            hole = size
            size += 1
            while hole > 0 and keys[(hole - 1) // 2] > trial:
                keys[hole], heap[hole] = keys[(hole - 1) // 2], heap[(hole - 1) // 2]
                hole = (hole - 1) // 2
            keys[hole], heap[hole] = trial, there
    return cost, before
