"""What must be fast, compiled: least costs over a lattice."""

# mypy: disable-error-code="no-untyped-def,misc"

import numpy as np
from numba import njit


@njit(cache=True, error_model="numpy")
def spread(price, steps, lengths, source):
    """Least cost from one lattice node to every other, and the node before it on the way, by Dijkstra's algorithm.

    `price` (nx, ny, nz) is the cost per metre at each node, infinite where none may go; a step of `steps` (s, 3) costs
    its length of `lengths` (s,) times the mean of both ends. Nodes are numbered flat; returns (nodes,) and (nodes,).
    """
    nx, ny, nz = price.shape
    flat, total = price.ravel(), nx * ny * nz
    cost, before = np.full(total, np.inf), np.full(total, -1, np.int64)
    keys, nodes, size = np.empty(4 * total + 64), np.empty(4 * total + 64, np.int64), 1
    cost[source], keys[0], nodes[0] = 0.0, 0.0, source
    while size > 0:
        key, here = keys[0], nodes[0]
        size -= 1
        last_key, last, hole = keys[size], nodes[size], 0
        while True:  # sift the last entry down from the top
            child = 2 * hole + 1
            if child >= size:
                break
            if child + 1 < size and keys[child + 1] < keys[child]:
                child += 1
            if keys[child] >= last_key:
                break
            keys[hole], nodes[hole], hole = keys[child], nodes[child], child
        keys[hole], nodes[hole] = last_key, last
        if key > cost[here]:
            continue
        i, j, k = here // (ny * nz), here // nz % ny, here % nz
        for s in range(len(steps)):
            a, b, c = i + steps[s, 0], j + steps[s, 1], k + steps[s, 2]
            if not (0 <= a < nx and 0 <= b < ny and 0 <= c < nz):
                continue
            there = (a * ny + b) * nz + c
            trial = key + lengths[s] * 0.5 * (flat[here] + flat[there])
            if trial < cost[there] and size < len(keys):
                cost[there], before[there] = trial, here
                hole = size
                size += 1
                while hole > 0 and keys[(hole - 1) // 2] > trial:
                    keys[hole], nodes[hole] = keys[(hole - 1) // 2], nodes[(hole - 1) // 2]
                    hole = (hole - 1) // 2
                keys[hole], nodes[hole] = trial, there
    return cost, before
