"""Boustrophedon cells, each swept in one of several ways, and their order as a generalized traveling salesman's.

As Baehnemann and others have it (arXiv 1907.09224), written anew from the paper: the cells of that edge's direction in
which their widths add up to the least; every cell but one at a shared edge draws back by a line's distance; a cell is
swept along each edge across which it is monotone, from either side, to and fro; sweeps begin at the outermost corner
and end at the other one; ways lead round the holes. The order of cells and their sweeps is sought by moving, flipping
and exchanging cells, the best sweeps of an order by dynamic programming.
"""

import math
from collections.abc import Iterator
from functools import lru_cache
from itertools import pairwise

import numpy as np
import shapely

from ipoa_mission.geometry import Points, Vector
from ipoa_mission.survey.area import Area
from ipoa_mission.survey.free import FreeSpace, Ways
from ipoa_mission.survey.times import LegTimes

SAME = 1e-6  # [m]
ROUNDS = 30  # without a better order


def cells_of(polygon: shapely.Polygon, along: Vector) -> list[shapely.Polygon]:
    """The boustrophedon cells of a line that is swept along a direction, itself at a right angle to it."""
    turn = np.array([along, [-along[1], along[0]]])  # x is what the line moves along
    rings = [shapely.get_coordinates(ring) @ turn.T for ring in shapely.get_rings(polygon)]
    edges = np.concatenate([np.column_stack([ring[:-1], ring[1:]]) for ring in rings])
    events = np.unique(np.round(np.concatenate([ring[:, 0] for ring in rings]), 6))
    open_: list[tuple[list[Points], tuple[float, float]]] = []  # trapezoids of a cell, its last side
    cells: list[list[Points]] = []
    for left, right in pairwise(map(float, events)):
        sides = [_sides(edges, x, (left + right) / 2) for x in (left, right)]
        slabs = [(sides[0][n], sides[0][n + 1], sides[1][n], sides[1][n + 1]) for n in range(0, len(sides[0]), 2)]
        meets = [[k for k, (_, side) in enumerate(open_) if _overlap(side, slab[:2]) > SAME] for slab in slabs]
        onward: list[tuple[list[Points], tuple[float, float]]] = []
        for slab, met in zip(slabs, meets, strict=True):
            shape = np.array([[left, slab[0]], [right, slab[2]], [right, slab[3]], [left, slab[1]]])
            alone = len(met) == 1 and sum(met[0] in other for other in meets) == 1
            cell = open_[met[0]][0] if alone else []
            if not alone:
                cells.append(cell)
            cell.append(shape @ turn)
            onward.append((cell, (slab[2], slab[3])))
        open_ = onward
    return [part for cell in cells if (part := _union(cell)).geom_type == "Polygon" and part.area > SAME]


def _union(cell: list[Points]) -> shapely.Polygon:
    whole = shapely.union_all([shapely.Polygon(part).buffer(1e-7, join_style="mitre") for part in cell])
    return whole.buffer(-1e-7, join_style="mitre").simplify(1e-6)


def _sides(edges: Points, at: float, middle: float) -> list[float]:
    """Where the edges that cross a middle line are at another, in their order there."""
    low, high = np.minimum(edges[:, 0], edges[:, 2]), np.maximum(edges[:, 0], edges[:, 2])
    a, b = edges[(low < middle) & (high > middle)].reshape(-1, 2, 2).transpose(1, 0, 2)
    slope = (b[:, 1] - a[:, 1]) / (b[:, 0] - a[:, 0])
    order = np.argsort(a[:, 1] + slope * (middle - a[:, 0]))
    return [float(y) for y in (a[:, 1] + slope * (at - a[:, 0]))[order]]


def _overlap(side: tuple[float, float], other: tuple[float, ...]) -> float:
    return min(side[1], other[1]) - max(side[0], other[0])


def _directions(polygon: shapely.Polygon) -> list[Vector]:
    """Those of the edges, each once, as unit vectors."""
    found: list[Vector] = []
    for ring in shapely.get_rings(polygon):
        for step in np.diff(shapely.get_coordinates(ring), axis=0):
            along = step / max(float(np.linalg.norm(step)), 1e-12)
            if all(abs(along[0] * other[1] - along[1] * other[0]) > 1e-9 for other in found):
                found.append(along)
    return found


def _sweepable(cell: shapely.Polygon) -> Iterator[tuple[float, Vector]]:
    """Widths and directions of the edges across which a cell is monotone."""
    ring = shapely.get_coordinates(cell.exterior)[:-1]
    for along in _directions(cell):
        across = ring @ np.array([-along[1], along[0]])
        signs = np.sign(np.round(np.diff(across, append=across[0]), 6))
        signs = signs[signs != 0]
        if (signs != np.roll(signs, 1)).sum() <= 2:
            yield float(np.ptp(across)), along


@lru_cache(maxsize=64)  # both autopilots fly the same map
def _cells(polygon: shapely.Polygon) -> list[shapely.Polygon]:
    """Those of the direction in which the least widths of all cells add up to the least."""
    best, least = list[shapely.Polygon](), math.inf
    for along in _directions(polygon):
        cells = cells_of(polygon, np.array([-along[1], along[0]]))
        widths = [min((width for width, _ in _sweepable(cell)), default=math.inf) for cell in cells]
        if cells and sum(widths) < least:
            best, least = cells, sum(widths)
    return best


def _drawn_back(cells: list[shapely.Polygon], distance: float) -> list[shapely.Polygon]:
    """The cells, one of two that share an edge farther from it."""
    back = list(cells)
    for n, cell in enumerate(cells):
        for other in cells[:n]:
            shared = shapely.intersection(cell, other)
            if shared.length < SAME or shared.geom_type != "LineString":
                continue
            smaller = back[n].difference(shared.buffer(distance, cap_style="square", join_style="mitre"))
            if smaller.geom_type == "Polygon" and not smaller.is_empty:
                back[n] = smaller
    return back


def _sweeps(cell: shapely.Polygon, distance: float) -> list[Points]:
    """All ways to sweep a cell, as polylines."""
    inner = cell.buffer(-1e-6)
    found = []
    for _, along in _sweepable(cell):
        across = np.array([-along[1], along[0]])
        corners = shapely.get_coordinates(cell) @ across
        low, high = float(corners.min()), float(corners.max())
        at = np.append(np.arange(low, high, distance), high)
        lines = []
        for y in np.clip(at, low + 1e-4, high - 1e-4):
            reach = shapely.get_coordinates(cell) @ along
            line = np.array([along * reach.min() + across * y, along * reach.max() + across * y])
            met = shapely.get_coordinates(shapely.LineString(line).intersection(inner if len(at) < 3 else cell))
            if len(met) > 1:
                lines.append(met[np.argsort(met @ along)][[0, -1]])
        for first in (0, 1):
            there = [line[:: 1 if (n + first) % 2 == 0 else -1] for n, line in enumerate(lines)]
            if there:
                whole = np.concatenate(there)
                found += [whole, whole[::-1]]
    if not found:
        spot = shapely.get_coordinates(cell.representative_point())
        found = [np.repeat(spot, 2, axis=0)]
    return found


def sweep_cells(area: Area, distance: float, cost: LegTimes, place: Vector, seed: int = 1) -> Points:
    """The path (n, 2) that sees an area, from a place and back to it; the sensor is on all the way."""
    polygon = area.shape.geoms[0]
    space = FreeSpace.of(polygon.buffer(0.03, join_style="mitre"))  # sweeps lie on the edge
    sweeps = [_sweeps(cell, distance) for cell in _drawn_back(_cells(polygon), distance)]
    flat = [sweep for each in sweeps for sweep in each]
    ends = np.array([end for sweep in flat for end in (sweep[0], sweep[-1])] + [place, place])
    ways = Ways(np.ascontiguousarray(ends), space, space, cost)
    first = np.cumsum([0, *map(len, sweeps)])
    own = np.array([cost.seconds(sweep) for sweep in flat])
    groups = [np.arange(first[n], first[n + 1]) for n in range(len(sweeps))]
    home = len(flat)
    enter = ways.times[2 * home, 0 : 2 * home : 2]
    leave = ways.times[1 : 2 * home : 2, 2 * home]
    between = ways.times[1 : 2 * home : 2, 0 : 2 * home : 2] + own[None, :]

    def chosen(order: list[int]) -> tuple[float, list[int]]:
        total, backs = enter[groups[order[0]]] + own[groups[order[0]]], []
        for before, after in pairwise(order):
            through = total[:, None] + between[np.ix_(groups[before], groups[after])]
            backs.append(through.argmin(axis=0))
            total = through.min(axis=0)
        total = total + leave[groups[order[-1]]]
        at = int(total.argmin())
        picked, seconds = [at], float(total[at])
        for back in backs[::-1]:
            at = int(back[at])
            picked.append(at)
        return seconds, [int(groups[cell][k]) for cell, k in zip(order, picked[::-1], strict=True)]

    order = _ordered(len(groups), chosen, seed)
    _, picked = chosen(order)
    path, at = [place[None]], 2 * home
    for sweep in picked:
        path += [_corners(ways, at, 2 * sweep), flat[sweep]]
        at = 2 * sweep + 1
    return np.concatenate([*path, _corners(ways, at, 2 * home), place[None]])


def _corners(ways: Ways, i: int, j: int) -> Points:
    return ways.way(i, j)[1:-1] if (ways.ends[i] != ways.ends[j]).any() else np.empty((0, 2))


def _ordered(count: int, chosen: object, seed: int) -> list[int]:
    """A quick order of cells."""
    assert callable(chosen)
    rng = np.random.default_rng(seed)
    order: list[int] = [0]
    for cell in range(1, count):  # where it costs the least
        order = min(([*order[:k], cell, *order[k:]] for k in range(len(order) + 1)), key=lambda o: float(chosen(o)[0]))
    best, failed = float(chosen(order)[0]), 0
    while failed < ROUNDS * count and count > 1:
        i, j = sorted(int(k) for k in rng.integers(0, count + 1, 2))
        rest = order[:i] + order[j:]
        k = int(rng.integers(0, len(rest) + 1))
        moved = order[i:j][:: int(rng.choice([1, -1]))]
        other = rest[:k] + moved + rest[k:]
        seconds = float(chosen(other)[0])
        failed += 1
        if seconds < best - 1e-9:
            order, best, failed = other, seconds, 0
    return order
