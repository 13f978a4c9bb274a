import math
from itertools import pairwise

import numpy as np
import pytest
import shapely
from scipy.sparse import coo_array
from scipy.sparse.csgraph import dijkstra

from ipoa_mission.autopilot.autopilot import registered
from ipoa_mission.geodesy import Geodetic
from ipoa_mission.geometry import Points, Vector
from ipoa_mission.mission.items import Mission
from ipoa_mission.survey._kernels import path_seconds, search_order
from ipoa_mission.survey.free import FreeSpace, Transits
from ipoa_mission.survey.times import LegTimes

ROUNDS = 200


def least(times: Points, lines: Vector) -> float:
    """Return the least cost of all orders and senses, by dynamic programming over sets (Held and Karp)."""
    count = len(lines) // 2
    costs = {(1 << (e >> 1), e): times[2 * count, e] + lines[e] for e in range(2 * count)}
    for _ in range(count - 1):
        onward = dict[tuple[int, int], float]()
        for (done, entry), cost in costs.items():
            for e in range(2 * count):
                if not done >> (e >> 1) & 1:
                    key = done | 1 << (e >> 1), e
                    onward[key] = min(onward.get(key, math.inf), cost + times[entry ^ 1, e] + lines[e])
        costs = onward
    return min(cost + times[entry ^ 1, 2 * count] for (_, entry), cost in costs.items())


@pytest.mark.parametrize("seed", range(12))
def test_an_order_is_as_quick_as_the_best_of_all(seed: int) -> None:
    """Ways there and back differ, as in a wind."""
    rng = np.random.default_rng(seed)
    count = int(rng.integers(2, 9))
    ends = rng.uniform(0.0, 100.0, (2 * count + 2, 2))
    times = np.linalg.norm(ends[:, None] - ends[None], axis=2) * rng.uniform(1.0, 1.3, (2 * count + 2, 2 * count + 2))
    lines = rng.uniform(1.0, 20.0, 2 * count)
    entries, cost = search_order(times, lines, ROUNDS)
    assert sorted(entries >> 1) == list(range(count))
    flown = times[2 * count, entries[0]] + times[entries[-1] ^ 1, 2 * count] + lines[entries].sum()
    flown += sum(times[a ^ 1, b] for a, b in pairwise(entries))
    assert cost == pytest.approx(flown)
    assert least(times, lines) - 1e-9 <= cost <= 1.01 * least(times, lines)


def test_one_line_alone_is_an_order() -> None:
    entries, cost = search_order(np.array([[9.0] * 4] * 2 + [[3.0, 1.0, 0.0, 0.0]] * 2), np.ones(2), 5)
    assert entries.tolist() == [1]
    assert cost == 1.0 + 1.0 + 9.0


def test_ways_lead_round_holes_and_are_as_short_as_a_grid_finds_them() -> None:
    walls = [
        shapely.box(20.0, 0.0, 24.0, 70.0),
        shapely.box(50.0, 30.0, 54.0, 100.0),
        shapely.Point(75.0, 40.0).buffer(9.0),
    ]
    shape = shapely.box(0.0, 0.0, 100.0, 100.0).difference(shapely.union_all(walls))
    cost = LegTimes.of(Mission(Geodetic(47.4, 8.5, 488.0), (), registered()[0]), 5.0)
    space = FreeSpace.of(shape)
    places = np.array([[5.0, 5.0], [35.0, 5.0], [40.0, 90.0], [90.0, 10.0], [95.0, 90.0], [65.0, 40.0]])
    ways = Transits(np.repeat(places, 2, axis=0), space, space, cost)
    shortest = on_a_grid(shape, places)
    for i in range(len(places)):
        for j in range(len(places)):
            if i == j:
                continue
            corners = ways.corners(2 * i, 2 * j)
            assert shape.covers(shapely.LineString(corners))
            length = float(np.linalg.norm(np.diff(corners, axis=0), axis=1).sum())
            assert 0.97 * shortest[i, j] <= length <= shortest[i, j] + 0.5
            assert ways.times[2 * i, 2 * j] == pytest.approx(path_seconds(cost.table, corners))


def on_a_grid(shape: shapely.Geometry, places: Points) -> Points:
    """Return distances from post to post a meter apart, by sixteen directions."""
    posts = np.array([(x, y) for x in range(101) for y in range(101)], float)
    free = shapely.covers(shape, shapely.points(posts))
    starts, ends, lengths = list[int](), list[int](), list[float]()
    steps = [(1, 0), (0, 1), (1, 1), (1, -1), (2, 1), (1, 2), (2, -1), (1, -2)]
    for east, north in steps:
        there = posts + np.array([east, north])
        inside = free & (there >= 0).all(axis=1) & (there <= 100).all(axis=1)
        onward = np.where(inside, there[:, 0] * 101 + there[:, 1], 0).astype(int)
        inside &= free[onward]
        first = np.flatnonzero(inside)
        clear = shapely.covers(shape, shapely.linestrings(np.stack([posts[first], posts[onward[first]]], axis=1)))
        starts += list(first[clear])
        ends += list(onward[first][clear])
        lengths += [math.hypot(east, north)] * int(clear.sum())
    graph = coo_array((lengths, (starts, ends)), shape=(len(posts), len(posts)))
    numbers = (places[:, 0] * 101 + places[:, 1]).astype(int)
    return np.asarray(dijkstra(graph.tocsr(), directed=False, indices=numbers)[:, numbers])
