"""Propose places at the gaps between obstacles to the lattice."""

from collections.abc import Iterator
from itertools import pairwise

import numpy as np
import shapely
from numpy.typing import NDArray

from ipoa_mission.geometry import Plane, Points, Vector
from ipoa_mission.planning.problem import PreparedProblem
from ipoa_mission.world.airspace import Airspace

REACH_BEYOND = 1.5  # behind a gap, in cells
LONGEST_GAP = 20.0  # extent of a gap, in cells
LEAST_GAP = 1e-6  # [m]


def gap_places(problem: PreparedProblem, widest: float, cell: float, heights: Vector) -> Iterator[Points]:
    """Yield, for each of `heights`, places (k, 3) before, in and behind the gaps up to `widest` [m]."""
    shapes, radii, required, levels = _outlines(problem.task.airspace, problem.limits.obstacle_distance)
    tree = shapely.STRtree(shapely.envelope(shapely.buffer(shapes, radii, quad_segs=4)))
    first, second = tree.query(tree.geometries, "dwithin", widest)
    first, second = first[first < second], second[first < second]
    ends = shapely.get_coordinates(shapely.shortest_line(shapes[first], shapes[second])).reshape(-1, 2, 2)
    across = ends[:, 1] - ends[:, 0]
    apart = np.linalg.norm(across, axis=1)
    width = apart - radii[first] - radii[second]
    gaps = (width > LEAST_GAP) & (width < widest)
    first, second, width = first[gaps], second[gaps], width[gaps]
    across = across[gaps] / apart[gaps, None]
    middle = ends[gaps, 0] + across * (radii[first] + (width + required[first] - required[second]) / 2)[:, None]
    ahead = np.column_stack([-across[:, 1], across[:, 0]])
    length = np.minimum(_extent(shapes[first], ahead, radii[first]), _extent(shapes[second], ahead, radii[second]))
    either_way = np.ceil(2 * (np.minimum(length / cell, LONGEST_GAP) + REACH_BEYOND)).astype(int)
    lowest = np.maximum(levels[first, 0], levels[second, 0])
    highest = np.minimum(levels[first, 1], levels[second, 1])
    count = 2 * either_way + 1
    gap = np.repeat(np.arange(len(count)), count)
    along = np.arange(len(gap)) - np.repeat(np.cumsum(count) - count + either_way, count)
    level_places = middle[gap] + 0.5 * cell * along[:, None] * ahead[gap]
    for height in heights:
        crossed = ((lowest <= height) & (height <= highest))[gap]
        yield np.column_stack([level_places[crossed], np.full(np.count_nonzero(crossed), height)])


def _extent(shapes: NDArray[np.object_], ahead: Plane, radii: Vector) -> Vector:
    """Return the length of grown shapes along directions (n, 2), (n,) [m]."""
    west, south, east, north = shapely.bounds(shapes).T
    return np.asarray(np.abs(ahead[:, 0]) * (east - west) + np.abs(ahead[:, 1]) * (north - south) + 2 * radii)


def _outlines(airspace: Airspace, distance: float) -> tuple[NDArray[np.object_], Vector, Vector, NDArray[np.float64]]:
    """Return plane shapes, radii, required distances, and heights (k, 2)."""
    outlines: list[tuple[shapely.Geometry, float, float, float, float]] = []
    for body in airspace.obstacles:
        column = body.column
        if column is not None:
            outlines.append((column.shape, column.radius, distance, column.base, column.top))
    sides = pairwise(shapely.get_coordinates(airspace.bounds.area.exterior))
    outlines += [(shapely.LineString(side), 0.0, 0.0, -np.inf, np.inf) for side in sides]
    shapes, *numbers = zip(*outlines, strict=True)
    radii, required, base, top = np.array(numbers)
    return np.array(shapes), radii, required, np.column_stack([base, top])
